#pragma once
/// A serial port: a tty of the kernel (USB adapter, UART) or a pty of a test.
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "polyarm/base/time.hpp"
#include "polyarm/hardware/device_lock.hpp"

namespace polyarm::serial {

struct PortOptions {
  std::string path;         ///< "/dev/ttyUSB0", "/dev/serial/by-id/…"
  int baud = 115200;        ///< any the adapter can do, 1000000 as well; bits/s
  std::string holder = {};  ///< what another process is told that finds the port in use ("component arm")
  bool low_latency = true;  ///< ask the kernel to pass bytes on at once, where it can
};

enum class Status : std::uint8_t {
  ok,
  timeout,  ///< the deadline passed first
  gone,     ///< unplugged, or the far side of a pty has closed; nothing but opening it again helps
  failed,   ///< the system refused; see Transfer::error
};

/// What became of a read or a write. `count` bytes are there or have gone, whatever the status.
struct Transfer {
  Status status = Status::ok;
  std::size_t count = 0;
  int error = 0;  ///< errno of `gone` and `failed`, else 0
  explicit operator bool() const noexcept { return status == Status::ok; }
};

/// An open port, raw, 8N1, no flow control, for this process alone. One thread at a time. Deadlines are
/// moments of realtime::monotonic_now(); one in the past means: what is there now. Reads, writes and flush
/// neither allocate nor throw.
class Port {
 public:
  Port() = default;
  /// Opens and sets up; nothing is sent. Throws Error: "no-such-port" (with the ports there are),
  /// "port-not-permitted" (with the group to join), "device-in-use", "not-a-serial-port",
  /// "baud-not-supported", "port-failed".
  explicit Port(const PortOptions& options);
  /// A port that another process has opened, set up and handed over; never throws, whatever it is. `lock`:
  /// the descriptor of its DeviceLock, closed with the port; -1: none.
  static Port handed_over(int file, int lock, std::string path) noexcept;
  ~Port();
  Port(Port&& other) noexcept;
  Port& operator=(Port&& other) noexcept;
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  bool is_open() const noexcept { return file_ >= 0; }
  void close() noexcept;
  const std::string& path() const noexcept { return path_; }
  /// What handed_over() of another process takes: the port, and its lock. Both processes then share it, and
  /// it is free when both have closed it.
  std::array<int, 2> descriptors() const noexcept { return {file_, lock_.descriptor()}; }
  bool low_latency() const noexcept { return low_latency_; }
  /// Throws Error("baud-not-supported") and leaves the rate as it was.
  void set_baud(int baud);

  /// What has arrived, at least one byte, at most `into`.
  Transfer read(std::span<std::uint8_t> into, Nanoseconds deadline) noexcept;
  /// All of `into`.
  Transfer read_exactly(std::span<std::uint8_t> into, Nanoseconds deadline) noexcept;
  /// All of `bytes` into the kernel's buffer.
  Transfer write(std::span<const std::uint8_t> bytes, Nanoseconds deadline) noexcept;
  /// Drops what has arrived and was not read.
  Transfer flush() noexcept;

 private:
  Transfer wait(short events, Nanoseconds deadline) noexcept;

  std::string path_;
  hardware::DeviceLock lock_;
  int file_ = -1, foreign_lock_ = -1;
  bool low_latency_ = false;
};

/// A sentence for an errno of a port, with what to do ("the adapter was unplugged: …").
std::string explain(Status status, int error);

}  // namespace polyarm::serial
