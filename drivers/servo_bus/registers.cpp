#include "drivers/servo_bus/registers.hpp"

namespace polyarm::servo_bus {

std::int32_t decode(const Register& reg, Bytes bytes) noexcept {
  std::uint32_t raw = 0;
  for (std::size_t i = reg.size; i-- > 0;) raw = raw << 8 | bytes[i];
  switch (reg.sign) {
    case Sign::magnitude: {
      const std::uint32_t bit = 1u << reg.sign_bit;
      const auto size = static_cast<std::int32_t>(raw & (bit - 1));
      return raw & bit ? -size : size;
    }
    case Sign::twos_complement:
      if (reg.size == 1) return static_cast<std::int8_t>(raw);
      if (reg.size == 2) return static_cast<std::int16_t>(raw);
      break;
    case Sign::none:
      break;
  }
  return static_cast<std::int32_t>(raw);
}

void encode(const Register& reg, std::int32_t value, std::span<std::uint8_t> bytes) noexcept {
  auto raw = static_cast<std::uint32_t>(value);
  if (reg.sign == Sign::magnitude) {
    const std::uint32_t bit = 1u << reg.sign_bit;
    raw = value < 0 ? bit | ((0u - raw) & (bit - 1)) : raw & (bit - 1);
  }
  for (std::size_t i = 0; i < reg.size; ++i, raw >>= 8) bytes[i] = static_cast<std::uint8_t>(raw);
}

const Model* find_model(const Family& family, int number) {
  for (const Model& model : family.models)
    if (model.number == number) return &model;
  return nullptr;
}

std::string status_names(const Family& family, unsigned bits) {
  std::string out;
  for (unsigned i = 0; i < 8; ++i) {
    if (!(bits >> i & 1)) continue;
    if (!out.empty()) out += " and ";
    out += family.status_bit[i] ? family.status_bit[i] : "bit " + std::to_string(i);
  }
  return out;
}

}  // namespace polyarm::servo_bus
