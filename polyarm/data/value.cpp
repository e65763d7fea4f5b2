#include "polyarm/data/value.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"

namespace polyarm::data {

namespace {
std::string join_numbers(std::initializer_list<double> numbers) {
  std::string out;
  for (const double number : numbers) out += (out.empty() ? "" : ", ") + format_number(number);
  return out;
}

std::string text_of(bool value) {
  return value ? "True" : "False";
}
std::string text_of(const Number& number) {
  return format_number(number.value) + unit_text(number.dimension);
}
std::string text_of(const std::string& text) {
  return text;
}

std::string text_of(const List& list) {
  std::string out;
  for (const Value& item : list) out += (out.empty() ? "" : ", ") + item.text();
  return "[" + out + "]";
}

std::string text_of(const JointState& joints) {
  std::string out;
  if (joints.names.empty())
    for (const double position : joints.positions) out += (out.empty() ? "" : ", ") + format_number(position);
  for (std::size_t i = 0; i < joints.names.size() && i < joints.positions.size(); ++i)
    out += (i ? ", " : "") + joints.names[i] + ": " + format_number(joints.positions[i]);
  return "{" + out + "}";
}

std::string text_of(const Point& point) {
  const Vec3& p = point.pose.position;
  const Quaternion& q = point.pose.rotation;
  const Vec3 rpy = to_rpy(q);
  return "xyz(" + join_numbers({p.x, p.y, p.z}) +
         (point.quaternion_given ? ") quaternion(" + join_numbers({q.x, q.y, q.z, q.w})
                                 : ") rpy(" + join_numbers({rpy.x, rpy.y, rpy.z})) +
         ")" + (point.frame().empty() ? "" : " in " + point.frame());
}

std::string text_of(const Record& record) {
  std::string out;
  for (std::size_t i = 0; i < record.names.size(); ++i)
    out += (i ? ", " : "") + record.names[i] + " = " + record.values[i].text();
  return "{" + out + "}";
}
}  // namespace

const char* name(Kind kind) {
  switch (kind) {
    case Kind::boolean:
      return "a boolean";
    case Kind::number:
      return "a number";
    case Kind::text:
      return "a text";
    case Kind::list:
      return "a list";
    case Kind::joints:
      return "a joint state";
    case Kind::pose:
      return "a pose";
    case Kind::record:
      return "a record";
  }
  return "a value";
}

const char* unit_text(Dimension dimension) {
  switch (dimension) {
    case Dimension::none:
      return "";
    case Dimension::length:
      return "m";
    case Dimension::angle:
      return "rad";
    case Dimension::time:
      return "s";
    case Dimension::mass:
      return "kg";
    case Dimension::force:
      return "N";
    case Dimension::torque:
      return "Nm";
    case Dimension::rate:
      return "Hz";
    case Dimension::speed:
      return "m/s";
    case Dimension::angular_speed:
      return "rad/s";
    case Dimension::acceleration:
      return "m/s2";
    case Dimension::angular_acceleration:
      return "rad/s2";
  }
  return "";
}

const double* JointState::find(std::string_view joint) const {
  const auto at = std::find(names.begin(), names.end(), joint);
  const auto index = static_cast<std::size_t>(at - names.begin());
  return index < positions.size() ? &positions[index] : nullptr;
}

bool operator==(const JointState& a, const JointState& b) {
  if (a.names.size() != b.names.size() || a.positions.size() != b.positions.size()) return false;
  if (a.names.empty()) return a.positions == b.positions;
  return std::all_of(a.names.begin(), a.names.end(), [&](const std::string& joint) {
    const double* mine = a.find(joint);
    const double* other = b.find(joint);
    return mine && other && *mine == *other;
  });
}

const Value* Record::find(std::string_view field) const {
  const auto at = std::find(names.begin(), names.end(), field);
  return at == names.end() ? nullptr : &values[static_cast<std::size_t>(at - names.begin())];
}

static bool operator==(const Record& a, const Record& b) {
  return a.names.size() == b.names.size() &&
         std::all_of(a.names.begin(), a.names.end(), [&](const std::string& field) {
           const Value* other = b.find(field);
           return other && *a.find(field) == *other;
         });
}

std::string Value::text() const {
  return std::visit([](const auto& content) { return text_of(content); }, content_);
}

bool operator==(const Value& a, const Value& b) {
  return a.content_ == b.content_;
}

}  // namespace polyarm::data
