#include "drivers/watchdog/link.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "polyarm/base/installation.hpp"

extern char** environ;

namespace polyarm::watchdog {

namespace {
constexpr int kStartTimeout_ms = 10'000, kEndTimeout_ms = 2'000;
/// After this many consecutive heartbeats that find the queue full, the watchdog counts as hung.
constexpr int kUnheard = 4;

/// Heartbeats per watchdog timeout.
constexpr double kBeats = 8;

/// Copies of descriptors, moved away from the numbers that the child expects.
class OutOfTheWay {
 public:
  explicit OutOfTheWay(int first, std::span<const int> others) {
    copy(first);
    for (const int fd : others) copy(fd);
  }
  ~OutOfTheWay() {
    for (const int fd : copies_)
      if (fd >= 0) close(fd);
  }
  OutOfTheWay(const OutOfTheWay&) = delete;
  OutOfTheWay& operator=(const OutOfTheWay&) = delete;
  const std::vector<int>& copies() const { return copies_; }

 private:
  void copy(int fd) { copies_.push_back(fcntl(fd, F_DUPFD_CLOEXEC, 64)); }
  std::vector<int> copies_;
};

/// Starts the program with the socket and the handed descriptors as 3 and on, the null device as 0 to 2, and
/// default signals.
bool spawn(const std::string& program, std::vector<std::string>& words, const std::vector<int>& descriptors) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  if (posix_spawn_file_actions_init(&actions) != 0) return false;
  if (posix_spawnattr_init(&attributes) != 0) {
    posix_spawn_file_actions_destroy(&actions);
    return false;
  }
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  bool ok = true;
  for (std::size_t k = 0; k < descriptors.size(); ++k)
    ok = descriptors[k] >= 0 &&
         posix_spawn_file_actions_adddup2(&actions, descriptors[k], kSocket + static_cast<int>(k)) == 0 && ok;
  for (int fd = 0; fd < 3; ++fd)
    ok = posix_spawn_file_actions_addopen(&actions, fd, "/dev/null", O_RDWR, 0) == 0 && ok;
  ok = posix_spawnattr_setsigmask(&attributes, &none) == 0 && ok;
  ok = posix_spawnattr_setsigdefault(&attributes, &all) == 0 && ok;
  ok = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF) == 0 && ok;
  pid_t child = 0;
  ok = ok && posix_spawn(&child, program.c_str(), &actions, &attributes, argv.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (!ok) return false;
  int status = 0;  // this process ends immediately; its child is the watchdog
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}
}  // namespace

std::string find_program(const char* name) {
  std::error_code error;
  for (const auto& folder : installation::program_folders(reinterpret_cast<const void*>(&find_program)))
    if (std::filesystem::exists(folder / name, error)) return (folder / name).string();
  return {};
}

std::string sentence(Health health, const Names& names) {
  switch (health) {
    case Health::missing:
      return std::string("the program ") + names.program +
             " cannot be started; it belongs beside the driver, install both";
    case Health::not_ready:
      return "the watchdog of " + names.device + " has not answered; is the machine overloaded?";
    case Health::cannot_open:
      return "the watchdog cannot open " + names.path + "; it needs the rights this process has";
    case Health::gone:
      return "the watchdog of " + names.device + " has ended; " + names.safe + ", configure it again";
    case Health::deaf:
      return "the watchdog of " + names.device + " does not run; " + names.safe + ", configure it again";
    case Health::tripped:
      return "this process did not run for more than " + std::to_string(names.timeout_ms) +
             " ms, and the watchdog has " + names.made +
             "; see that nothing is in the way, then configure and activate it again";
    case Health::fine:
      break;
  }
  return {};
}

Health Link::start(const std::string& program, std::vector<std::string> words, std::span<const int> handed) {
  stop();
  int ends[2];
  if (program.empty()) return Health::missing;
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return Health::missing;
  // A short queue, so that a watchdog that does not read is detected soon.
  const int queue = 1;  // the kernel raises it to its minimum, a few messages
  if (setsockopt(ends[0], SOL_SOCKET, SO_SNDBUF, &queue, sizeof queue) != 0) errno = 0;
  socket_ = ends[0];
  bool spawned = false;
  {
    const OutOfTheWay descriptors(ends[1], handed);
    close(ends[1]);
    spawned = spawn(program, words, descriptors.copies());
  }
  const Health health = spawned ? wait_ready() : Health::missing;
  if (health != Health::fine) abandon();
  return health;
}

Health Link::wait_ready() {
  pollfd waiting{socket_, POLLIN, 0};
  int ready = 0;
  while ((ready = poll(&waiting, 1, kStartTimeout_ms)) < 0 && errno == EINTR) {
  }
  if (ready <= 0) return Health::not_ready;
  char message[1 + sizeof(pid_t)] = {};
  const ssize_t size = recv(socket_, message, sizeof message, 0);
  if (size == 1 && message[0] == static_cast<char>(Word::no_device)) return Health::cannot_open;
  if (size != sizeof message || message[0] != static_cast<char>(Word::ready)) return Health::missing;
  pid_t process = 0;
  std::memcpy(&process, message + 1, sizeof process);
  process_ = process;
  unreceived_ = 0;
  return Health::fine;
}

Health Link::say(Word word) noexcept {
  const char byte = static_cast<char>(word);
  if (send(socket_, &byte, 1, MSG_DONTWAIT | MSG_NOSIGNAL) == 1) return Health::fine;
  return errno == EAGAIN || errno == EWOULDBLOCK ? Health::deaf : Health::gone;
}

void Link::expect(int timeout_ms, double period) noexcept {
  beat_every_ = static_cast<std::uint64_t>(
      std::max(1.0, std::floor(timeout_ms * 1e-3 / kBeats / std::max(period, 1e-6))));
}

Health Link::arm() noexcept {
  since_beat_ = 0;
  return say(Word::arm);
}

Health Link::beat() noexcept {
  if (++since_beat_ < beat_every_) return Health::fine;
  since_beat_ = 0;
  const Health health = say(Word::beat);
  unreceived_ = health == Health::deaf ? unreceived_ + 1 : 0;
  return health == Health::deaf && unreceived_ < kUnheard ? Health::fine : health;
}

Health Link::listen() noexcept {
  char word[1 + sizeof(pid_t)];
  const ssize_t size = recv(socket_, word, sizeof word, MSG_DONTWAIT);
  if (size > 0) return word[0] == static_cast<char>(Word::tripped) ? Health::tripped : Health::fine;
  if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return Health::fine;
  return Health::gone;
}

void Link::abandon() noexcept {
  if (socket_ >= 0) close(std::exchange(socket_, -1));
  process_ = 0;
}

void Link::stop() noexcept {
  if (socket_ < 0) return;
  if (say(Word::quit) == Health::fine) {
    pollfd waiting{socket_, POLLIN, 0};
    char word[8];
    // Ignores further messages; its end is the end of the socket.
    while (poll(&waiting, 1, kEndTimeout_ms) > 0 && recv(socket_, word, sizeof word, MSG_DONTWAIT) > 0) {
    }
  }
  abandon();
}

}  // namespace polyarm::watchdog
