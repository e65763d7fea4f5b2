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

static std::uint64_t packed(const Value::Extent& extent) {
  return std::uint64_t{extent.depth} << 32 | extent.values;
}

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

Value::Value(std::string value) : kind_{Kind::text} {
  content_.shared = new Held<std::string>(std::move(value));
}
Value::Value(List value) : kind_{Kind::list} {
  content_.shared = new Held<List>(std::move(value));
}
Value::Value(JointState value) : kind_{Kind::joints} {
  content_.shared = new Held<JointState>(std::move(value));
}
Value::Value(Point value) : kind_{Kind::pose} {
  content_.shared = new Held<Point>(std::move(value));
}
Value::Value(Record value) : kind_{Kind::record} {
  content_.shared = new Held<Record>(std::move(value));
}

/// The last one deletes it.
void Value::let_go() noexcept {
  Shared* shared = content_.shared;
  const bool alone = shared->users.load(std::memory_order_acquire) == 1;
  if (!alone && shared->users.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
  switch (kind_) {
    case Kind::text:
      delete static_cast<Held<std::string>*>(shared);
      return;
    case Kind::list:
      delete static_cast<Held<List>*>(shared);
      return;
    case Kind::joints:
      delete static_cast<Held<JointState>*>(shared);
      return;
    case Kind::pose:
      delete static_cast<Held<Point>*>(shared);
      return;
    default:
      delete static_cast<Held<Record>*>(shared);
      return;
  }
}

template <typename Large>
void Value::part_from_others() {
  const auto* others = static_cast<const Held<Large>*>(content_.shared);
  auto* mine = new Held<Large>(others->content);
  mine->extent.store(others->extent.load(std::memory_order_relaxed), std::memory_order_relaxed);
  let_go();
  content_.shared = mine;
}

List* Value::own_parts() {
  if (kind_ == Kind::list) return &own<List>();
  return kind_ == Kind::record ? &own<Record>().values : nullptr;
}

void Value::append(Value part) {
  const Extent before = extent(), more = part.extent();
  own<List>().push_back(std::move(part));
  content_.shared->extent.store(packed({before.values + more.values, std::max(before.depth, more.depth + 1)}),
                                std::memory_order_relaxed);
}

void Value::append(std::string_view more) {
  own<std::string>() += more;
}

Value::Extent Value::extent() const {
  const List* parts = kind_ == Kind::list     ? as_list()
                      : kind_ == Kind::record ? &as_record()->values
                                              : nullptr;
  if (!parts) return {};
  const std::uint64_t known = content_.shared->extent.load(std::memory_order_relaxed);
  if (known != 0) return {static_cast<std::uint32_t>(known), static_cast<std::uint32_t>(known >> 32)};
  Extent out{1, 1};
  for (const Value& part : *parts) {
    const Extent each = part.extent();
    out.values += each.values;
    out.depth = std::max(out.depth, each.depth + 1);
  }
  content_.shared->extent.store(packed(out), std::memory_order_relaxed);
  return out;
}

std::string Value::text() const {
  switch (kind_) {
    case Kind::boolean:
      return content_.truth ? "True" : "False";
    case Kind::number:
      return format_number(content_.number.value) + unit_text(content_.number.dimension);
    case Kind::text:
      return *as_text();
    case Kind::list:
      return text_of(*as_list());
    case Kind::joints:
      return text_of(*as_joints());
    case Kind::pose:
      return text_of(*as_point());
    default:
      return text_of(*as_record());
  }
}

bool operator==(const Value& a, const Value& b) {
  if (a.kind_ != b.kind_) return false;
  if (a.is_shared() && a.content_.shared == b.content_.shared) return true;
  switch (a.kind_) {
    case Kind::boolean:
      return a.content_.truth == b.content_.truth;
    case Kind::number:
      return a.content_.number == b.content_.number;
    case Kind::text:
      return *a.as_text() == *b.as_text();
    case Kind::list:
      return *a.as_list() == *b.as_list();
    case Kind::joints:
      return *a.as_joints() == *b.as_joints();
    case Kind::pose:
      return *a.as_point() == *b.as_point();
    default:
      return *a.as_record() == *b.as_record();
  }
}

}  // namespace polyarm::data
