#pragma once
/// A pty pair: the far side of a serial line in tests. The port at path() is a normal tty.
#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace polyarm::test {

class Pty {
 public:
  Pty() {
    master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    char name[128] = {};
    if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0 ||
        ::ptsname_r(master_, name, sizeof name) != 0)
      throw std::runtime_error("no pty");
    path_ = name;
    slave_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);  // kept open, so that closing a port does not hang
                                                           // up the pty
    termios raw{};
    if (slave_ < 0 || ::tcgetattr(slave_, &raw) != 0) throw std::runtime_error("no pty");
    ::cfmakeraw(&raw);  // nothing is echoed before a port is opened
    if (::tcsetattr(slave_, TCSANOW, &raw) != 0) throw std::runtime_error("no pty");
  }
  ~Pty() {
    close_connection();
    ::close(slave_);
  }
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;

  const std::string& path() const { return path_; }
  int master() const { return master_; }

  /// Closes the far side, as when a cable is unplugged.
  void close_connection() {
    if (master_ >= 0) ::close(std::exchange(master_, -1));
  }
  void write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(master_, bytes.data(), bytes.size());
      if (count <= 0) throw std::runtime_error("pty write");
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
  }
  void write(std::initializer_list<std::uint8_t> bytes) {
    write(std::span<const std::uint8_t>(bytes.begin(), bytes.size()));
  }
  /// The bytes that the port has sent. Waits up to `timeout_ms` for the first byte, then takes all that have
  /// arrived.
  std::vector<std::uint8_t> read(int timeout_ms = 5000) {
    pollfd watched{master_, POLLIN, 0};
    if (::poll(&watched, 1, timeout_ms) <= 0 || !(watched.revents & POLLIN)) return {};
    std::vector<std::uint8_t> out(4096);
    const ssize_t count = ::read(master_, out.data(), out.size());
    out.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return out;
  }
  /// Exactly `count` bytes; fewer if they do not arrive in time.
  std::vector<std::uint8_t> read_exactly(std::size_t count, int timeout_ms = 5000) {
    std::vector<std::uint8_t> out;
    pollfd watched{master_, POLLIN, 0};
    while (out.size() < count && ::poll(&watched, 1, timeout_ms) > 0 && (watched.revents & POLLIN)) {
      std::uint8_t byte = 0;
      if (::read(master_, &byte, 1) != 1) break;
      out.push_back(byte);
    }
    return out;
  }

 private:
  int master_ = -1, slave_ = -1;
  std::string path_;
};

}  // namespace polyarm::test
