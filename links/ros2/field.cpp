#include "links/ros2/field.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::ros2 {

namespace {

using messages::FieldInfo;
using messages::FieldKind;
using messages::FieldShape;
using messages::TypeInfo;
using signals::LinkTag;

/// For a pose, nested fields with these names are searched.
constexpr std::array<const char*, 3> kPlaces{"pose", "transform", "point"};

[[noreturn]] void refuse(const std::string& what, const std::string& advice = {}) {
  throw Error("bad-link", what, advice);
}

/// Splits at dots outside of brackets.
std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> out;
  std::string part;
  int depth = 0;
  for (const char c : path) {
    depth += c == '[' ? 1 : c == ']' ? -1 : 0;
    if (c == '.' && depth == 0)
      out.push_back(std::exchange(part, {}));
    else
      part += c;
  }
  if (!part.empty() || !out.empty()) out.push_back(part);
  return out;
}

const FieldInfo& field_of(const TypeInfo& type, const std::string& name) {
  std::vector<std::string> names;
  for (const FieldInfo& field : type.fields) {
    if (name == field.name) return field;
    names.emplace_back(field.name);
  }
  refuse(std::string(type.name) + " has no field '" + name + "'" + did_you_mean(name, names),
         "it has: " + join(names, ", "));
}

bool ends_with(const TypeInfo& type, std::string_view end) {
  return std::string_view(type.name).ends_with(end);
}

Json xyz(const Vec3& v, double scale) {
  return {{"x", v.x / scale}, {"y", v.y / scale}, {"z", v.z / scale}};
}
Json xyzw(const Quaternion& q) {
  return {{"x", q.x}, {"y", q.y}, {"z", q.z}, {"w", q.w}};
}

/// A pose as JSON of the given type; null if the type has no field for a pose.
Json place(const TypeInfo& type, const Pose& pose, double scale) {
  if (ends_with(type, "/Pose"))
    return {{"position", xyz(pose.position, scale)}, {"orientation", xyzw(pose.rotation)}};
  if (ends_with(type, "/Transform"))
    return {{"translation", xyz(pose.position, scale)}, {"rotation", xyzw(pose.rotation)}};
  if (ends_with(type, "/Point") || ends_with(type, "/Vector3")) return xyz(pose.position, scale);
  for (const FieldInfo& field : type.fields)
    for (const char* name : kPlaces)
      if (field.nested && field.shape == FieldShape::single && std::string_view(field.name) == name)
        if (Json inner = place(*field.nested, pose, scale); !inner.is_null())
          return {{field.name, std::move(inner)}};
  return nullptr;
}

bool append(const Json& from, std::initializer_list<const char*> names, std::vector<double>& out) {
  for (const char* name : names) {
    if (!from.is_object() || !from.contains(name) || !from[name].is_number()) return false;
    out.push_back(from[name].get<double>());
  }
  return true;
}

/// x, y, z and a quaternion from any message with a pose; a point gets the identity rotation.
std::optional<std::vector<double>> numbers_of_place(const Json& given) {
  if (!given.is_object()) return std::nullopt;
  for (const auto& [position, rotation] :
       {std::pair{"position", "orientation"}, std::pair{"translation", "rotation"}}) {
    if (!given.contains(position) || !given.contains(rotation)) continue;
    std::vector<double> out;
    if (append(given[position], {"x", "y", "z"}, out) && append(given[rotation], {"x", "y", "z", "w"}, out))
      return out;
    return std::nullopt;
  }
  for (const char* name : kPlaces)
    if (given.contains(name)) return numbers_of_place(given[name]);
  std::vector<double> out;
  if (given.contains("w") || !append(given, {"x", "y", "z"}, out)) return std::nullopt;
  out.insert(out.end(), {0, 0, 0, 1});
  return out;
}

bool is_number(FieldKind kind) {
  return (kind >= FieldKind::int8 && kind <= FieldKind::float64) || kind == FieldKind::byte;
}
bool is_whole(FieldKind kind) {
  return is_number(kind) && kind != FieldKind::float32 && kind != FieldKind::float64;
}

/// The range of an integer field, as far as a double can represent it.
std::pair<double, double> range_of(FieldKind kind) {
  switch (kind) {
    case FieldKind::int8:
      return {-128, 127};
    case FieldKind::int16:
      return {-32768, 32767};
    case FieldKind::uint16:
      return {0, 65535};
    case FieldKind::int32:
      return {-2147483648.0, 2147483647.0};
    case FieldKind::uint32:
      return {0, 4294967295.0};
    case FieldKind::int64:
      return {-9.0e18, 9.0e18};
    case FieldKind::uint64:
      return {0, 9.0e18};
    default:
      return {0, 255};
  }
}

Json number_of(FieldKind kind, double value) {
  if (kind == FieldKind::boolean) return value != 0;
  if (!is_whole(kind)) return value;
  const auto [least, most] = range_of(kind);
  return static_cast<std::int64_t>(std::round(std::clamp(value, least, most)));
}

const char* name_of(LinkTag::Type type) {
  constexpr const char* kNames[] = {"a boolean", "a number", "a text", "a pose"};
  return kNames[static_cast<std::size_t>(type)];
}

}  // namespace

Field::Field(const TypeInfo& type, const std::string& path) : type_{&type} {
  const TypeInfo* at = &type;
  for (const std::string& part : parts_of(path)) {
    if (!at) refuse("'" + path + "' continues where " + type.name + " has no more fields");
    const std::size_t bracket = part.find('[');
    Step step{&field_of(*at, part.substr(0, bracket)), {}, {}, {}};
    const bool list = step.field->shape != FieldShape::single;
    if (list != (bracket != std::string::npos))
      refuse("'" + path + "': " + step.field->name + (list ? " is a list" : " is not a list"),
             list ? std::string(step.field->name) + "[0], or " + step.field->name + "[name=…]" : "");
    if (list) {
      if (!part.ends_with(']')) refuse("'" + path + "': a bracket is not closed");
      const std::string inside = part.substr(bracket + 1, part.size() - bracket - 2);
      const std::size_t equals = inside.find('=');
      const auto number = equals == std::string::npos ? parse_number(inside) : std::nullopt;
      if (number && *number >= 0 && *number < 10'000 && *number == std::floor(*number))
        step.index = static_cast<std::size_t>(*number);
      else if (equals == std::string::npos || !step.field->nested)
        refuse("'" + path + "': '" + inside + "' is not a place in a list", "[0], or [name=…]");
      else
        step.key = field_of(*step.field->nested, inside.substr(0, equals)).name,
        step.value = inside.substr(equals + 1);
    }
    steps_.push_back(std::move(step));
    at = steps_.back().field->nested;
  }
}

const TypeInfo* Field::type() const {
  return steps_.empty() ? type_ : steps_.back().field->nested;
}

const Json* Field::find(const Json& message) const {
  const Json* at = &message;
  for (const Step& step : steps_) {
    const auto field = at->find(step.field->name);
    if (field == at->end()) return nullptr;
    at = &*field;
    if (step.index) {
      if (*step.index >= at->size()) return nullptr;
      at = &(*at)[*step.index];
    } else if (!step.key.empty()) {
      const auto has = [&](const Json& element) {
        const Json& given = element[step.key];
        return given.is_string() ? given.get_ref<const std::string&>() == step.value
                                 : given.dump() == step.value;
      };
      const auto element = std::find_if(at->begin(), at->end(), has);
      if (element == at->end()) return nullptr;
      at = &*element;
    }
  }
  return at;
}

void Field::set(Json& message, Json value) const {
  Json* at = &message;
  for (const Step& step : steps_) {
    at = &(*at)[step.field->name];
    if (step.field->shape == FieldShape::single) continue;
    if (!at->is_array()) *at = Json::array();
    std::size_t index = step.index.value_or(at->size());
    if (!step.index)
      for (std::size_t i = at->size(); i-- > 0;)
        if ((*at)[i][step.key] == step.value) index = i;
    const std::size_t size =
        step.field->shape == FieldShape::array ? step.field->capacity : std::max(at->size(), index + 1);
    while (at->size() < size)
      at->push_back(step.field->nested ? Json::object() : number_of(step.field->kind, 0));
    at = &(*at)[index];
    if (!step.index) (*at)[step.key] = step.value;
  }
  if (value.is_object() && at->is_object())
    at->update(value, true);
  else
    *at = std::move(value);
}

void check_fits(const LinkTag& tag, const Field& field) {
  bool fits = false;
  if (tag.type == LinkTag::Type::pose) {
    fits = field.type() && !place(*field.type(), {}, 1).is_null();
  } else if (field.info() && !field.type()) {
    const FieldKind kind = field.info()->kind;
    fits = (kind == FieldKind::string) == (tag.type == LinkTag::Type::text);
  }
  if (!fits)
    refuse("'" + tag.name + "' is " + name_of(tag.type) + ", which does not fit '" + tag.field + "' of " +
               tag.message,
           "set `type:` (bool, number, text, pose) and `field:`");
}

std::optional<data::Value> value_of(const LinkTag& tag, const Json& given, std::string& why) {
  if (tag.type == LinkTag::Type::text && given.is_string()) return data::Value(given.get<std::string>());
  if (tag.type == LinkTag::Type::boolean || tag.type == LinkTag::Type::number) {
    if (given.is_null()) {
      why = "it is not a finite number";
      return std::nullopt;
    }
    if (given.is_boolean() || given.is_number()) {
      const double number = given.is_boolean() ? (given.get<bool>() ? 1 : 0) : given.get<double>();
      if (tag.type == LinkTag::Type::boolean) return data::Value(number != 0);
      return signals::taken_number(tag, number, why);
    }
  }
  if (tag.type == LinkTag::Type::pose) {
    if (const auto numbers = numbers_of_place(given)) return signals::taken_pose(tag, *numbers, why);
    why = "it contains no complete pose";
    return std::nullopt;
  }
  why = std::string("it is not ") + name_of(tag.type);
  return std::nullopt;
}

Json json_of(const LinkTag& tag, const Field& field, const data::Value& value) {
  if (tag.type == LinkTag::Type::pose) {
    const data::Point* point = value.as_point();
    return point ? place(*field.type(), point->pose, tag.scale) : Json();
  }
  if (tag.type == LinkTag::Type::text) return value.text();
  return number_of(field.info()->kind, signals::given_number(tag, value));
}

Json constant_of(const Field& field, const std::string& text) {
  if (!field.info() || field.type()) refuse("`with` may contain only a text, a number or a boolean");
  if (field.info()->kind == FieldKind::string) return text;
  if (text == "true" || text == "false") return number_of(field.info()->kind, text == "true" ? 1 : 0);
  const auto number = parse_number(text);
  if (!number) refuse("'" + text + "' in `with` is not a number");
  return number_of(field.info()->kind, *number);
}

}  // namespace polyarm::ros2
