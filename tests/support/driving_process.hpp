#pragma once
/// A driver in its own process, which tests stop, kill and command line by line.
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

namespace polyarm::test {

class DrivingProcess {
 public:
  /// `words`: the program and its arguments.
  explicit DrivingProcess(std::vector<std::string> words) {
    int in[2], out[2];
    if (pipe2(in, O_CLOEXEC) != 0 || pipe2(out, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      dup2(in[0], STDIN_FILENO);
      dup2(out[1], STDOUT_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(in[0]);
    close(out[1]);
    to_ = in[1];
    from_ = fdopen(out[0], "r");
  }
  ~DrivingProcess() {
    signal(SIGCONT);
    signal(SIGKILL);
    wait();
    close(to_);
    std::fclose(from_);
  }
  DrivingProcess(const DrivingProcess&) = delete;
  DrivingProcess& operator=(const DrivingProcess&) = delete;

  void signal(int number) const {
    if (pid_ > 0) kill(pid_, number);
  }
  void tell(const std::string& word) const {
    const std::string line = word + "\n";
    if (::write(to_, line.data(), line.size()) < 0) throw std::runtime_error("it does not listen");
  }
  std::string line() {
    char text[1024];
    return std::fgets(text, sizeof text, from_) ? text : "nothing more";
  }
  void wait() {
    if (pid_ > 0) waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

 private:
  pid_t pid_ = -1;
  int to_ = -1;
  std::FILE* from_ = nullptr;
};

}  // namespace polyarm::test
