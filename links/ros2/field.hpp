#pragma once
/// Fields of ROS messages by path, and the values of tags in them.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/messages/type_info.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::ros2 {

using Json = nlohmann::json;

/// The path of a field: "twist.linear.x", "poses[0]", "transforms[child_frame_id=part].transform", or "" for
/// the whole message.
class Field {
 public:
  /// Throws Error("bad-link") that lists the available fields. `type` must outlive this.
  Field(const messages::TypeInfo& type, const std::string& path);

  /// Null if a list is too short or has no such element.
  const Json* find(const Json& message) const;
  /// Creates missing parents; lists are extended as needed.
  void set(Json& message, Json value) const;

  /// The field's description; null for the whole message.
  const messages::FieldInfo* info() const { return steps_.empty() ? nullptr : steps_.back().field; }
  /// The struct type of the field; null if it is not a struct.
  const messages::TypeInfo* type() const;

 private:
  struct Step {
    const messages::FieldInfo* field;
    std::optional<std::size_t> index;
    std::string key, value;  ///< selects the element of a list
  };
  const messages::TypeInfo* type_;
  std::vector<Step> steps_;
};

/// Throws Error("bad-link") if a tag of this type does not fit the field.
void check_fits(const signals::LinkTag& tag, const Field& field);

/// The field's JSON as the tag's value. Nothing if it is refused, with the reason in `why`.
std::optional<data::Value> value_of(const signals::LinkTag& tag, const Json& given, std::string& why);
/// The tag's value as JSON for the field.
Json json_of(const signals::LinkTag& tag, const Field& field, const data::Value& value);
/// A constant for the field, parsed from its text.
Json constant_of(const Field& field, const std::string& text);

}  // namespace polyarm::ros2
