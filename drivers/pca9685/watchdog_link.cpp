#include "drivers/pca9685/watchdog_link.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "polyarm/base/text.hpp"

extern char** environ;

namespace polyarm::drivers {

namespace {
constexpr int kStartTimeout_ms = 10'000, kEndTimeout_ms = 2'000;
/// So many heartbeats in a row may find the queue full.
constexpr int kUnheard = 4;

using Health = WatchdogLink::Health;

/// The program with the socket as descriptor 3, the null device as 0 to 2, and signals as they were at birth.
bool spawn(const std::string& program, const WatchdogSettings& settings, int socket) {
  std::vector<std::string> words = split_words(text_of(settings));
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
  ok = posix_spawn_file_actions_adddup2(&actions, socket, kWatchdogSocket) == 0 && ok;
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
  int status = 0;  // this one ends at once, its child is the watchdog
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}
}  // namespace

std::string find_watchdog() {
  namespace fs = std::filesystem;
  Dl_info self{};
  if (dladdr(reinterpret_cast<void*>(&find_watchdog), &self) == 0 || !self.dli_fname) return {};
  std::error_code error;
  const fs::path here = fs::absolute(self.dli_fname, error).parent_path();
  for (const fs::path& folder :
       {here, here / "drivers", here.parent_path() / "drivers", here.parent_path() / "lib" / "polyarm"})
    if (fs::exists(folder / "polyarm_pca9685_watchdog", error))
      return (folder / "polyarm_pca9685_watchdog").string();
  return {};
}

Health WatchdogLink::start(const std::string& program, const WatchdogSettings& settings) {
  stop();
  int ends[2];
  if (program.empty() || settings.bus.find_first_of(" \t\r\n") != std::string::npos) return Health::missing;
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return Health::missing;
  // A short queue, so that a watchdog that does not listen is found out soon.
  const int queue = 1;  // the kernel makes it the least it has, a few messages
  if (setsockopt(ends[0], SOL_SOCKET, SO_SNDBUF, &queue, sizeof queue) != 0) errno = 0;
  socket_ = ends[0];
  const bool spawned = spawn(program, settings, ends[1]);
  close(ends[1]);
  const Health health = spawned ? wait_ready() : Health::missing;
  if (health != Health::fine) abandon();
  return health;
}

Health WatchdogLink::wait_ready() {
  pollfd waiting{socket_, POLLIN, 0};
  int ready = 0;
  while ((ready = poll(&waiting, 1, kStartTimeout_ms)) < 0 && errno == EINTR) {
  }
  if (ready <= 0) return Health::not_ready;
  char message[1 + sizeof(pid_t)] = {};
  const ssize_t size = recv(socket_, message, sizeof message, 0);
  if (size == 1 && message[0] == static_cast<char>(WatchdogWord::no_bus)) return Health::cannot_open;
  if (size != sizeof message || message[0] != static_cast<char>(WatchdogWord::ready)) return Health::missing;
  pid_t process = 0;
  std::memcpy(&process, message + 1, sizeof process);
  process_ = process;
  unheard_ = 0;
  return Health::fine;
}

Health WatchdogLink::say(WatchdogWord word) noexcept {
  const char byte = static_cast<char>(word);
  if (send(socket_, &byte, 1, MSG_DONTWAIT | MSG_NOSIGNAL) == 1) return Health::fine;
  return errno == EAGAIN || errno == EWOULDBLOCK ? Health::deaf : Health::gone;
}

Health WatchdogLink::beat() noexcept {
  const Health health = say(WatchdogWord::beat);
  unheard_ = health == Health::deaf ? unheard_ + 1 : 0;
  return health == Health::deaf && unheard_ < kUnheard ? Health::fine : health;
}

Health WatchdogLink::listen() noexcept {
  char word[1 + sizeof(pid_t)];
  const ssize_t size = recv(socket_, word, sizeof word, MSG_DONTWAIT);
  if (size > 0) return word[0] == static_cast<char>(WatchdogWord::tripped) ? Health::tripped : Health::fine;
  if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return Health::fine;
  return Health::gone;
}

void WatchdogLink::abandon() noexcept {
  if (socket_ >= 0) close(std::exchange(socket_, -1));
  process_ = 0;
}

void WatchdogLink::stop() noexcept {
  if (socket_ < 0) return;
  if (say(WatchdogWord::quit) == Health::fine) {
    pollfd waiting{socket_, POLLIN, 0};
    char word[8];
    // What it still says is passed over; its end is the end of the socket.
    while (poll(&waiting, 1, kEndTimeout_ms) > 0 && recv(socket_, word, sizeof word, MSG_DONTWAIT) > 0) {
    }
  }
  abandon();
}

}  // namespace polyarm::drivers
