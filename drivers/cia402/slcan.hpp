#pragma once
/// SLCAN: CAN frames as lines of text over a serial port, as adapters of many makers speak it (CANUSB,
/// CANable, USBtin). Source: LAWICEL's CAN232 manual, version 3. One thread.
#include "drivers/cia402/can_bus.hpp"
#include "drivers/serial/port.hpp"

namespace polyarm::cia402 {

/// "t60120011" and a carriage return.
struct SlcanText {
  std::array<char, 32> text{};
  std::size_t size = 0;
  std::span<const std::uint8_t> bytes() const noexcept {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), size};
  }
};
SlcanText slcan_text(const CanFrame& frame) noexcept;
/// The command that sets a bit rate: "S8" for 1 Mbit/s; null: SLCAN has no command for it.
const char* slcan_rate(int bit_rate) noexcept;

/// Reads what an adapter sends, byte by byte. A line that is too long or damaged is dropped. Never allocates.
class SlcanParser {
 public:
  enum class Token : std::uint8_t {
    none,      ///< the line goes on
    frame,     ///< frame() is new
    refused,   ///< the adapter refused a command or a frame
    accepted,  ///< it took one
    other,     ///< a line of another kind: an extended or a remote frame, a version
    garbage
  };
  Token take(std::uint8_t byte) noexcept;
  const CanFrame& frame() const noexcept { return frame_; }

 private:
  Token line() noexcept;
  bool data_frame(std::size_t from) noexcept;
  std::array<char, 32> line_{};
  std::size_t size_ = 0;
  bool overflow_ = false;
  CanFrame frame_;
};

class SlcanBus : public CanBus {
 public:
  /// Opens the port and the adapter's channel. Throws as serial::Port does; "bad-value" for a bit rate that
  /// SLCAN does not have; "port-failed" if the adapter refuses.
  explicit SlcanBus(const BusOptions& options);
  /// A channel that another process has opened.
  explicit SlcanBus(serial::Port port) : port_(std::move(port)) {}
  ~SlcanBus() override;

  BusState send(const CanFrame& frame) noexcept override;
  BusState receive(CanFrame& frame, Nanoseconds deadline) noexcept override;
  std::array<int, 2> descriptors() const noexcept override { return port_.descriptors(); }
  std::uint64_t refused() const noexcept override { return refused_; }
  std::uint64_t garbage() const noexcept override { return garbage_; }

 private:
  void command(const char* text);
  void listen_briefly();
  void open_channel(const BusOptions& options);

  serial::Port port_;
  SlcanParser parser_;
  std::array<std::uint8_t, 1024> in_{};
  std::size_t at_ = 0, count_ = 0;
  std::uint64_t refused_ = 0, garbage_ = 0;
  bool opened_ = false;  ///< by this process
};

}  // namespace polyarm::cia402
