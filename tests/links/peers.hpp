#pragma once
/// Programs of others on the far end of a link.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace polyarm::test {

/// A port that nobody has, as far as can be known.
inline int free_port() {
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  if (::bind(fd, reinterpret_cast<sockaddr*>(&address), length) != 0 ||
      ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length) != 0)
    throw std::runtime_error("no port");
  ::close(fd);
  return ntohs(address.sin_port);
}

/// Whether somebody listens there.
inline bool listens(int port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool there = ::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  ::close(fd);
  return there;
}

/// True when it came true within the time that even a busy machine needs.
inline bool eventually(const std::function<bool()>& what, int seconds = 30) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  while (!what()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::yield();
    ::usleep(2000);
  }
  return true;
}

/// A process whose standard input is written and whose output is read, a line each.
class Peer {
 public:
  explicit Peer(const std::vector<std::string>& command) {
    int in[2], out[2];
    if (::pipe(in) != 0 || ::pipe(out) != 0) throw std::runtime_error("pipe");
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(in[0], 0);
      ::dup2(out[1], 1);
      for (const int fd : {in[0], in[1], out[0], out[1]}) ::close(fd);
      std::vector<char*> argv;
      for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
      argv.push_back(nullptr);
      ::execvp(argv[0], argv.data());
      ::_exit(127);
    }
    ::close(in[0]);
    ::close(out[1]);
    to_ = ::fdopen(in[1], "w");
    from_ = ::fdopen(out[0], "r");
  }
  ~Peer() {
    end(SIGKILL);
    std::fclose(to_);
    std::fclose(from_);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  void end(int signal) {
    if (pid_ <= 0) return;
    ::kill(pid_, signal);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  std::string line() {
    char text[4096];
    if (!std::fgets(text, sizeof text, from_)) return "gone";
    std::string out = text;
    while (!out.empty() && out.back() == '\n') out.pop_back();
    return out;
  }
  std::string ask(const std::string& what) {
    std::fprintf(to_, "%s\n", what.c_str());
    std::fflush(to_);
    return line();
  }

 private:
  pid_t pid_ = -1;
  std::FILE *to_ = nullptr, *from_ = nullptr;
};

/// The process that speaks a link of the process `parent`; 0 where there is none.
inline int link_process_of(int parent) {
  const auto text = [](const std::filesystem::path& file) {
    std::ifstream in(file);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", error)) {
    const int process = std::atoi(entry.path().filename().c_str());
    if (process <= 0 || !text(entry.path() / "comm").starts_with("polyarm_link_")) continue;
    const std::string status = text(entry.path() / "status");
    if (status.find("PPid:\t" + std::to_string(parent) + "\n") != std::string::npos &&
        status.find("State:\tZ") == std::string::npos)
      return process;
  }
  return 0;
}

/// The system's Python, for which its packages are.
inline const char* python() {
  return "/usr/bin/python3";
}
inline bool has_pymodbus() {
  static const bool has =
      std::system("/usr/bin/python3 -c 'import pymodbus.client, pymodbus.server' 2>/dev/null") == 0;
  return has;
}
inline bool has_mosquitto() {
  return std::filesystem::exists("/usr/sbin/mosquitto");
}
inline std::string modbus_peer() {
  return std::string(POLYARM_SOURCE_DIR) + "/tests/links/modbus_peer.py";
}

}  // namespace polyarm::test
