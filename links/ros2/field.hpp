#pragma once
/// Places in a message, and values of tags there.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/messages/type_info.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::ros2 {

using Json = nlohmann::json;

/// "twist.linear.x", "poses[0]", "transforms[child_frame_id=part].transform", or "": the whole message.
class Field {
 public:
  /// Throws Error("bad-link") that says what there is instead. `type` must outlive it.
  Field(const messages::TypeInfo& type, const std::string& path);

  /// Null where a list is too short, or has no such element.
  const Json* find(const Json& message) const;
  /// Makes what is missing on the way; a list becomes as long as it must.
  void set(Json& message, Json value) const;

  /// Of the field itself; null: the whole message.
  const messages::FieldInfo* info() const { return steps_.empty() ? nullptr : steps_.back().field; }
  /// Of the struct that stands there; null where it is none.
  const messages::TypeInfo* type() const;

 private:
  struct Step {
    const messages::FieldInfo* field;
    std::optional<std::size_t> index;
    std::string key, value;  ///< of the element of a list
  };
  const messages::TypeInfo* type_;
  std::vector<Step> steps_;
};

/// Throws Error("bad-link") where a tag of this type cannot stand there.
void check_fits(const signals::LinkTag& tag, const Field& field);

/// What stands there as the tag's value; nothing, and why, where it may not be taken.
std::optional<data::Value> value_of(const signals::LinkTag& tag, const Json& given, std::string& why);
/// The tag's value as it stands there.
Json json_of(const signals::LinkTag& tag, const Field& field, const data::Value& value);
/// A constant as it stands there, from its text.
Json constant_of(const Field& field, const std::string& text);

}  // namespace polyarm::ros2
