#include "polyarm/language/functions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/base/unit_advice.hpp"
#include "polyarm/data/point_frames.hpp"
#include "polyarm/language/rounding.hpp"
#include "polyarm/language/running_functions.hpp"
#include "polyarm/language/text_functions.hpp"

namespace polyarm::program {

using data::JointState;
using data::Kind;
using data::List;
using data::Number;
using data::Point;

namespace {
using Values = std::span<const Value>;
using Names = std::span<const std::string>;

[[noreturn]] void refuse(std::string what, std::string advice = {}) {
  throw OperationError{"bad-value", std::move(what), std::move(advice)};
}

double of(const Value& value) {
  return value.as_number()->value;
}
const Pose& pose_of(const Value& value) {
  return value.as_point()->pose;
}

Value number(double value, Dimension dimension = Dimension::none) {
  if (!std::isfinite(value)) throw OperationError{"overflow", "the result is not a finite number", {}};
  return Number{value, dimension};
}

Value length(Values a, Names) {
  if (a[0].as_list()) return static_cast<double>(a[0].as_list()->size());
  const std::string& text = *a[0].as_text();
  return static_cast<double>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

template <bool kLeast>
Value extreme(Values a, Names) {
  Value best = a[0];
  for (const Value& value : a)
    if (*apply(kLeast ? Operator::less : Operator::greater, value, best).as_boolean()) best = value;
  return best;
}

double floor_of(double value) {
  return std::floor(unrounded(value));
}
double ceil_of(double value) {
  return std::ceil(unrounded(value));
}
template <double (*kFunction)(double)>
Value keeping_unit(Values a, Names) {
  return number(kFunction(of(a[0])), a[0].as_number()->dimension);
}
template <double (*kFunction)(double), Dimension kGives>
Value mathematical(Values a, Names) {
  const double result = kFunction(of(a[0]));
  if (std::isnan(result)) refuse("this function has no value at " + a[0].text());
  return number(result, kGives);
}
Value atan2_of(Values a, Names) {
  if (a[0].as_number()->dimension != a[1].as_number()->dimension)
    refuse("atan2() takes two numbers of one unit, here are " + described(a[0]) + " and " + described(a[1]));
  return number(std::atan2(of(a[0]), of(a[1])), Dimension::angle);
}

void require_one_frame(const Point& a, const Point& b, const char* function) {
  if (a.frame().empty() || b.frame().empty() || a.frame() == b.frame()) return;
  refuse(std::string(function) + " takes poses of one frame, here are '" + a.frame() + "' and '" + b.frame() +
         "'");
}

Pose shift(Values a) {
  return pose_xyz_rpy({of(a[0]), of(a[1]), of(a[2])}, {of(a[3]), of(a[4]), of(a[5])});
}

Value pose(Values a, Names) {
  return Point{shift(a), false};
}

Value quat(Values a, Names) {
  const Quaternion q{of(a[0]), of(a[1]), of(a[2]), of(a[3])};
  const double size = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  if (!(size > 1e-12) || !std::isfinite(size))
    refuse("this quaternion has no direction", "one is 0, 0, 0, 1");
  return Point{{{of(a[4]), of(a[5]), of(a[6])}, normalized(q)}, true};
}

Value joints(Values a, Names names) {
  JointState out;
  const bool named = std::any_of(names.begin(), names.end(), [](const auto& n) { return !n.empty(); });
  for (std::size_t i = 0; i < a.size(); ++i) {
    out.note_given(i, a[i].as_number()->dimension);
    out.positions.push_back(of(a[i]));
    if (!named) continue;
    if (names[i].empty()) refuse("joints() has names for some of its values", "name all of them, or none");
    out.names.push_back(names[i]);
  }
  return out;
}

Value offset(Values a, Names) {
  const Pose& p = pose_of(a[0]);
  const Pose by = shift(a.subspan(1));
  const Quaternion axes = data::axes_of(*a[0].as_point());
  return data::in_frame_of(
      *a[0].as_point(), {p.position + axes * by.position, axes * by.rotation * inverse(axes) * p.rotation});
}

Value tool_offset(Values a, Names) {
  return data::in_frame_of(*a[0].as_point(), pose_of(a[0]) * shift(a.subspan(1)));
}

Value inverse_of(Values a, Names) {
  return Point{inverse(pose_of(a[0])), a[0].as_point()->quaternion_given};
}

Value distance(Values a, Names) {
  require_one_frame(*a[0].as_point(), *a[1].as_point(), "distance()");
  return number(norm(pose_of(a[0]).position - pose_of(a[1]).position), Dimension::length);
}

Pose between(const Pose& a, const Pose& b, double share) {
  const Vec3 turn = to_rotation_vector(inverse(a.rotation) * b.rotation);
  const double angle = norm(turn);
  const Quaternion part = angle > 0 ? from_axis_angle((1 / angle) * turn, share * angle) : Quaternion{};
  return {a.position + share * (b.position - a.position), normalized(a.rotation * part)};
}

Value interpolate(Values a, Names) {
  const double share = of(a[2]);
  if (a[0].as_point() && a[1].as_point()) {
    const Point &from = *a[0].as_point(), &to = *a[1].as_point();
    require_one_frame(from, to, "interpolate()");
    Point out = data::in_frame_of(from.frame().empty() ? to : from, between(from.pose, to.pose, share));
    out.quaternion_given = false;
    return out;
  }
  const JointState *first = a[0].as_joints(), *last = a[1].as_joints();
  if (!first || !last) refuse("interpolate() takes two poses or two joint states, not one of each");
  JointState out = *first;
  for (std::size_t i = 0; i < out.positions.size(); ++i) {
    const double* end =
        out.names.empty()
            ? (i < last->positions.size() && last->names.empty() ? &last->positions[i] : nullptr)
            : last->find(out.names[i]);
    if (!end) refuse("these two joint states are not of the same joints");
    if (out.given_at(i) == Dimension::none)
      out.note_given(i, last->given_at(static_cast<std::size_t>(end - last->positions.data())));
    out.positions[i] += share * (*end - out.positions[i]);
  }
  return out;
}

double as_field(const Value& value, Dimension dimension, const std::string& field) {
  const Number* n = value.as_number();
  const bool fits = n && (n->dimension == dimension || (n->dimension == Dimension::none && n->value == 0));
  if (fits) return n->value;
  throw OperationError{"bad-type", "'" + field + "' is " + name(dimension) + ", here is " + described(value),
                       n && n->dimension == Dimension::none ? unit_advice(dimension, n->value) : std::string{}};
}

/// A point that is changed is no longer the one that was taught.
Value unnamed(const Value& place) {
  if (place.as_joints()) return *place.as_joints();
  return data::in_frame_of(*place.as_point(), place.as_point()->pose);
}

void set_field_of(Value& of, const std::string& field, const Value& value) {
  if (of.as_record()) {
    const PathStep path{field, {}};
    return replace(of, {&path, 1}, value);
  }
  if (const JointState* joints = of.as_joints()) {
    JointState out = *joints;
    const auto at = std::find(out.names.begin(), out.names.end(), field);
    if (at == out.names.end())
      throw OperationError{"unknown-joint",
                           "this joint state has no '" + field + "'" + did_you_mean(field, out.names),
                           {}};
    const Number* n = value.as_number();  // of a slide it is a length
    const Dimension dimension = n && n->dimension == Dimension::length ? Dimension::length : Dimension::angle;
    const auto joint = static_cast<std::size_t>(at - out.names.begin());
    out.positions[joint] = as_field(value, dimension, field);
    out.note_given(joint, n->dimension);
    of = std::move(out);
    return;
  }
  Point point = *of.as_point();
  Vec3 turn = to_rpy(point.pose.rotation);
  const std::array<std::pair<const char*, double*>, 3> lengths = {
      {{"x", &point.pose.position.x}, {"y", &point.pose.position.y}, {"z", &point.pose.position.z}}};
  const std::array<std::pair<const char*, double*>, 3> angles = {
      {{"rx", &turn.x}, {"ry", &turn.y}, {"rz", &turn.z}}};
  for (const auto& [name, at] : lengths)
    if (field == name) return *at = as_field(value, Dimension::length, field), void(of = std::move(point));
  for (const auto& [name, at] : angles) {
    if (field != name) continue;
    *at = as_field(value, Dimension::angle, field);
    point.pose.rotation = pose_xyz_rpy({}, turn).rotation;
    point.quaternion_given = false;
    of = std::move(point);
    return;
  }
  throw OperationError{"bad-type", "a pose has no '" + field + "'", "a pose has x y z rx ry rz"};
}

/// `count` places of a grid along one edge; the first is at its start.
int count_of(const Value& value, const char* what) {
  const double n = unrounded(of(value));
  if (!is_whole(n) || n < 1 || n > static_cast<double>(kMostListItems))
    refuse(std::string("pallet() needs a whole number of ") + what + " from 1 to " +
           std::to_string(kMostListItems) + ", here is " + value.text());
  return static_cast<int>(n);
}

Series places_of_pallet(Values a) {
  const Pose corner = pose_of(a[0]);
  const int rows = count_of(a[3], "rows"), columns = count_of(a[4], "cols"),
            layers = count_of(a[5], "layers");
  if (static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) > kMostListItems ||
      static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) * static_cast<std::size_t>(layers) >
          kMostListItems)
    refuse("this pallet would have more than " + std::to_string(kMostListItems) + " places");
  const auto step = [&](const Value& end, int count) {
    return (count > 1 ? 1.0 / (count - 1) : 0.0) * (pose_of(end).position - corner.position);
  };
  const Point first = *a[0].as_point();
  for (const Value& end : {a[1], a[2]}) require_one_frame(first, *end.as_point(), "pallet()");
  const Vec3 along = step(a[1], columns), across = step(a[2], rows),
             up = data::axes_of(first) * Vec3{0, 0, of(a[6])};
  const auto of_layer = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  const auto place = [=](std::size_t i) -> Value {
    const std::size_t layer = i / of_layer, row = i % of_layer / static_cast<std::size_t>(columns),
                      column = i % static_cast<std::size_t>(columns);
    return data::in_frame_of(first, {corner.position + static_cast<double>(column) * along +
                                         static_cast<double>(row) * across + static_cast<double>(layer) * up,
                                     corner.rotation});
  };
  return {of_layer * static_cast<std::size_t>(layers), place};
}

Value pallet(Values a, Names) {
  const Series places = places_of_pallet(a);
  List out;
  for (std::size_t i = 0; i < places.count; ++i) out.push_back(places.at(i));
  return make_list(std::move(out));
}

Value with(Values a, Names names) {
  if (!a[0].is_place() && !a[0].as_record())
    refuse("with() copies a pose, a joint state or a record, here is " + described(a[0]),
           "write such as P with z = 10mm");
  Value out = a[0].as_record() ? a[0] : unnamed(a[0]);
  for (std::size_t i = 1; i < a.size(); ++i) {
    if (i >= names.size() || names[i].empty())
      refuse("with() needs the name of each new value", "write such as P with z = 10mm");
    set_field_of(out, names[i], a[i]);
  }
  return out;
}

Value here(Values, Names) {
  refuse("here() works only in a running program");
}
Value ask(Values, Names) {
  refuse("ask() works only in a running program");
}

std::vector<FunctionParameter> shifts(std::vector<FunctionParameter> before = {}) {
  for (const char* axis : {"x", "y", "z"}) before.push_back({axis, Wanted::length, 0.0});
  for (const char* axis : {"rx", "ry", "rz"}) before.push_back({axis, Wanted::angle, 0.0});
  return before;
}

std::vector<Function> all_functions() {
  using W = Wanted;
  const auto none = Dimension::none;
  const auto angle = Dimension::angle;
  const std::vector<FunctionParameter> one_number = {{"value", W::number, {}}};
  const std::vector<FunctionParameter> one_scalar = {{"value", W::scalar, {}}};
  const std::vector<FunctionParameter> one_angle = {{"angle", W::angle, {}}};
  std::vector<Function> out;
  const auto keeps = [&](std::string_view name, std::string_view signature, std::string_view meaning,
                         auto call) {
    out.push_back({name, signature, meaning, one_number, false, false, Kind::number, {}, call});
  };
  const auto gives = [&](std::string_view name, std::string_view signature, std::string_view meaning,
                         std::vector<FunctionParameter> parameters, Kind kind,
                         std::optional<Dimension> dimension, auto call) {
    out.push_back({name, signature, meaning, std::move(parameters), false, false, kind, dimension, call});
  };
  gives("length", "length(list)", "how many values a list has, or letters a text",
        {{"list", W::list_or_text, {}}}, Kind::number, none, &length);
  keeps("abs", "abs(value)", "without its sign", &keeping_unit<std::fabs>);
  keeps("min", "min(a, b, …)", "the smallest", &extreme<true>);
  out.back().more = true;
  keeps("max", "max(a, b, …)", "the largest", &extreme<false>);
  out.back().more = true;
  keeps("round", "round(value)", "the nearest whole number, in SI units", &keeping_unit<std::round>);
  keeps("floor", "floor(value)", "the next whole number below, in SI units", &keeping_unit<floor_of>);
  keeps("ceil", "ceil(value)", "the next whole number above, in SI units", &keeping_unit<ceil_of>);
  gives("sqrt", "sqrt(value)", "square root", one_scalar, Kind::number, none,
        &mathematical<std::sqrt, Dimension::none>);
  gives("sin", "sin(angle)", "sine", one_angle, Kind::number, none, &mathematical<std::sin, Dimension::none>);
  gives("cos", "cos(angle)", "cosine", one_angle, Kind::number, none,
        &mathematical<std::cos, Dimension::none>);
  gives("tan", "tan(angle)", "tangent", one_angle, Kind::number, none,
        &mathematical<std::tan, Dimension::none>);
  gives("asin", "asin(value)", "the angle with this sine", one_scalar, Kind::number, angle,
        &mathematical<std::asin, Dimension::angle>);
  gives("acos", "acos(value)", "the angle with this cosine", one_scalar, Kind::number, angle,
        &mathematical<std::acos, Dimension::angle>);
  gives("atan", "atan(value)", "the angle with this tangent", one_scalar, Kind::number, angle,
        &mathematical<std::atan, Dimension::angle>);
  gives("atan2", "atan2(y, x)", "the angle of the point x, y", {{"y", W::number, {}}, {"x", W::number, {}}},
        Kind::number, angle, &atan2_of);
  gives("pose", "pose(x, y, z, rx, ry, rz)",
        "a pose from lengths and roll, pitch, yaw; what is left out is 0", shifts(), Kind::pose, {}, &pose);
  gives("quat", "quat(qx, qy, qz, qw, x, y, z)", "a pose from a quaternion and lengths",
        {{"qx", W::scalar, {}},
         {"qy", W::scalar, {}},
         {"qz", W::scalar, {}},
         {"qw", W::scalar, {}},
         {"x", W::length, 0.0},
         {"y", W::length, 0.0},
         {"z", W::length, 0.0}},
        Kind::pose, {}, &quat);
  out.push_back({"joints",
                 "joints(a, b, …) or joints(NAME = a, …)",
                 "a joint state, in the order of the robot or by joint names; a length for a joint that slides",
                 {{"value", W::joint, {}}},
                 true,
                 true,
                 Kind::joints,
                 {},
                 &joints});
  gives("offset", "offset(p, x, y, z, rx, ry, rz)",
        "a pose shifted along the axes of its frame, and turned about them at its own place",
        shifts({{"p", W::pose, {}}}), Kind::pose, {}, &offset);
  gives("tool_offset", "tool_offset(p, x, y, z, rx, ry, rz)", "a pose shifted and turned in its own axes",
        shifts({{"p", W::pose, {}}}), Kind::pose, {}, &tool_offset);
  out.push_back({"with",
                 "p with NAME = value, with(p, NAME = value, …)",
                 "a copy of a pose, a joint state or a record with another value of a field",
                 {{"p", W::any, {}}, {"value", W::any, {}}},
                 true,
                 true,
                 {},
                 {},
                 &with});
  gives("inverse", "inverse(p)", "the pose that p undoes: inverse(p) * p is not a shift",
        {{"p", W::pose, {}}}, Kind::pose, {}, &inverse_of);
  gives("distance", "distance(a, b)", "the length between two poses",
        {{"a", W::pose, {}}, {"b", W::pose, {}}}, Kind::number, Dimension::length, &distance);
  out.back().one_frame = true;
  gives("interpolate", "interpolate(a, b, share)", "what lies between two poses or joint states, 50% halfway",
        {{"a", W::place, {}}, {"b", W::place, {}}, {"share", W::scalar, {}}}, Kind::pose, {}, &interpolate);
  out.back().one_frame = true;
  gives("pallet", "pallet(a, b, c, rows, cols, layers, height)",
        "a list of poses: from a to b the columns, from a to c the rows, upwards the layers",
        {{"a", W::pose, {}},
         {"b", W::pose, {}},
         {"c", W::pose, {}},
         {"rows", W::scalar, {}},
         {"cols", W::scalar, {}},
         {"layers", W::scalar, 1.0},
         {"height", W::length, 0.0}},
        Kind::list, {}, &pallet);
  out.back().series = &places_of_pallet;
  out.back().one_frame = true;
  gives("here", "here()",
        "where the tool centre point is; waits until the robot has arrived. In the condition of "
        "an `until` it is where the tool is now",
        {}, Kind::pose, {}, &here);
  out.push_back({"ask",
                 "ask(question, like)",
                 "what a person answers: a text, or where `like` says so a number in its unit, or yes or no; "
                 "an empty answer is `like` itself",
                 {{"question", W::text, {}}, {"like", W::any, 0.0}},
                 false,
                 false,
                 {},
                 {},
                 &ask});
  add_running_functions(out);
  add_text_functions(out);
  const auto of_tests = [&](std::string_view name, std::string_view signature, std::string_view meaning,
                            std::vector<FunctionParameter> parameters, std::optional<Kind> gives_kind) {
    out.push_back(
        {name, signature, meaning, std::move(parameters), false, false, gives_kind, {}, nullptr, true});
  };
  of_tests("fault", "fault(interface, value)",
           "in a test: from now on this interface of the hardware has this value, whatever happens; on and "
           "off are 1 and 0",
           {{"interface", W::text, {}}, {"value", W::any, {}}}, Kind::boolean);
  of_tests("heal", "heal(interface)", "in a test: the fault of this interface is over",
           {{"interface", W::text, {}}}, Kind::boolean);
  of_tests("person", "person(words)",
           "in a test: what a person types while the cell runs: hold, resume, back, discard, recover, stop, "
           "override 50%, or the answer to a question",
           {{"words", W::text, {}}}, Kind::boolean);
  of_tests("part", "part(name)", "in a test: where a part of the scene is now", {{"name", W::text, {}}},
           Kind::pose);
  return out;
}

/// Zero is zero in any unit.
bool is_bare_zero(const Number& n) {
  return n.dimension == Dimension::none && n.value == 0;
}

bool fits(Wanted wanted, const Value& value) {
  const Number* n = value.as_number();
  switch (wanted) {
    case Wanted::any:
      return true;
    case Wanted::number:
      return n != nullptr;
    case Wanted::length:
      return n && (n->dimension == Dimension::length || is_bare_zero(*n));
    case Wanted::angle:
      return n && (n->dimension == Dimension::angle || is_bare_zero(*n));
    case Wanted::joint:
      return n && (n->dimension == Dimension::angle || n->dimension == Dimension::length || is_bare_zero(*n));
    case Wanted::scalar:
      return n && n->dimension == Dimension::none;
    case Wanted::text:
      return value.as_text() != nullptr;
    case Wanted::list:
      return value.as_list() != nullptr;
    case Wanted::list_or_text:
      return value.as_list() || value.as_text();
    case Wanted::pose:
      return value.as_point() != nullptr;
    case Wanted::place:
      return value.is_place();
    case Wanted::joints:
      return value.as_joints() || (n && is_bare_zero(*n));  // 0: left out
  }
  return true;
}

std::string counted(std::size_t n) {
  return std::to_string(n) + (n == 1 ? " value" : " values");
}
}  // namespace

const char* name(Wanted wanted) {
  static constexpr const char* kNames[] = {
      "a value", "a number", "a length",         "an angle", "a number without unit",
      "a text",  "a list",   "a list or a text", "a pose",   "a pose or a joint state",
      "a joint state", "an angle or a length"};
  return kNames[static_cast<int>(wanted)];
}

const std::vector<Function>& functions() {
  static const std::vector<Function> all = all_functions();
  return all;
}

const Function* find_function(std::string_view name) {
  const auto at = std::find_if(functions().begin(), functions().end(),
                               [&](const Function& f) { return equal_ignoring_case(f.name, name); });
  return at == functions().end() ? nullptr : &*at;
}

std::vector<std::string> function_names() {
  std::vector<std::string> out;
  for (const Function& function : functions()) out.emplace_back(function.name);
  return out;
}

std::optional<Dimension> dimension_of(Wanted wanted) {
  if (wanted == Wanted::length) return Dimension::length;
  if (wanted == Wanted::angle || wanted == Wanted::joint) return Dimension::angle;
  if (wanted == Wanted::scalar) return Dimension::none;
  return std::nullopt;
}

void require(const Function& function, std::size_t place, const Value& value) {
  const FunctionParameter& parameter = function.parameters[std::min(place, function.parameters.size() - 1)];
  if (fits(parameter.wanted, value)) return;
  std::string advice;
  const Number* n = value.as_number();
  if (const auto wanted = dimension_of(parameter.wanted); n && wanted)
    advice = unit_advice(*wanted, n->dimension == Dimension::none ? std::optional(n->value) : std::nullopt);
  if (parameter.wanted == Wanted::pose && value.as_joints())
    advice =
        "where a joint state puts the tool depends on the robot; teach the point as a pose, or go there and "
        "take here()";
  throw OperationError{"bad-type",
                       "'" + std::string(parameter.name) + "' of " + std::string(function.name) + "() is " +
                           name(parameter.wanted) + ", here is " + described(value),
                       advice};
}

Signature signature_of(const Function& function) {
  Signature out{std::string(function.name), {}, {}, function.more, function.named};
  for (const FunctionParameter& parameter : function.parameters) {
    out.parameters.emplace_back(parameter.name);
    out.optional.push_back(parameter.otherwise.has_value());
  }
  return out;
}

Signature signature_of(const Statement& function) {
  Signature out;
  out.name = function.name;
  for (const Parameter& parameter : function.parameters) {
    out.parameters.push_back(parameter.name);
    out.optional.push_back(parameter.value != nullptr);
  }
  return out;
}

Bound bind_arguments(const Signature& signature, std::span<const std::string> argument_names) {
  const auto fail = [](std::string what, std::string advice = {}) {
    throw OperationError{"bad-call", std::move(what), std::move(advice)};
  };
  const std::string called = signature.name + "()";
  const std::string takes = signature.parameters.empty()
                                ? called + " takes no values"
                                : called + " takes " + join(signature.parameters, ", ");
  Bound out;
  out.argument_of.assign(signature.parameters.size(), -1);
  std::size_t next = 0;
  bool named_before = false;
  for (std::size_t i = 0; i < argument_names.size(); ++i) {
    const std::string& given = argument_names[i];
    std::size_t place = next;
    if (!given.empty() && !signature.named) {
      named_before = true;
      const auto at = std::find(signature.parameters.begin(), signature.parameters.end(), given);
      if (at == signature.parameters.end())
        fail(called + " has no '" + given + "'" + did_you_mean(given, signature.parameters), takes);
      place = static_cast<std::size_t>(at - signature.parameters.begin());
    } else if (named_before) {
      fail("a value without a name follows one with a name", "name it, too; " + takes);
    } else {
      ++next;
    }
    if (place >= signature.parameters.size() && signature.more) {
      out.further.push_back(static_cast<int>(i));
      continue;
    }
    if (place >= signature.parameters.size())
      fail(called + " takes " + counted(signature.parameters.size()) + ", here are " +
               std::to_string(argument_names.size()),
           takes);
    if (out.argument_of[place] >= 0)
      fail("'" + signature.parameters[place] + "' of " + called + " is given twice", takes);
    out.argument_of[place] = static_cast<int>(i);
  }
  for (std::size_t i = 0; i < signature.parameters.size(); ++i)
    if (out.argument_of[i] < 0 && !signature.optional[i])
      fail("'" + signature.parameters[i] + "' of " + called + " is missing", takes);
  return out;
}

}  // namespace polyarm::program
