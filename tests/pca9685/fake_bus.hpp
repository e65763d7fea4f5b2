#pragma once
/// A bus that several processes share: the chip lives in the test, transactions come over a local socket, one
/// packet each, so that a process that is stopped or killed never leaves half of one.
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "drivers/pca9685/i2c_bus.hpp"
#include "tests/pca9685/fake_chip.hpp"

namespace polyarm::test {

inline sockaddr_un address_of(const std::string& path) {
  sockaddr_un out{};
  out.sun_family = AF_UNIX;
  std::strncpy(out.sun_path, path.c_str(), sizeof out.sun_path - 1);
  return out;
}

/// The end that a process has.
class FakeBus : public drivers::I2cBus {
 public:
  FakeBus(int socket, std::uint8_t address) : socket_(socket), address_(address) {}
  ~FakeBus() override { close(socket_); }
  int write(std::span<const std::uint8_t> bytes) noexcept override { return exchange(bytes, {}); }
  int read(std::uint8_t first, std::span<std::uint8_t> into) noexcept override {
    return exchange({&first, 1}, into);
  }

 private:
  int exchange(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) noexcept {
    std::uint8_t packet[64] = {address_, static_cast<std::uint8_t>(in.size())};
    std::memcpy(packet + 2, out.data(), out.size());
    ssize_t n = 0;
    while ((n = send(socket_, packet, out.size() + 2, MSG_NOSIGNAL)) < 0 && errno == EINTR) {
    }
    if (n < 0) return EIO;
    while ((n = recv(socket_, packet, sizeof packet, 0)) < 0 && errno == EINTR) {
    }
    if (n < 1) return EIO;
    std::memcpy(in.data(), packet + 1, in.size());
    return packet[0];
  }
  int socket_;
  std::uint8_t address_;
};

inline std::unique_ptr<drivers::I2cBus> open_fake_bus(const std::string& path, std::uint8_t address,
                                                      drivers::BusFailure& failure) {
  const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  const sockaddr_un to = address_of(path);
  if (fd < 0 || connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    failure = {drivers::BusFailure::Step::open, errno};
    if (fd >= 0) close(fd);
    return nullptr;
  }
  return std::make_unique<FakeBus>(fd, address);
}

/// One transaction as the chip sees it.
struct Transaction {
  pid_t from = 0;
  bool reads = false;
  std::vector<std::uint8_t> bytes;
};

/// The chip and its wires.
class FakeBoard {
 public:
  static constexpr std::uint8_t kAddress = 0x60;

  FakeBoard() {
    path_ = "/tmp/polyarm_i2c_" + std::to_string(getpid()) + "_" + std::to_string(++counter());
    unlink(path_.c_str());
    listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    const sockaddr_un at = address_of(path_);
    if (listener_ < 0 || bind(listener_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 ||
        listen(listener_, 16) != 0 || pipe(wake_) != 0)
      throw std::runtime_error("no socket for the fake bus");
    thread_ = std::thread([this] { serve(); });
  }
  ~FakeBoard() {
    if (::write(wake_[1], "x", 1) != 1) std::terminate();
    thread_.join();
    for (const int fd : {listener_, wake_[0], wake_[1]}) close(fd);
    unlink(path_.c_str());
  }
  FakeBoard(const FakeBoard&) = delete;
  FakeBoard& operator=(const FakeBoard&) = delete;

  const std::string& path() const { return path_; }

  /// What the wires do to a transaction: an errno, or 0 and it goes through.
  void set_fault(std::function<int(const Transaction&)> fault) {
    const std::lock_guard guard(mutex_);
    fault_ = std::move(fault);
  }
  /// Looks at the chip, between two transactions.
  template <typename Look>
  auto look(Look what) {
    const std::lock_guard guard(mutex_);
    return what(chip_);
  }
  /// Waits until the chip is so; false after a minute.
  template <typename Is>
  bool wait(Is is) {
    std::unique_lock guard(mutex_);
    return changed_.wait_for(guard, std::chrono::seconds(60), [&] { return is(chip_); });
  }
  /// Waits for so many transactions in all.
  bool wait_for_count(std::size_t count) {
    std::unique_lock guard(mutex_);
    return changed_.wait_for(guard, std::chrono::seconds(60), [&] { return log_.size() >= count; });
  }
  std::vector<Transaction> log() {
    const std::lock_guard guard(mutex_);
    return log_;
  }
  void forget_log() {
    const std::lock_guard guard(mutex_);
    log_.clear();
    was_on_ = false;
  }
  /// Has any output been on since forget_log()?
  bool was_on() {
    const std::lock_guard guard(mutex_);
    return was_on_;
  }

 private:
  static int& counter() {
    static int value = 0;
    return value;
  }

  void serve() {
    std::vector<pollfd> all = {{wake_[0], POLLIN, 0}, {listener_, POLLIN, 0}};
    while (poll(all.data(), all.size(), -1) >= 0) {
      if (all[0].revents != 0) break;
      for (std::size_t i = 2; i < all.size(); ++i)
        if (all[i].revents != 0 && !answer(all[i].fd)) {
          close(all[i].fd);
          all[i].fd = -1;
        }
      std::erase_if(all, [](const pollfd& p) { return p.fd < 0; });
      if (all[1].revents != 0)
        if (const int fd = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC); fd >= 0)
          all.push_back({fd, POLLIN, 0});
    }
    for (std::size_t i = 2; i < all.size(); ++i) close(all[i].fd);
  }

  bool answer(int fd) {
    std::uint8_t packet[64];
    const ssize_t n = recv(fd, packet, sizeof packet, 0);
    if (n < 2) return false;
    ucred peer{};
    socklen_t size = sizeof peer;
    getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size);
    const std::size_t reads = packet[1];
    std::uint8_t reply[64] = {};
    {
      const std::lock_guard guard(mutex_);
      log_.push_back({peer.pid, reads > 0, {packet + 2, packet + n}});
      int error = fault_ ? fault_(log_.back()) : 0;
      if (error == 0 && packet[0] != kAddress) error = ENXIO;
      if (error == 0)
        error = reads > 0 ? chip_.read(packet[2], {reply + 1, reads}) : chip_.write({packet + 2, packet + n});
      reply[0] = static_cast<std::uint8_t>(error);
      was_on_ = was_on_ || !chip_.all_off();
    }
    changed_.notify_all();
    return send(fd, reply, 1 + reads, MSG_NOSIGNAL) >= 0;
  }

  std::string path_;
  int listener_ = -1, wake_[2] = {-1, -1};
  std::mutex mutex_;
  std::condition_variable changed_;
  FakeChip chip_;
  std::function<int(const Transaction&)> fault_;
  std::vector<Transaction> log_;
  bool was_on_ = false;
  std::thread thread_;
};

}  // namespace polyarm::test
