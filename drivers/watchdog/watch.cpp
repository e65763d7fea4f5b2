#include "drivers/watchdog/watch.hpp"

#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

namespace polyarm::watchdog {

namespace {
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kBetweenTries{5};

class Watch {
 public:
  Watch(int socket, const Patience& patience, const MakingSafe& safe)
      : socket_(socket), wait_limit_(patience), safe_(safe) {}

  int run() {
    tell_ready();
    while (!hopeless_) {
      switch (listen(left())) {
        case Heard::nothing:
          if (armed_ && Clock::now() >= deadline_) trip();
          break;
        case Heard::end:
          return stop_at_any_cost() ? 0 : 1;
        case Heard::word:
          take();
          if (word_ == Word::make_safe) stop_at_any_cost();
          break;
      }
      if (quit_) return !safe_.leave || safe_.leave() ? 0 : 1;
    }
    return 1;
  }

 private:
  enum class Heard { nothing, word, end };

  void tell_ready() {
    char message[1 + sizeof(pid_t)] = {static_cast<char>(Word::ready)};
    const pid_t self = getpid();
    std::memcpy(message + 1, &self, sizeof self);
    tell(message, sizeof message);
  }

  /// The other side may have ended; the next listen() detects it.
  void tell(const void* message, std::size_t size) {
    if (send(socket_, message, size, MSG_NOSIGNAL | MSG_DONTWAIT) < 0) return;
  }

  int left() const {
    if (!armed_) return -1;
    const auto time = std::chrono::ceil<milliseconds>(deadline_ - Clock::now()).count();
    return time > 0 ? static_cast<int>(time) : 0;
  }

  Heard listen(int timeout_ms) {
    pollfd waiting{socket_, POLLIN, 0};
    const int ready = poll(&waiting, 1, timeout_ms);
    if (ready < 0 && errno != EINTR) return Heard::end;
    if (ready <= 0) return Heard::nothing;
    char word[16];
    const ssize_t size = recv(socket_, word, sizeof word, MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return Heard::nothing;
    if (size <= 0) return Heard::end;
    word_ = static_cast<Word>(word[0]);
    return Heard::word;
  }

  void take() {
    quit_ = quit_ || word_ == Word::quit;
    if (word_ == Word::arm) armed_ = true;
    if (word_ == Word::disarm || word_ == Word::make_safe) armed_ = false;
    deadline_ = Clock::now() + milliseconds(wait_limit_.timeout_ms);
  }

  bool driver_is_gone() const {
    pollfd asked{socket_, 0, 0};
    return poll(&asked, 1, 0) > 0 && (asked.revents & POLLHUP) != 0;
  }

  /// Repeats the attempts until the device is safe or the driver takes over. After the driver has ended,
  /// gives up after `give_up_ms`. Returns true if the device is safe.
  bool stop_at_any_cost() {
    Clock::time_point end = Clock::now() + milliseconds(wait_limit_.give_up_ms);
    for (;;) {
      const Attempt attempt = safe_.stop();
      if (attempt == Attempt::done) return true;
      hopeless_ = attempt == Attempt::hopeless;
      if (hopeless_) return false;
      if (driver_is_gone()) {
        std::this_thread::sleep_for(kBetweenTries);
        if (Clock::now() >= end) return false;
        continue;
      }
      end = Clock::now() + milliseconds(wait_limit_.give_up_ms);
      if (listen(kBetweenTries.count()) != Heard::word) continue;
      take();
      if (word_ == Word::quit || word_ == Word::disarm) return false;
    }
  }

  void trip() {
    armed_ = false;
    const char word = static_cast<char>(Word::tripped);
    tell(&word, 1);
    do {
      if (!stop_at_any_cost()) return;
    } while (safe_.shut && !safe_.shut());
  }

  int socket_;
  const Patience& wait_limit_;
  const MakingSafe& safe_;
  Word word_ = Word::beat;
  bool armed_ = false, quit_ = false, hopeless_ = false;
  Clock::time_point deadline_;
};
}  // namespace

void become_watchdog(int handed) {
  // Becomes an orphan, so the driver has no child process to wait for.
  const pid_t child = fork();
  if (child != 0) _exit(child < 0 ? 1 : 0);
  setsid();
  for (const int signal : {SIGINT, SIGHUP, SIGTERM, SIGQUIT, SIGPIPE, SIGTSTP}) ::signal(signal, SIG_IGN);
  syscall(SYS_close_range, kSocket + handed + 1, ~0U, 0);
  // As far as the system allows: real-time priority, and never paged out.
  sched_param first{};
  first.sched_priority = 1;
  if (sched_setscheduler(0, SCHED_FIFO, &first) != 0) errno = 0;
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) errno = 0;
}

int watch(int socket, const Patience& patience, const MakingSafe& safe) {
  return Watch(socket, patience, safe).run();
}

int watch_nothing(int socket) {
  const char word = static_cast<char>(Word::no_device);
  return send(socket, &word, 1, MSG_NOSIGNAL) < 0 ? 2 : 1;
}

}  // namespace polyarm::watchdog
