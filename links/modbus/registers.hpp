#pragma once
/// Numbers in 16-bit registers: two's complement and IEEE 754, high word first by default.
#include <bit>
#include <cstdint>
#include <vector>

#include "polyarm/signals/link.hpp"

namespace polyarm::modbus {

using Format = signals::LinkTag::Format;

constexpr int words_of(Format format) {
  return format == Format::float64 ? 4 : format == Format::uint16 || format == Format::int16 ? 1 : 2;
}

/// `words` must hold words_of(format) registers.
inline double number_from(const std::uint16_t* words, Format format, bool low_word_first) {
  const int count = words_of(format);
  std::uint64_t bits = 0;
  for (int k = 0; k < count; ++k) bits = bits << 16 | words[low_word_first ? count - 1 - k : k];
  switch (format) {
    case Format::uint16:
    case Format::uint32:
      return static_cast<double>(bits);
    case Format::int16:
      return static_cast<std::int16_t>(bits);
    case Format::int32:
      return static_cast<std::int32_t>(bits);
    case Format::float32:
      return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    case Format::float64:
      return std::bit_cast<double>(bits);
  }
  return 0;
}

/// `number` must be within the range of the format.
inline void number_into(double number, std::uint16_t* words, Format format, bool low_word_first) {
  std::uint64_t bits = 0;
  if (format == Format::float64)
    bits = std::bit_cast<std::uint64_t>(number);
  else if (format == Format::float32)
    bits = std::bit_cast<std::uint32_t>(static_cast<float>(number));
  else
    bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(number));
  const int count = words_of(format);
  for (int k = 0; k < count; ++k)
    words[low_word_first ? k : count - 1 - k] = static_cast<std::uint16_t>(bits >> (16 * k));
}

/// The registers for a tag's value.
inline std::vector<std::uint16_t> words_of_value(const signals::LinkTag& tag, const data::Value& value,
                                                 bool low_word_first) {
  std::vector<double> numbers;
  if (tag.type == signals::LinkTag::Type::pose)
    numbers = signals::given_pose(tag, value);
  else
    numbers.push_back(signals::given_number(tag, value));
  const auto each = static_cast<std::size_t>(words_of(tag.format));
  std::vector<std::uint16_t> out(numbers.size() * each);
  for (std::size_t k = 0; k < numbers.size(); ++k)
    number_into(numbers[k], &out[k * each], tag.format, low_word_first);
  return out;
}

/// The value in a tag's registers. Nothing if it is refused, with the reason in `why`.
inline std::optional<data::Value> value_of_words(const signals::LinkTag& tag, const std::uint16_t* words,
                                                 bool low_word_first, std::string& why) {
  if (tag.type != signals::LinkTag::Type::pose) {
    const double raw = number_from(words, tag.format, low_word_first);
    if (tag.type == signals::LinkTag::Type::boolean) return data::Value(raw != 0);
    return signals::taken_number(tag, raw, why);
  }
  std::vector<double> numbers;
  for (int k = 0; k < signals::kPoseNumbers; ++k)
    numbers.push_back(number_from(words + k * words_of(tag.format), tag.format, low_word_first));
  return signals::taken_pose(tag, numbers, why);
}

}  // namespace polyarm::modbus
