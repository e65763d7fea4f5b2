#include "polyarm/messages/json.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::messages {

using nlohmann::json;

namespace {

/// Calls `with` with a value of the C++ number type for this kind.
template <class With>
void with_number(FieldKind kind, With with) {
  switch (kind) {
    case FieldKind::int8:
      return with(std::int8_t{});
    case FieldKind::uint8:
    case FieldKind::byte:
      return with(std::uint8_t{});
    case FieldKind::int16:
      return with(std::int16_t{});
    case FieldKind::uint16:
      return with(std::uint16_t{});
    case FieldKind::int32:
      return with(std::int32_t{});
    case FieldKind::uint32:
      return with(std::uint32_t{});
    case FieldKind::int64:
      return with(std::int64_t{});
    case FieldKind::uint64:
      return with(std::uint64_t{});
    case FieldKind::float32:
      return with(float{});
    case FieldKind::float64:
      return with(double{});
    default:
      return;
  }
}

json read_type(CdrReader& in, const TypeInfo& type);

json read_one(CdrReader& in, const FieldInfo& field) {
  if (field.kind == FieldKind::nested) return read_type(in, *field.nested);
  if (field.kind == FieldKind::string) {
    std::string text;
    in.read(text);
    return text;
  }
  if (field.kind == FieldKind::boolean) {
    bool truth = false;
    in.read(truth);
    return truth;
  }
  json out;
  with_number(field.kind, [&](auto number) {
    in.read(number);
    if (!std::is_floating_point_v<decltype(number)> || std::isfinite(static_cast<double>(number)))
      out = number;
  });
  return out;
}

json read_type(CdrReader& in, const TypeInfo& type) {
  json out = json::object();
  std::uint8_t nothing = 0;
  if (type.fields.empty()) in.read(nothing);
  for (const FieldInfo& field : type.fields) {
    if (!in) return out;
    if (field.shape == FieldShape::single) {
      out[field.name] = read_one(in, field);
      continue;
    }
    json& list = out[field.name] = json::array();
    const std::size_t count = field.shape == FieldShape::array ? field.capacity
                              : field.shape == FieldShape::bounded
                                  ? in.read_length(field.least, field.capacity)
                                  : in.read_length(field.least);
    for (std::size_t i = 0; i < count && in; ++i) list.push_back(read_one(in, field));
  }
  return out;
}

class Writer {
 public:
  explicit Writer(std::span<std::byte> room) : out_{room} {}
  std::size_t size() const { return out_.size(); }

  void type(const TypeInfo& type, const json& message) {
    if (type.fields.empty()) return out_.write(std::uint8_t{0});
    if (message.is_number() && is_time(type)) return time(message.get<double>());
    if (!message.is_object() && !message.is_null()) refuse(std::string("a ") + type.name, message);
    for (const FieldInfo& field : type.fields) {
      static const json nothing;
      const auto at = message.is_object() ? message.find(field.name) : message.end();
      const bool there = message.is_object() && at != message.end();
      const std::size_t length = path_.size();
      path_ += (path_.empty() ? "" : ".") + std::string(field.name);
      value(field, there ? *at : nothing, there);
      path_.resize(length);
    }
  }

 private:
  static bool is_time(const TypeInfo& type) {
    const std::string_view name = type.name;
    return name == "builtin_interfaces/msg/Time" || name == "builtin_interfaces/msg/Duration";
  }
  void time(double seconds) {
    const double whole = std::floor(seconds);
    if (!(std::abs(whole) < 2'147'483'000.0)) refuse("a time", json(seconds));
    out_.write(static_cast<std::int32_t>(whole));
    out_.write(static_cast<std::uint32_t>(std::min((seconds - whole) * 1e9, 999'999'999.0)));
  }

  [[noreturn]] void refuse(const std::string& wanted, const json& given) const {
    std::string text = given.dump(-1, ' ', false, json::error_handler_t::replace);
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    throw Error("bad-message", (path_.empty() ? "the message" : path_) + " is " + text + ", not " + wanted);
  }

  void value(const FieldInfo& field, const json& given, bool there) {
    if (field.shape == FieldShape::single) return one(field, given, there);
    if (there && !given.is_array() && !given.is_null()) refuse("a list", given);
    const std::size_t count = given.is_array() ? given.size() : 0;
    const bool array = field.shape == FieldShape::array;
    const bool fits = array ? count == 0 || count == field.capacity
                            : field.shape != FieldShape::bounded || count <= field.capacity;
    if (!fits)
      refuse("a list of " + std::string(array ? "" : "at most ") + std::to_string(field.capacity), given);
    if (!array) out_.write_length(count);
    static const json nothing;
    for (std::size_t i = 0; i < (array ? field.capacity : count); ++i)
      one(field, i < count ? given[i] : nothing, i < count);
  }

  void one(const FieldInfo& field, const json& given, bool there) {
    if (field.kind == FieldKind::nested) return type(*field.nested, given);
    if (field.kind == FieldKind::string) {
      if (there && !given.is_string()) refuse("a text", given);
      return out_.write(there ? given.get_ref<const std::string&>() : std::string());
    }
    if (field.kind == FieldKind::boolean) {
      if (there && !given.is_boolean()) refuse("true or false", given);
      return out_.write(there && given.get<bool>());
    }
    with_number(field.kind, [&](auto number) { out_.write(number_of(given, there, number)); });
  }

  template <class T>
  T number_of(const json& given, bool there, T) const {
    if (!there) return T{};
    if constexpr (std::is_floating_point_v<T>) {
      if (given.is_null()) return std::numeric_limits<T>::quiet_NaN();
      if (!given.is_number()) refuse("a number", given);
      return given.get<T>();
    } else {
      if (given.is_number_float()) return whole_number_of<T>(given);
      const bool sign = given.is_number_integer() && !given.is_number_unsigned();
      const bool whole = given.is_number_unsigned() ? std::in_range<T>(given.get<std::uint64_t>())
                                                    : sign && std::in_range<T>(given.get<std::int64_t>());
      if (!whole) refuse("a whole number that fits", given);
      return static_cast<T>(sign ? static_cast<T>(given.get<std::int64_t>())
                                 : static_cast<T>(given.get<std::uint64_t>()));
    }
  }

  /// 3.0 is 3: a cell's numbers have no type.
  template <class T>
  T whole_number_of(const json& given) const {
    const double value = given.get<double>();
    if (!(value >= -9e15 && value <= 9e15) || value != std::floor(value) ||
        !std::in_range<T>(static_cast<std::int64_t>(value)))
      refuse("a whole number that fits", given);
    return static_cast<T>(static_cast<std::int64_t>(value));
  }

  CdrWriter out_;
  std::string path_;
};

}  // namespace

CdrError to_json(const TypeInfo& type, std::span<const std::byte> payload, json& out) {
  CdrReader in(payload);
  out = read_type(in, type);
  in.finish();
  return in.error();
}

std::vector<std::byte> from_json(const TypeInfo& type, const json& message) {
  Writer counter({});
  counter.type(type, message);
  std::vector<std::byte> out(counter.size());
  Writer(out).type(type, message);
  return out;
}

}  // namespace polyarm::messages
