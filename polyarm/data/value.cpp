#include "polyarm/data/value.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/data/telling.hpp"

namespace polyarm::data {

namespace {
/// At most `digits` significant digits; whole numbers below 1e15 keep all of theirs.
double rounded_to(double value, int digits) {
  constexpr double kWhole = 1e15;
  if (!std::isfinite(value) || (std::abs(value) < kWhole && value == std::floor(value))) return value;
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific, digits - 1);
  double out = value;
  std::from_chars(text, end.ptr, out);
  return out;
}

std::string number_text(double value, int digits) {
  return format_number(digits > 0 ? rounded_to(value, digits) : value);
}

std::string join_numbers(std::initializer_list<double> numbers, int digits) {
  std::string out;
  for (const double number : numbers) out += (out.empty() ? "" : ", ") + number_text(number, digits);
  return out;
}

std::string text_of(const JointState& joints, int digits) {
  std::string out;
  if (joints.names.empty())
    for (const double position : joints.positions) out += (out.empty() ? "" : ", ") + number_text(position, digits);
  for (std::size_t i = 0; i < joints.names.size() && i < joints.positions.size(); ++i)
    out += (i ? ", " : "") + joints.names[i] + ": " + number_text(joints.positions[i], digits);
  return "{" + out + "}";
}

std::string text_of(const Point& point, int digits) {
  const Vec3& p = point.pose.position;
  const Quaternion& q = point.pose.rotation;
  const Vec3 rpy = to_rpy(q);
  return "xyz(" + join_numbers({p.x, p.y, p.z}, digits) +
         (point.quaternion_given ? ") quaternion(" + join_numbers({q.x, q.y, q.z, q.w}, digits)
                                 : ") rpy(" + join_numbers({rpy.x, rpy.y, rpy.z}, digits)) +
         ")" + (point.frame().empty() ? "" : " in " + point.frame());
}

/// Collects what this thread releases.
thread_local Remains* keeping = nullptr;
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
  return at != names.end() && index < positions.size() ? &positions[index] : nullptr;
}

void JointState::note_given(std::size_t index, Dimension dimension) {
  if (index >= given.size() && dimension == Dimension::none) return;
  if (index >= given.size()) given.resize(index + 1, Dimension::none);
  given[index] = dimension;
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
Value::Value(List value, Extent known) : Value(std::move(value)) {
  content_.shared->extent.store(packed(known), std::memory_order_relaxed);
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

/// Releases this copy's share of the content. The last owner deletes the content.
void Value::release_now() noexcept {
  constexpr std::size_t kLarge = 64;
  Shared* shared = content_.shared;
  const bool alone = shared->users.load(std::memory_order_acquire) == 1;
  if (!alone && shared->users.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
  if (keeping && kind_ == Kind::list && as_list()->size() > kLarge) {
    shared->users.store(1, std::memory_order_relaxed);
    Value& kept = keeping->wholes_.emplace_back();
    kept.content_.shared = shared;
    kept.kind_ = kind_;
    return;
  }
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
  release_now();
  content_.shared = mine;
}

List* Value::own_parts() {
  if (kind_ == Kind::list) return &own<List>();
  return kind_ == Kind::record ? &own<Record>().values : nullptr;
}

void Value::replaced(Extent before, Extent after) {
  Extent now = extent();
  now.values += after.values - before.values;
  now.depth = std::max(now.depth, after.depth + 1);
  content_.shared->extent.store(packed(now), std::memory_order_relaxed);
}

/// Grows in few large steps, because moving the parts costs more than unused memory.
void Value::append(Value part) {
  constexpr std::size_t kSmall = 256, kTimes = 4;
  const Extent before = extent(), more = part.extent();
  List& list = own<List>();
  if (list.size() == list.capacity() && list.size() >= kSmall) list.reserve(kTimes * list.size());
  list.push_back(std::move(part));
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
  std::string out;
  ValueWriter telling(*this);
  while (!telling.go_on(out, out.max_size() - out.size())) continue;
  return out;
}

std::string Value::excerpt(std::size_t bytes) const {
  std::string out;
  ValueWriter telling(*this);
  if (kind_ == Kind::text) {
    out = as_text()->substr(0, bytes + 1);
  } else {
    telling.go_on(out, bytes + 1);
  }
  if (out.size() <= bytes) return out;
  while (bytes > 0 && (static_cast<unsigned char>(out[bytes]) & 0xC0) == 0x80) --bytes;
  return out.substr(0, bytes) + "…";
}

// Writing text in pieces.

void ValueWriter::open(const Value& whole) {
  open_.push_back({&whole, 0});
}

void ValueWriter::tell(const Value& value, std::string& out) {
  switch (value.kind()) {
    case Kind::boolean:
      out += *value.as_boolean() ? "True" : "False";
      return;
    case Kind::number:
      out += number_text(value.as_number()->value, digits_);
      out += unit_text(value.as_number()->dimension);
      return;
    case Kind::text:
      out += *value.as_text();
      return;
    case Kind::joints:
      out += text_of(*value.as_joints(), digits_);
      return;
    case Kind::pose:
      out += text_of(*value.as_point(), digits_);
      return;
    default:
      out += value.as_list() ? '[' : '{';
      open(value);
  }
}

bool ValueWriter::go_on(std::string& out, std::size_t bytes) {
  const std::size_t end = out.size() + bytes;
  if (!std::exchange(begun_, true)) tell(value_, out);
  while (!open_.empty() && out.size() < end) {
    Level& level = open_.back();
    const Record* record = level.whole->as_record();
    const List& parts = record ? record->values : *level.whole->as_list();
    if (level.next == parts.size()) {
      out += record ? '}' : ']';
      open_.pop_back();
      continue;
    }
    if (level.next > 0) out += ", ";
    if (record) out += record->names[level.next] + " = ";
    tell(parts[level.next++], out);
  }
  return open_.empty();
}

// Releasing memory in steps.

Remains::Keeping::Keeping(Remains& remains) : before_{std::exchange(keeping, &remains)} {}
Remains::Keeping::~Keeping() {
  keeping = before_;
}

int Remains::free(int steps) {
  const int given = steps;
  const Keeping nested(*this);  // nested lists are collected too
  while (steps > 0 && !wholes_.empty()) {
    Value whole = std::move(wholes_.back());
    wholes_.pop_back();
    List& parts = *whole.own_parts();
    for (; steps > 0 && !parts.empty(); parts.pop_back()) steps -= parts.back().is_shared() ? kShared : 1;
    if (!parts.empty()) wholes_.push_back(std::move(whole));
  }
  return given - steps;
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
