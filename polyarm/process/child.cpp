#include "polyarm/process/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/base/installation.hpp"
#include "polyarm/base/printable.hpp"

extern char** environ;

namespace polyarm::process {

namespace {
namespace fs = std::filesystem;

/// Descriptors are first copied to numbers from 64 up, away from those that the child expects.
constexpr int kOutOfTheWay = 64, kFirstHanded = 3;
constexpr std::size_t kMostWords = 1000, kMostReported = 300;

std::vector<fs::path> folders() {
  return installation::program_folders(reinterpret_cast<const void*>(&find_program));
}

class SpawnPlan {
 public:
  SpawnPlan() {
    ready_ = ::posix_spawn_file_actions_init(&actions_) == 0 && ::posix_spawnattr_init(&attributes_) == 0;
    sigset_t none, all;
    ::sigemptyset(&none);
    ::sigfillset(&all);
    want(::posix_spawnattr_setsigmask(&attributes_, &none));
    want(::posix_spawnattr_setsigdefault(&attributes_, &all));
    want(::posix_spawnattr_setpgroup(&attributes_, 0));
    want(::posix_spawnattr_setflags(&attributes_,
                                    POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP));
  }
  ~SpawnPlan() {
    ::posix_spawn_file_actions_destroy(&actions_);
    ::posix_spawnattr_destroy(&attributes_);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  void hand_null(int as, int flags) {
    want(::posix_spawn_file_actions_addopen(&actions_, as, "/dev/null", flags, 0));
  }
  void hand(int descriptor, int as) {
    copies_.emplace_back(::fcntl(descriptor, F_DUPFD_CLOEXEC, kOutOfTheWay));
    want(copies_.back().number() < 0
             ? errno
             : ::posix_spawn_file_actions_adddup2(&actions_, copies_.back().number(), as));
  }
  /// Returns 0 or the error number.
  int spawn(const std::string& program, std::vector<std::string>& words, pid_t& process) {
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    if (!ready_) return error_ != 0 ? error_ : ENOMEM;
    return ::posix_spawn(&process, program.c_str(), &actions_, &attributes_, argv.data(), environ);
  }

 private:
  void want(int error) {
    if (error == 0) return;
    ready_ = false;
    error_ = error;
  }
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
  std::vector<Descriptor> copies_;
  bool ready_ = true;
  int error_ = 0;
};

}  // namespace

std::string find_program(const std::string& name) {
  std::error_code error;
  for (const fs::path& folder : folders())
    if (fs::is_regular_file(folder / name, error)) return (folder / name).string();
  return {};
}

std::string program_folders() {
  std::string out;
  for (const fs::path& folder : folders()) out += (out.empty() ? "" : ", ") + folder.string();
  return out;
}

std::string Ending::text() const {
  std::string out;
  const char* name = ::sigabbrev_np(signal);
  if (signal != 0)
    out = "was ended by " + (name ? std::string("SIG").append(name) : "signal " + std::to_string(signal));
  else
    out = "ended with code " + std::to_string(code);
  return last_words.empty() ? out : out + " (" + last_words + ")";
}

void Child::start(const std::string& program, std::vector<std::string> words, std::span<const int> handed) {
  kill();
  words_.clear();
  const auto refuse = [&](int error) {
    throw Error("no-process", program + " cannot be started: " + std::strerror(error),
                "look whether it may be executed, and at the limits of processes and open files (ulimit -a)");
  };
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) refuse(errno);
  errors_ = Descriptor(ends[0]);
  const Descriptor write_end(ends[1]);
  SpawnPlan plan;
  for (std::size_t i = 0; i < handed.size(); ++i) plan.hand(handed[i], kFirstHanded + static_cast<int>(i));
  plan.hand_null(STDIN_FILENO, O_RDONLY);
  plan.hand_null(STDOUT_FILENO, O_WRONLY);
  plan.hand(write_end.number(), STDERR_FILENO);
  if (const int error = plan.spawn(program, words, process_); error != 0) {
    process_ = 0;
    refuse(error);
  }
  // Without it (kernels before 5.3), only ended() detects the end.
  end_ = Descriptor(static_cast<int>(::syscall(SYS_pidfd_open, process_, 0)));
}

void Child::listen() {
  char bytes[1024];
  ssize_t count = 0;
  for (int i = 0; i < 8 && (count = ::read(errors_.number(), bytes, sizeof bytes)) > 0; ++i) {
    words_.append(bytes, static_cast<std::size_t>(count));
    if (words_.size() > kMostWords) words_.erase(0, words_.size() - kMostWords);
  }
  if (count == 0) errors_ = Descriptor();
}

namespace {
std::string last_line(std::string words) {
  while (!words.empty() && words.back() == '\n') words.pop_back();
  words.erase(0, words.rfind('\n') + 1);
  if (words.size() > kMostReported) words = "..." + words.substr(words.size() - kMostReported);
  return printable_line(words);
}
}  // namespace

std::optional<Ending> Child::ended() {
  int status = 0;
  if (process_ <= 0 || ::waitpid(process_, &status, WNOHANG) != process_) return std::nullopt;
  listen();
  process_ = 0;
  end_ = Descriptor();
  Ending out;
  if (WIFSIGNALED(status)) out.signal = WTERMSIG(status);
  if (WIFEXITED(status)) out.code = WEXITSTATUS(status);
  out.last_words = last_line(words_);
  return out;
}

Ending Child::finish(std::chrono::milliseconds patience) {
  const auto until = std::chrono::steady_clock::now() + patience;
  for (;;) {
    if (auto ending = ended()) return *ending;
    if (process_ <= 0) return {};
    const bool over = std::chrono::steady_clock::now() >= until;
    if (over) ::kill(process_, SIGKILL);
    pollfd end{end_.number(), POLLIN, 0};
    if (::poll(&end, 1, end_.number() >= 0 ? 20 : 1) < 0) errno = 0;
  }
}

void Child::kill() {
  if (process_ > 0) finish(std::chrono::milliseconds(0));
}

bool become_child(const ChildRules& rules) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != rules.parent) return false;
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  const unsigned first = static_cast<unsigned>(kFirstHanded + rules.handed);
#ifdef SYS_close_range
  if (::syscall(SYS_close_range, first, ~0u, 0) != 0)
#endif
    for (unsigned fd = first; fd < 4096; ++fd) ::close(static_cast<int>(fd));
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const rlimit memory{rules.most_memory, rules.most_memory};
  ::setrlimit(RLIMIT_DATA, &memory);
#endif
  return true;
}

}  // namespace polyarm::process
