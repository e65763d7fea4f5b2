#pragma once
/// Runs the built `polyarm` command in tests, with its input and output; and copies of the examples.
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace polyarm::test {

struct Finished {
  int exit_code = -1;  ///< 128 + signal if a signal ended it
  std::string output;
  /// The last line of the output as JSON.
  nlohmann::json result() const {
    std::string text = output;
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return nlohmann::json::parse(text.substr(text.rfind('\n') + 1), nullptr, false);
  }
};

/// Whether the command's standard input is a terminal, at which type() types.
enum class Input { nobody, terminal };

/// The built command, running.
class Command {
 public:
  explicit Command(const std::vector<std::string>& arguments, Input input = Input::nobody) {
    std::string terminal = "/dev/null";
    if (input == Input::terminal) {
      char name[128] = {};
      keyboard_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
      if (keyboard_ < 0 || ::grantpt(keyboard_) != 0 || ::unlockpt(keyboard_) != 0 ||
          ::ptsname_r(keyboard_, name, sizeof name) != 0)
        throw std::runtime_error("no terminal");
      terminal = name;
    }
    int fds[2];
    if (::pipe(fds) != 0) throw std::runtime_error("pipe");
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(fds[1], STDOUT_FILENO);
      ::dup2(fds[1], STDERR_FILENO);
      ::close(fds[0]);
      ::close(fds[1]);
      const int in = ::open(terminal.c_str(), O_RDWR | O_NOCTTY);
      if (in < 0 || ::dup2(in, STDIN_FILENO) < 0) ::_exit(126);
      ::close(in);
      std::vector<char*> argv{const_cast<char*>(POLYARM_COMMAND)};
      for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
      const std::string ours = "--allow=" POLYARM_SOURCE_DIR;  // the cells of tests use robots of the source
                                                               // tree
      if (!arguments.empty()) argv.insert(argv.begin() + 2, const_cast<char*>(ours.c_str()));
      argv.push_back(nullptr);
      ::execv(POLYARM_COMMAND, argv.data());
      ::_exit(127);
    }
    ::close(fds[1]);
    out_ = ::fdopen(fds[0], "r");
  }
  ~Command() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      wait();
    }
    if (keyboard_ >= 0) ::close(keyboard_);
  }
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  /// Types the text as if a person did.
  void type(const std::string& text) {
    if (::write(keyboard_, text.data(), text.size()) < 0) throw std::runtime_error("nobody can type");
  }
  void signal(int number) { ::kill(pid_, number); }
  pid_t process() const { return pid_; }
  /// Reads until a line contains `text`; false at the end of the output.
  bool wait_for(const std::string& text) { return !line_with(text).empty(); }
  /// Reads until a line contains `text` and returns that line; empty at the end of the output.
  std::string line_with(const std::string& text) {
    char line[8192];
    while (std::fgets(line, sizeof line, out_)) {
      finished_.output += line;
      if (std::string(line).find(text) != std::string::npos) return line;
    }
    return {};
  }
  /// Sets the size of the output pipe, bytes (whole pages). The command then blocks when a reader is late.
  void shrink_output(int bytes) {
    if (::fcntl(::fileno(out_), F_SETPIPE_SZ, bytes) < 0) throw std::runtime_error("no such pipe");
  }
  /// True if the command ends within this many tenths of a second although nobody reads its output.
  bool ends_unread(int tenths) {
    for (; tenths > 0; --tenths) {
      siginfo_t info{};
      if (::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
          info.si_pid == pid_)
        return true;
      ::usleep(100'000);
    }
    return false;
  }
  /// Closes the reading end, like `| head` when it has ended.
  void stop_reading() {
    std::fclose(out_);
    out_ = nullptr;
  }
  const Finished& wait() {
    if (pid_ <= 0) return finished_;
    char line[8192];
    while (out_ && std::fgets(line, sizeof line, out_)) finished_.output += line;
    if (out_) std::fclose(out_);
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    finished_.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return finished_;
  }

 private:
  pid_t pid_ = -1;
  int keyboard_ = -1;  ///< the test's side of the terminal
  std::FILE* out_ = nullptr;
  Finished finished_;
};

inline Finished run_command(const std::vector<std::string>& arguments) {
  return Command(arguments).wait();
}

/// A copy of an example in a temporary folder, removed at the end. A folder can be used by one run at a time,
/// and other tests may run the same example, so each test runs a copy.
class ExampleCopy {
 public:
  explicit ExampleCopy(const std::string& example) {
    namespace fs = std::filesystem;
    std::string pattern = (fs::temp_directory_path() / "polyarm_XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
    for (const auto& entry : fs::directory_iterator(fs::path(POLYARM_SOURCE_DIR) / "examples" / example))
      if (entry.path().filename() != ".state")
        fs::copy(entry.path(), path_ / entry.path().filename(), fs::copy_options::recursive);
  }
  ExampleCopy(const ExampleCopy&) = delete;
  ExampleCopy& operator=(const ExampleCopy&) = delete;
  ~ExampleCopy() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string path() const { return path_.string(); }
  std::filesystem::path file(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace polyarm::test
