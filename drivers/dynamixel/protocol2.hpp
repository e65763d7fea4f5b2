#pragma once
/// Frames of Dynamixel's Protocol 2.0: FF FF FD 00 ID LEN16 INST PARAM… CRC16. Source: the maker's e-manual;
/// its examples are in tests/servos/frames_test.cpp.
#include "drivers/servo_bus/protocol.hpp"

namespace polyarm::dynamixel {

/// Polynomial 0x8005, most significant bit first, initial value 0.
std::uint16_t crc16(servo_bus::Bytes bytes, std::uint16_t crc = 0) noexcept;

class Protocol2 : public servo_bus::Protocol {
 public:
  std::size_t make(std::span<std::uint8_t> out, std::uint8_t id, servo_bus::Instruction instruction,
                   servo_bus::Bytes parameters) const noexcept override;
  servo_bus::Found find(std::span<std::uint8_t> bytes, std::size_t longest) const noexcept override;
  std::size_t address_size() const noexcept override { return 2; }
  bool echo_looks_like_answer() const noexcept override { return false; }
  bool split_fast(servo_bus::Bytes bytes, std::size_t servos, std::size_t length, Take take,
                  void* context) const noexcept override;
};

}  // namespace polyarm::dynamixel
