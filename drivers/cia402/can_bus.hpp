#pragma once
/// A CAN bus with 11-bit identifiers and at most eight bytes a frame: Linux SocketCAN (`can0`), or SLCAN text
/// over a serial port. One thread at a time. send() and receive() neither allocate nor throw.
/// Source of the frame's form: ISO 11898-1 (classic CAN).
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "polyarm/base/time.hpp"

namespace polyarm::cia402 {

struct CanFrame {
  std::uint16_t id = 0;  ///< 0 to 0x7FF
  std::uint8_t size = 0;
  std::array<std::uint8_t, 8> data{};
  bool operator==(const CanFrame&) const = default;
};
/// Bytes beyond the eighth are left out.
CanFrame frame_of(std::uint16_t id, std::span<const std::uint8_t> bytes) noexcept;

enum class BusState : std::uint8_t {
  ok,
  nothing,  ///< no frame came until the deadline
  full,     ///< the frame could not be sent: nobody on the bus acknowledges, or the queue is full
  off,      ///< the CAN controller switched itself off after too many errors, or is down
  gone,     ///< the adapter was unplugged
  failed    ///< system error
};

class CanBus {
 public:
  virtual ~CanBus() = default;
  virtual BusState send(const CanFrame& frame) noexcept = 0;
  /// The next frame. Waits until `deadline` (of realtime::monotonic_now()); a past one: only what is here.
  virtual BusState receive(CanFrame& frame, Nanoseconds deadline) noexcept = 0;
  /// For a watchdog process: the open device and its lock.
  virtual std::array<int, 2> descriptors() const noexcept = 0;
  /// Frames that the adapter refused, and texts that were not understood.
  virtual std::uint64_t refused() const noexcept { return 0; }
  virtual std::uint64_t garbage() const noexcept { return 0; }
};

struct BusOptions {
  std::string bus;         ///< "can0", or a serial port: "/dev/ttyACM0", "/dev/serial/by-id/…"
  int bit_rate = 1000000;  ///< of the CAN bus; SocketCAN has its own, set by `ip link`
  int baud = 1000000;      ///< of the serial port
  std::string holder;      ///< as serial::PortOptions
};
/// A name with a slash is a serial port.
bool is_serial(const std::string& bus);
/// Opens the device; sends nothing on the bus. Throws Error: as serial::Port does, "no-such-port" for an
/// interface that this machine does not have, "device-in-use", "port-failed", "bad-value".
std::unique_ptr<CanBus> open_bus(const BusOptions& options);
/// In another process: `file` and `lock` are those of descriptors().
std::unique_ptr<CanBus> take_bus(const std::string& bus, int file, int lock);

}  // namespace polyarm::cia402
