#pragma once
/// Messages of any type with something in every field.
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "polyarm/messages/type_info.hpp"

namespace polyarm::messages::test {

inline nlohmann::json random_message(const TypeInfo& type, std::mt19937& random);

inline nlohmann::json random_value(const FieldInfo& field, std::mt19937& random) {
  switch (field.kind) {
    case FieldKind::nested:
      return random_message(*field.nested, random);
    case FieldKind::boolean:
      return random() % 2 == 0;
    case FieldKind::string:
      return std::string(random() % 9, static_cast<char>('a' + random() % 26));
    case FieldKind::float32:
      return (static_cast<int>(random() % 2000) - 1000) / 8.0;
    case FieldKind::float64:
      return static_cast<double>(random()) / 1e3 - 2e6;
    case FieldKind::int8:
      return static_cast<int>(random() % 256) - 128;
    case FieldKind::int16:
      return static_cast<int>(random() % 65536) - 32768;
    case FieldKind::int32:
      return static_cast<std::int32_t>(random());
    case FieldKind::int64:
      return static_cast<std::int64_t>(random()) * 4096 - 9'000'000'000;
    case FieldKind::uint16:
      return random() % 65536;
    case FieldKind::uint32:
      return static_cast<std::uint32_t>(random());
    case FieldKind::uint64:
      return static_cast<std::uint64_t>(random()) * 4096;
    default:
      return random() % 256;
  }
}

/// Whole numbers stay below 2⁵³, which every reader can hold.
inline nlohmann::json random_message(const TypeInfo& type, std::mt19937& random) {
  nlohmann::json out = nlohmann::json::object();
  for (const FieldInfo& field : type.fields) {
    if (field.shape == FieldShape::single) {
      out[field.name] = random_value(field, random);
      continue;
    }
    nlohmann::json& list = out[field.name] = nlohmann::json::array();
    const std::size_t count = field.shape == FieldShape::array     ? field.capacity
                              : field.shape == FieldShape::bounded ? random() % (field.capacity + 1)
                                                                   : random() % 4;
    for (std::size_t i = 0; i < count; ++i) list.push_back(random_value(field, random));
  }
  return out;
}

/// Every type that there is, in every form.
inline std::vector<const TypeInfo*> all_types() {
  std::vector<const TypeInfo*> out(types().begin(), types().end());
  for (const auto& own : {humble_types(), kilted_types()}) out.insert(out.end(), own.begin(), own.end());
  return out;
}

}  // namespace polyarm::messages::test
