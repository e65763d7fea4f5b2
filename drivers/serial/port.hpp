#pragma once
/// A serial port: a kernel tty (USB adapter, UART) or a pty in a test.
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "polyarm/base/time.hpp"
#include "polyarm/hardware/device_lock.hpp"

namespace polyarm::serial {

struct PortOptions {
  std::string path;         ///< "/dev/ttyUSB0", "/dev/serial/by-id/…"
  int baud = 115200;        ///< bits/s; any rate that the adapter supports, also 1000000
  std::string holder = {};  ///< shown to another process that finds the port in use ("component arm")
  bool low_latency = true;  ///< asks the kernel to pass bytes on immediately, if it can
};

enum class Status : std::uint8_t {
  ok,
  timeout,  ///< the deadline passed
  gone,     ///< unplugged, or the far side of a pty has closed; it must be opened again
  failed,   ///< system error; see Transfer::error
};

/// The result of a read or a write. `count` bytes were transferred, for any status.
struct Transfer {
  Status status = Status::ok;
  std::size_t count = 0;
  int error = 0;  ///< errno of `gone` and `failed`, else 0
  explicit operator bool() const noexcept { return status == Status::ok; }
};

/// An open port: raw, 8N1, no flow control, exclusive to this process. One thread at a time. Deadlines are
/// times of realtime::monotonic_now(); a past one means: only what is available now. Reads, writes and flush
/// neither allocate nor throw.
class Port {
 public:
  Port() = default;
  /// Opens and sets up the port; sends nothing. Throws Error: "no-such-port" (with the existing ports),
  /// "port-not-permitted" (with the group to join), "device-in-use", "not-a-serial-port",
  /// "baud-not-supported", "port-failed".
  explicit Port(const PortOptions& options);
  /// A port that another process has opened, set up and handed over; never throws. `lock`: the descriptor of
  /// its DeviceLock, closed with the port; -1: none.
  static Port handed_over(int file, int lock, std::string path) noexcept;
  ~Port();
  Port(Port&& other) noexcept;
  Port& operator=(Port&& other) noexcept;
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  bool is_open() const noexcept { return file_ >= 0; }
  void close() noexcept;
  const std::string& path() const noexcept { return path_; }
  /// The arguments of handed_over() in another process: the port and its lock. Both processes then share the
  /// port; it is free when both have closed it.
  std::array<int, 2> descriptors() const noexcept { return {file_, lock_.descriptor()}; }
  bool low_latency() const noexcept { return low_latency_; }
  /// Throws Error("baud-not-supported") and keeps the old rate.
  void set_baud(int baud);

  /// Reads what has arrived, at least one byte, at most `into`.
  Transfer read(std::span<std::uint8_t> into, Nanoseconds deadline) noexcept;
  /// Fills all of `into`.
  Transfer read_exactly(std::span<std::uint8_t> into, Nanoseconds deadline) noexcept;
  /// Writes all of `bytes` into the kernel's buffer.
  Transfer write(std::span<const std::uint8_t> bytes, Nanoseconds deadline) noexcept;
  /// Drops unread input.
  Transfer flush() noexcept;

 private:
  Transfer wait(short events, Nanoseconds deadline) noexcept;

  std::string path_;
  hardware::DeviceLock lock_;
  int file_ = -1, foreign_lock_ = -1;
  bool low_latency_ = false;
};

/// A sentence for an errno of a port, with advice ("the adapter was unplugged: …").
std::string explain(Status status, int error);

}  // namespace polyarm::serial
