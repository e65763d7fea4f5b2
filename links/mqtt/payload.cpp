#include "links/mqtt/payload.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "polyarm/base/text.hpp"

namespace polyarm::mqtt {

namespace {
using Json = nlohmann::json;
using signals::LinkTag;

std::string shortened(const std::string& text) {
  std::string out = text.substr(0, 40);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
  return out + (text.size() > 40 ? "…" : "");
}

Json json_of(const LinkTag& tag, const data::Value& value) {
  if (tag.type == LinkTag::Type::boolean) return value.as_boolean() && *value.as_boolean();
  if (tag.type == LinkTag::Type::number) return signals::given_number(tag, value);
  if (tag.type == LinkTag::Type::text) return value.text();
  const std::vector<double> n = signals::given_pose(tag, value);
  if (n.size() != 6) return nullptr;
  return {{"x", n[0]}, {"y", n[1]}, {"z", n[2]}, {"rx", n[3]}, {"ry", n[4]}, {"rz", n[5]}};
}

std::optional<data::Value> flag_of(const std::string& text, std::string& why) {
  for (const char* word : {"true", "1", "on"})
    if (equal_ignoring_case(text, word)) return data::Value(true);
  for (const char* word : {"false", "0", "off"})
    if (equal_ignoring_case(text, word)) return data::Value(false);
  why = "'" + shortened(text) + "' is not a boolean";
  return std::nullopt;
}

std::optional<data::Value> value_of_text(const LinkTag& tag, const std::string& text, std::string& why) {
  if (tag.type == LinkTag::Type::boolean) return flag_of(std::string(trim(text)), why);
  if (tag.type == LinkTag::Type::text) return data::Value(text);
  if (tag.type == LinkTag::Type::number) {
    if (const auto number = parse_number(text)) return signals::taken_number(tag, *number, why);
    why = "'" + shortened(text) + "' is not a number";
    return std::nullopt;
  }
  std::vector<double> numbers;
  for (const std::string& field : split_fields(text, ',')) {
    const auto number = parse_number(field);
    if (!number) {
      why = "'" + shortened(field) + "' is not a number of a pose";
      return std::nullopt;
    }
    numbers.push_back(*number);
  }
  return signals::taken_pose(tag, numbers, why);
}

/// The numbers of a pose, as a list or by name; nothing if one is missing.
std::optional<std::vector<double>> numbers_of_pose(const Json& json) {
  std::vector<double> out;
  if (json.is_array()) {
    for (const Json& item : json) {
      if (!item.is_number()) return std::nullopt;
      out.push_back(item.get<double>());
    }
    return out;
  }
  if (!json.is_object()) return std::nullopt;
  const bool quaternion = json.contains("qw");
  const std::vector<const char*> names = quaternion
                                             ? std::vector<const char*>{"x", "y", "z", "qx", "qy", "qz", "qw"}
                                             : std::vector<const char*>{"x", "y", "z", "rx", "ry", "rz"};
  for (const char* name : names) {
    if (!json.contains(name) || !json[name].is_number()) return std::nullopt;
    out.push_back(json[name].get<double>());
  }
  return out;
}

std::optional<data::Value> value_of_json(const LinkTag& tag, const Json& json, std::string& why) {
  if (tag.type == LinkTag::Type::boolean && json.is_boolean()) return data::Value(json.get<bool>());
  if (tag.type == LinkTag::Type::boolean && json.is_number()) return data::Value(json.get<double>() != 0);
  if (tag.type == LinkTag::Type::number && json.is_number())
    return signals::taken_number(tag, json.get<double>(), why);
  if (tag.type == LinkTag::Type::text && json.is_string()) return data::Value(json.get<std::string>());
  if (tag.type == LinkTag::Type::pose) {
    if (const auto numbers = numbers_of_pose(json)) return signals::taken_pose(tag, *numbers, why);
    why = "it contains no complete pose: {x, y, z, rx, ry, rz} or {x, y, z, qx, qy, qz, qw}, numbers";
    return std::nullopt;
  }
  constexpr const char* kTypes[] = {"a boolean", "a number", "a text", "a pose"};
  why = "it is " + std::string(json.type_name()) + ", not " + kTypes[static_cast<std::size_t>(tag.type)];
  return std::nullopt;
}
}  // namespace

std::string payload_of(const LinkTag& tag, const data::Value& value) {
  if (tag.json || tag.type == LinkTag::Type::pose) {
    Json out = json_of(tag, value);
    std::vector<std::string> fields =
        tag.field.empty() ? std::vector<std::string>{} : split_fields(tag.field, '.');
    for (; !fields.empty(); fields.pop_back()) out = Json{{fields.back(), out}};
    return out.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  if (tag.type == LinkTag::Type::number) return format_number(signals::given_number(tag, value));
  if (tag.type == LinkTag::Type::boolean) return value.as_boolean() && *value.as_boolean() ? "true" : "false";
  return value.text();
}

std::optional<data::Value> value_of_payload(const LinkTag& tag, const std::string& payload,
                                            std::string& why) {
  if (payload.size() > kLongestMessage) {
    why = "the message is " + std::to_string(payload.size()) + " bytes long";
    return std::nullopt;
  }
  if (!tag.json) return value_of_text(tag, payload, why);
  Json json = Json::parse(payload, nullptr, false);
  if (json.is_discarded()) {
    why = "'" + shortened(payload) + "' is no JSON";
    return std::nullopt;
  }
  for (const std::string& field :
       tag.field.empty() ? std::vector<std::string>{} : split_fields(tag.field, '.')) {
    if (!json.is_object() || !json.contains(field)) {
      why = "it has no field '" + tag.field + "'";
      return std::nullopt;
    }
    Json inner = json[field];
    json = std::move(inner);
  }
  return value_of_json(tag, json, why);
}

}  // namespace polyarm::mqtt
