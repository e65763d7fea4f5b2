#include "drivers/pca9685/watchdog.hpp"

#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <thread>

#include "drivers/pca9685/chip.hpp"

namespace polyarm::drivers {

namespace {
using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr milliseconds kBetweenTries{5};

class Watch {
 public:
  Watch(const WatchdogSettings& settings, int socket, I2cBus& bus)
      : settings_(settings), socket_(socket), chip_(bus) {}

  int run() {
    tell_ready();
    for (;;) {
      switch (listen(left())) {
        case Heard::something:
          break;
        case Heard::nothing:
          if (armed_ && Clock::now() >= deadline_) trip();
          break;
        case Heard::quit:
          return chip_.off() ? 1 : 0;
        case Heard::end:
          return off_at_any_cost() ? 0 : 1;
      }
    }
  }

 private:
  enum class Heard { something, nothing, quit, end };

  void tell_ready() {
    char message[1 + sizeof(pid_t)] = {static_cast<char>(WatchdogWord::ready)};
    const pid_t self = getpid();
    std::memcpy(message + 1, &self, sizeof self);
    tell(message, sizeof message);
  }

  /// Nobody may be there any more; the next listen() finds out.
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
    if (ready == 0) return Heard::nothing;
    if (ready < 0) return errno == EINTR ? Heard::something : Heard::end;
    char word[16];
    const ssize_t size = recv(socket_, word, sizeof word, MSG_DONTWAIT);
    if (size < 0) return errno == EAGAIN || errno == EINTR ? Heard::something : Heard::end;
    if (size == 0) return Heard::end;
    return take(static_cast<WatchdogWord>(word[0]));
  }

  Heard take(WatchdogWord word) {
    if (word == WatchdogWord::quit) return Heard::quit;
    if (word == WatchdogWord::disarm) armed_ = false;
    if (word == WatchdogWord::arm) armed_ = true;
    deadline_ = Clock::now() + milliseconds(settings_.timeout_ms);
    return Heard::something;
  }

  bool driver_is_gone() const {
    pollfd asked{socket_, 0, 0};
    return poll(&asked, 1, 0) > 0 && (asked.revents & POLLHUP) != 0;
  }

  /// While the driver lives, whatever it takes; after its end as long as it is worth it.
  bool off_at_any_cost() {
    Clock::time_point end = Clock::now() + milliseconds(settings_.give_up_ms);
    while (chip_.off()) {
      std::this_thread::sleep_for(kBetweenTries);
      if (!driver_is_gone()) end = Clock::now() + milliseconds(settings_.give_up_ms);
      if (Clock::now() >= end) return false;
    }
    return true;
  }

  /// Told first: a driver that goes on just now shall not find the chip asleep and wonder.
  void trip() {
    armed_ = false;
    const char word = static_cast<char>(WatchdogWord::tripped);
    tell(&word, 1);
    do {
      if (!off_at_any_cost()) return;
      std::this_thread::sleep_for(microseconds(settings_.pulse_us) + milliseconds(1));
    } while (chip_.sleep());
  }

  const WatchdogSettings& settings_;
  int socket_;
  Pca9685 chip_;
  bool armed_ = false;
  Clock::time_point deadline_;
};

template <typename Number>
bool number(const char* text, Number& out) {
  const char* end = text + std::strlen(text);
  const auto result = std::from_chars(text, end, out);
  return result.ec == std::errc() && result.ptr == end;
}
}  // namespace

std::string text_of(const WatchdogSettings& s) {
  return s.bus + " " + std::to_string(s.address) + " " + std::to_string(s.timeout_ms) + " " +
         std::to_string(s.pulse_us) + " " + std::to_string(s.give_up_ms);
}

bool settings_from(int argc, char** argv, WatchdogSettings& s) {
  if (argc != 6) return false;
  s.bus = argv[1];
  return !s.bus.empty() && number(argv[2], s.address) && number(argv[3], s.timeout_ms) &&
         number(argv[4], s.pulse_us) && number(argv[5], s.give_up_ms) && s.timeout_ms > 0 && s.pulse_us > 0;
}

void become_watchdog() {
  // Handed over to a child, which then belongs to nobody: the driver has no process to bury.
  const pid_t child = fork();
  if (child != 0) _exit(child < 0 ? 1 : 0);
  setsid();
  for (const int signal : {SIGINT, SIGHUP, SIGTERM, SIGQUIT, SIGPIPE, SIGTSTP}) ::signal(signal, SIG_IGN);
  syscall(SYS_close_range, kWatchdogSocket + 1, ~0U, 0);
  // As far as the machine allows: before the others, and never paged out.
  sched_param first{};
  first.sched_priority = 1;
  if (sched_setscheduler(0, SCHED_FIFO, &first) != 0) errno = 0;
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) errno = 0;
}

int watch(const WatchdogSettings& settings, int socket, const BusOpener& open) {
  BusFailure failure;
  const std::unique_ptr<I2cBus> bus = open(settings.bus, settings.address, failure);
  if (!bus) {
    const char word = static_cast<char>(WatchdogWord::no_bus);
    return send(socket, &word, 1, MSG_NOSIGNAL) < 0 ? 2 : 1;
  }
  return Watch(settings, socket, *bus).run();
}

}  // namespace polyarm::drivers
