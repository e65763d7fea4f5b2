#pragma once
/// Frames of Feetech's SCS protocol ("protocol 0"): FF FF ID LEN INST PARAM… ~SUM. Source: the maker's
/// description of the SCS communication protocol; its examples are in tests/servos/frames_test.cpp.
#include "drivers/servo_bus/protocol.hpp"

namespace polyarm::feetech {

class Protocol0 : public servo_bus::Protocol {
 public:
  std::size_t make(std::span<std::uint8_t> out, std::uint8_t id, servo_bus::Instruction instruction,
                   servo_bus::Bytes parameters) const noexcept override;
  servo_bus::Found find(std::span<std::uint8_t> bytes, std::size_t longest) const noexcept override;
  std::size_t address_size() const noexcept override { return 1; }
  bool echo_looks_like_answer() const noexcept override { return true; }
};

}  // namespace polyarm::feetech
