#pragma once
/// Runs the command at a pseudo-terminal, at which a test types and reads.
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace polyarm::test {

/// A verb of the command at a terminal.
class AtTerminal {
 public:
  explicit AtTerminal(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), POLYARM_COMMAND);
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    int terminal = -1;
    if (openpty(&master_, &terminal, nullptr, nullptr, nullptr) != 0) throw std::runtime_error("openpty");
    tcgetattr(terminal, &before_);
    pid_ = fork();
    if (pid_ == 0) {
      setsid();
      for (int fd = 0; fd < 3; ++fd) dup2(terminal, fd);
      close(master_);
      execv(POLYARM_COMMAND, argv.data());
      _exit(127);
    }
    terminal_ = terminal;  // kept open, so that a test can check its settings after the verb has ended
  }
  ~AtTerminal() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    close(master_);
    close(terminal_);
  }
  AtTerminal(const AtTerminal&) = delete;
  AtTerminal& operator=(const AtTerminal&) = delete;

  void type(const std::string& keys) {
    if (::write(master_, keys.data(), keys.size()) < 0) throw std::runtime_error("the terminal is gone");
  }
  void signal(int number) { kill(pid_, number); }
  /// Reads until `text` has appeared since the last such call; false after a minute without output.
  bool shows(const std::string& text) {
    for (;;) {
      if (const auto at = seen_.find(text); at != std::string::npos) {
        seen_.erase(0, at + text.size());
        return true;
      }
      if (!read_some(60'000)) return false;
    }
  }
  /// Exit code, or 128 + signal.
  int ends() {
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) == 0) read_some(10);
    pid_ = -1;
    while (read_some(0)) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  bool is_as_it_was() const {
    termios now;
    return tcgetattr(terminal_, &now) == 0 && now.c_lflag == before_.c_lflag &&
           now.c_iflag == before_.c_iflag && now.c_oflag == before_.c_oflag;
  }
  const std::string& seen() const { return seen_; }

 private:
  bool read_some(int timeout_ms) {
    pollfd waiting{master_, POLLIN, 0};
    if (poll(&waiting, 1, timeout_ms) <= 0) return false;
    char text[4096];
    const ssize_t n = read(master_, text, sizeof text);
    if (n <= 0) return false;
    seen_.append(text, static_cast<std::size_t>(n));
    return true;
  }
  pid_t pid_ = -1;
  int master_ = -1, terminal_ = -1;
  termios before_{};
  std::string seen_;
};

}  // namespace polyarm::test
