#pragma once
/// Servos on one serial line with one master.
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "drivers/serial/port.hpp"
#include "drivers/servo_bus/protocol.hpp"
#include "drivers/servo_bus/registers.hpp"

namespace polyarm::servo_bus {

enum class Outcome : std::uint8_t {
  ok,
  lost,     ///< no complete answer in time
  gone,     ///< the port is lost
  failed,   ///< system error
  refused,  ///< the servo answered with an error
};

/// Counters of line errors that were recovered.
struct LineCounters {
  std::uint64_t lost = 0, garbage = 0, strangers = 0, echoes = 0;
};

/// The answer of one servo to a sync read.
struct Reply {
  bool here = false;
  std::uint8_t error = 0;
};

/// The serial line. One thread at a time. Only open() allocates or throws; all other calls are bounded by the
/// answer timeout.
class ServoBus {
 public:
  static constexpr std::size_t kMostServos = 32;

  ServoBus(const Family& family, std::unique_ptr<Protocol> protocol)
      : family_(family), protocol_(std::move(protocol)) {}

  /// `answer_timeout` is added to the transmission time. Throws as serial::Port does.
  void open(const serial::PortOptions& options, Nanoseconds answer_timeout);
  /// Uses a port that is already open.
  void take(serial::Port port, int baud, Nanoseconds answer_timeout) noexcept;
  void close() noexcept { port_.close(); }
  /// The descriptors for a watchdog, as in serial::Port.
  std::array<int, 2> descriptors() const noexcept { return port_.descriptors(); }
  bool is_open() const noexcept { return port_.is_open(); }
  void set_baud(int baud);
  const Family& family() const noexcept { return family_; }
  const std::string& port() const noexcept { return port_.path(); }
  const LineCounters& counters() const noexcept { return counters_; }
  /// True if the adapter echoes what is sent. Known after the first answer.
  bool echoes() const noexcept { return echo_ == Echo::yes; }

  /// Checks that a servo has this id. Also detects whether the adapter echoes.
  Outcome ping(std::uint8_t id) noexcept;
  Outcome read(std::uint8_t id, std::uint16_t address, std::span<std::uint8_t> into) noexcept;
  Outcome read(std::uint8_t id, const Register& reg, std::int32_t& value) noexcept;
  /// Waits for the servo's answer. A servo may be configured not to answer writes: the result is then `lost`.
  Outcome write(std::uint8_t id, const Register& reg, std::int32_t value) noexcept;
  /// Writes until the value read back is equal, at most three times.
  Outcome write_checked(std::uint8_t id, const Register& reg, std::int32_t value) noexcept;
  Outcome reboot(std::uint8_t id) noexcept;
  /// Reads the same `length` bytes of each servo into `into`, one after the other. `ok` if the line works,
  /// regardless of missing answers; `replies` show who answered.
  Outcome sync_read(std::span<const std::uint8_t> ids, std::uint16_t address, std::uint16_t length,
                    std::span<std::uint8_t> into, std::span<Reply> replies, bool fast = false) noexcept;
  /// Writes one register of several servos; they do not answer.
  Outcome sync_write(std::span<const std::uint8_t> ids, const Register& reg,
                     std::span<const std::int32_t> values) noexcept;

 private:
  enum class Echo : std::uint8_t { unknown, yes, no };
  Outcome send(std::uint8_t id, Instruction instruction, std::size_t parameters) noexcept;
  std::size_t put_number(std::size_t at, std::uint16_t value) noexcept;
  Outcome receive(std::uint8_t id, std::span<std::uint8_t> into) noexcept;
  template <typename Take>
  Outcome collect(std::size_t longest, std::size_t expected, Take take) noexcept;
  Outcome collect_fast(std::span<const std::uint8_t> ids, std::uint16_t length, std::span<std::uint8_t> into,
                       std::span<Reply> replies) noexcept;
  void settle() noexcept;
  Nanoseconds byte_time(std::size_t bytes) const noexcept;

  const Family& family_;
  std::unique_ptr<Protocol> protocol_;
  serial::Port port_;
  int baud_ = 1;
  Nanoseconds answer_timeout_ = 10'000'000;
  std::array<std::uint8_t, 256> parameters_{};
  std::array<std::uint8_t, 512> out_{};
  std::array<std::uint8_t, 4096> in_{};
  std::size_t sent_ = 0, received_ = 0;
  Echo echo_ = Echo::unknown;
  bool unsettled_ = false;
  LineCounters counters_;
};

}  // namespace polyarm::servo_bus
