#include "polyarm/ros_files/trajectory_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/message_parts.hpp"
#include "polyarm/trajectory/splines.hpp"

namespace polyarm::ros_files {

using controllers::TrajectoryMessage;
using trajectory::TrajectoryPoint;

namespace {

[[noreturn]] void refuse(const Yaml& at, std::string what, std::string advice = {}) {
  throw Error(Problem{"bad-message", at.where(), std::move(what), std::move(advice)});
}

/// The four lists of a point with their names in messages.
struct Field {
  const char* name;
  const char* other;  // name in variants of FollowJointTrajectory
  std::vector<double> TrajectoryPoint::*values;
};
constexpr std::array<Field, 4> kFields = {
    {{"positions", "positions", &TrajectoryPoint::positions},
     {"velocities", "velocities", &TrajectoryPoint::velocities},
     {"accelerations", "accelerations", &TrajectoryPoint::accelerations},
     {"effort", "efforts", &TrajectoryPoint::effort}}};

std::string joint_name(const std::vector<std::string>& joints, std::size_t j) {
  return j < joints.size() ? joints[j] : "value " + std::to_string(j + 1);
}

/// The values of one list of point `index`; errors name point and joint.
std::vector<double> values_of(const Yaml& yaml, const char* field, std::size_t index,
                              const std::vector<std::string>& joints) {
  std::vector<double> out;
  for (const Yaml& item : yaml.items()) {
    if (item.is_scalar()) {
      if (const auto value = parse_quantity(item.text(), Dimension::none)) {
        out.push_back(*value);
        continue;
      }
    }
    const std::string found = item.is_scalar() ? "'" + item.text() + "' is" : "this is";
    Location where = item.where();
    if (where.line == 0) where = yaml.where();
    throw Error(Problem{"bad-value", where,
                        fmt::format("{} of point {}, {}: {} no number", field, index + 1,
                                    joint_name(joints, out.size()), found),
                        item.is_scalar() && item.text().find("...") != std::string::npos
                            ? "echo cut it short: use ros2 topic echo --full-length"
                            : "write a finite number, in rad or m and seconds"});
  }
  return out;
}

TrajectoryPoint point_of(const Yaml& yaml, std::size_t index, const std::vector<std::string>& joints) {
  if (!yaml.is_map())
    refuse(yaml, fmt::format("point {} is not a point", index + 1),
           "write {positions: [0.1, 0.2], time_from_start: 1.0}");
  check_keys(yaml, {"positions", "velocities", "accelerations", "effort", "efforts", "time_from_start"});
  TrajectoryPoint out;
  for (const Field& f : kFields)
    out.*f.values = values_of(yaml[yaml.has(f.other) ? f.other : f.name], f.name, index, joints);
  if (!yaml.has("time_from_start"))
    refuse(yaml, fmt::format("point {} has no time_from_start", index + 1), "add time_from_start: 1.0");
  out.time_from_start = seconds_of(yaml["time_from_start"]);
  return out;
}

}  // namespace

TrajectoryMessage trajectory_of(const Yaml& yaml) {
  if (!yaml.is_map())
    refuse(yaml, "this is not a trajectory",
           "write {joint_names: [joint_1], points: [{positions: [0.1], time_from_start: 1.0}]}");
  if (yaml.has("trajectory") || yaml.has("goal"))
    refuse(yaml, "this is a goal around a trajectory", "send it as a goal: polyarm send … --goal");
  check_keys(yaml, {"header", "joint_names", "points"});
  TrajectoryMessage out;
  out.start = stamp_of(yaml["header"]);
  out.joints = yaml.required("joint_names").texts();
  if (!yaml.has("points")) refuse(yaml, "the trajectory has no points");
  for (const Yaml& point : yaml["points"].items())
    out.points.push_back(point_of(point, out.points.size(), out.joints));
  return out;
}

namespace {

/// The trajectory inside a goal or a RobotTrajectory.
Yaml inside(Yaml yaml) {
  for (const char* key : {"goal", "trajectory", "joint_trajectory"})
    if (yaml.has(key)) yaml = yaml[key];
  return yaml;
}

void check_sizes(const JointTrajectoryFile& file, Problems& problems) {
  const TrajectoryMessage& m = file.message;
  for (std::size_t i = 0; i < m.points.size(); ++i)
    for (const Field& f : kFields) {
      const std::size_t n = (m.points[i].*f.values).size();
      if (n == 0 || n == m.joints.size()) continue;
      const std::string advice =
          n < m.joints.size() ? "the first that is missing is that of " + m.joints[n] : "one for each joint";
      problems.error("wrong-size", file.where[i],
                     fmt::format("point {} has {} {} for {} joints", i + 1, n, f.name, m.joints.size()),
                     advice);
    }
}

void check_times(const JointTrajectoryFile& file, Problems& problems) {
  const auto& points = file.message.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double t = points[i].time_from_start;
    if (!(t >= 0) || t > 9e9)
      problems.error("bad-time", file.where[i], fmt::format("time_from_start of point {} is {} s", i + 1, t),
                     "times count from the start of the trajectory");
    else if (i > 0 && t <= points[i - 1].time_from_start)
      problems.error("bad-time", file.where[i],
                     fmt::format("point {} is at {} s, not after point {} at {} s", i + 1, t, i,
                                 points[i - 1].time_from_start),
                     "time_from_start must grow from point to point");
  }
}

void check_names(const TrajectoryMessage& m, const Location& where, Problems& problems) {
  for (std::size_t j = 0; j < m.joints.size(); ++j)
    if (std::find(m.joints.begin(), m.joints.begin() + std::ptrdiff_t(j), m.joints[j]) !=
        m.joints.begin() + std::ptrdiff_t(j))
      problems.error("repeated-joint", where, "joint_names has " + m.joints[j] + " twice", "name it once");
}

}  // namespace

JointTrajectoryFile parse_trajectory(std::string_view text, const std::string& name) {
  const Yaml yaml = inside(Yaml::parse(text, name));
  JointTrajectoryFile out;
  out.message = trajectory_of(yaml);
  for (const Yaml& point : yaml["points"].items()) out.where.push_back(point.where());
  Problems problems;
  if (out.message.points.empty())
    problems.error("no-points", yaml.key_location("points"), "the trajectory has no points",
                   "add one: {positions: [0.1], time_from_start: 1.0}");
  check_names(out.message, yaml.key_location("joint_names"), problems);
  check_sizes(out, problems);
  check_times(out, problems);
  problems.throw_if_errors();
  return out;
}

JointTrajectoryFile read_trajectory_file(const std::string& path) {
  return parse_trajectory(read_file(path), path);
}

namespace {

std::string last_word(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

/// The robot's joint with this name; or else the only one where one name ends with "_" and the other name.
std::optional<std::size_t> joint_of(const std::string& name, const std::vector<std::string>& names) {
  std::optional<std::size_t> found;
  for (std::size_t j = 0; j < names.size(); ++j)
    if (last_word(name) == last_word(names[j])) return j;
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (!name.ends_with("_" + names[j]) && !names[j].ends_with("_" + name)) continue;
    if (found) return std::nullopt;
    found = j;
  }
  return found;
}

}  // namespace

void order_joints(JointTrajectoryFile& file, const std::vector<std::string>& names,
                  const std::vector<double>& start, Problems& warnings) {
  constexpr std::size_t kNone = std::size_t(-1);
  TrajectoryMessage& m = file.message;
  std::vector<std::size_t> from(names.size(), kNone);
  Problems problems;
  const Location where{file.where.empty() ? std::string() : file.where.front().file};
  for (std::size_t j = 0; j < m.joints.size(); ++j) {
    const auto to = joint_of(m.joints[j], names);
    if (to && from[*to] == kNone)
      from[*to] = j;
    else
      problems.error("unknown-joint", where,
                     to ? m.joints[j] + " and " + m.joints[from[*to]] + " are the same joint of the robot"
                        : "the robot has no joint '" + m.joints[j] + "'" + did_you_mean(m.joints[j], names),
                     "its joints are " + join(names, ", "));
  }
  problems.throw_if_errors();
  std::vector<std::string> left_out;
  for (std::size_t j = 0; j < names.size(); ++j)
    if (from[j] == kNone) left_out.push_back(names[j]);
  if (!left_out.empty())
    warnings.warning("joint-left-out", where,
                     "the trajectory has no values for these joints: " + join(left_out, ", "),
                     "they stay where they are");
  for (TrajectoryPoint& p : m.points)
    for (const Field& f : kFields) {
      if ((p.*f.values).empty()) continue;
      std::vector<double> ordered(names.size(), 0.0);
      for (std::size_t j = 0; j < names.size(); ++j) {
        if (from[j] != kNone)
          ordered[j] = (p.*f.values)[from[j]];
        else if (f.values == &TrajectoryPoint::positions)
          ordered[j] = start[j];
      }
      p.*f.values = std::move(ordered);
    }
  m.joints = names;
}

namespace {

/// Adds the file location to errors about "point 3", and throws them.
[[noreturn]] void say_where(const Error& e, const JointTrajectoryFile& file) {
  std::vector<Problem> problems = e.problems();
  for (Problem& p : problems) {
    const auto at = p.what.find("point ");
    if (p.where.line > 0 || at == std::string::npos) continue;
    std::size_t index = 0;
    for (std::size_t k = at + 6; k < p.what.size() && p.what[k] >= '0' && p.what[k] <= '9'; ++k)
      index = std::min<std::size_t>(10 * index + std::size_t(p.what[k] - '0'), 1'000'000'000);
    if (index > 0 && index <= file.where.size()) p.where = file.where[index - 1];
  }
  throw Error(std::move(problems));
}

}  // namespace

trajectory::Trajectory as_timed(const JointTrajectoryFile& file, const std::vector<double>& start,
                                const std::vector<bool>& continuous) {
  try {
    TrajectoryPoint from;
    from.positions = start;
    // The first point decides the degree of the first segment, so the start gets the same quantities.
    if (!file.message.points.empty()) {
      const TrajectoryPoint& first = file.message.points.front();
      if (!first.velocities.empty()) from.velocities.assign(start.size(), 0.0);
      if (!first.accelerations.empty()) from.accelerations.assign(start.size(), 0.0);
    }
    trajectory::SplineOptions options;
    options.wraparound = trajectory::Wraparound::points;
    options.allow_nonzero_velocity_at_end = true;
    return trajectory::interpolate(from, file.message.points, continuous, options);
  } catch (const Error& e) {
    say_where(e, file);
  }
}

std::vector<paths::JointWaypoint> as_waypoints(const JointTrajectoryFile& file, double radius) {
  std::vector<paths::JointWaypoint> out;
  for (std::size_t i = 0; i < file.message.points.size(); ++i) {
    const TrajectoryPoint& p = file.message.points[i];
    if (p.positions.empty())
      throw Error(Problem{"no-positions", file.where[i], fmt::format("point {} has no positions", i + 1),
                          "a path needs the positions of every point"});
    out.push_back({p.positions, radius, fmt::format("point {}", i + 1)});
  }
  return out;
}

namespace {

/// Builds points by sampling a timed path.
class PointMaker {
 public:
  PointMaker(const timing::TimedPath& timed, const std::vector<std::string>& joints) : timed_(timed) {
    message_.joints = joints;
  }
  void add(double t) {
    TrajectoryPoint p;
    const std::size_t n = timed_.joints();
    p.positions.resize(n), p.velocities.resize(n), p.accelerations.resize(n);
    timed_.sample(t, p.positions, p.velocities, p.accelerations, {}, hint_);
    p.time_from_start = t;
    message_.points.push_back(std::move(p));
  }
  TrajectoryMessage take() { return std::move(message_); }

 private:
  const timing::TimedPath& timed_;
  TrajectoryMessage message_;
  std::size_t hint_ = 0;
};

}  // namespace

TrajectoryMessage sampled(const timing::TimedPath& timed, double rate,
                          const std::vector<std::string>& joints) {
  if (!(rate > 0) || !std::isfinite(rate) || timed.duration() * rate > 1e7)
    throw Error("bad-value", fmt::format("{} Hz is not a rate to sample {:.3f} s at", rate, timed.duration()),
                "100 Hz will do for most controllers");
  PointMaker points(timed, joints);
  const auto whole = std::size_t(timed.duration() * rate * (1 - 1e-9));
  for (std::size_t i = 0; i <= whole; ++i) points.add(double(i) / rate);
  points.add(timed.duration());
  return points.take();
}

TrajectoryMessage knots_of(const timing::TimedPath& timed, double tolerance,
                           const std::vector<std::string>& joints) {
  if (!(tolerance > 0)) throw Error("bad-value", fmt::format("{} is not a tolerance", tolerance), "1e-6");
  const trajectory::Trajectory pieces = to_trajectory(timed, tolerance);
  PointMaker points(timed, joints);
  points.add(0);
  for (std::size_t i = 0; i < pieces.segments(); ++i) points.add(pieces.end_of(i));
  return points.take();
}

void append(TrajectoryMessage& message, const TrajectoryMessage& next) {
  if (message.points.empty()) {
    message = next;
    return;
  }
  const double begin = message.points.back().time_from_start;
  for (std::size_t i = 1; i < next.points.size(); ++i) {
    message.points.push_back(next.points[i]);
    message.points.back().time_from_start += begin;
  }
}

namespace {

/// The shortest text with a decimal point: without it, YAML 1.1 reads 1e-08 as a text.
std::string number_text(double value) {
  std::string out = fmt::format("{}", value);
  const auto e = out.find('e');
  if (out.find('.') == std::string::npos) out.insert(e == std::string::npos ? out.size() : e, ".0");
  return out;
}

std::string list_text(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double v : values) texts.push_back(number_text(v));
  return "[" + join(texts, ", ") + "]";
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  }
  return out + "\"";
}

struct Words {
  const char *whole, *part;
};
constexpr Words kWords[] = {{"sec", "nanosec"}, {"secs", "nsecs"}};

std::pair<std::int64_t, std::int64_t> split(Nanoseconds time) {
  return {time / 1'000'000'000, time % 1'000'000'000};
}

/// Writes both formats: JSON is YAML with quoted words and with brackets.
class Writer {
 public:
  Writer(bool json, TimeWords words) : json_(json), words_(kWords[std::size_t(words)]) {}

  std::string operator()(const TrajectoryMessage& m) {
    const auto names = [&] {
      std::vector<std::string> out;
      for (const std::string& joint : m.joints) out.push_back(quoted(joint));
      return "[" + join(out, ", ") + "]";
    };
    std::string out = json_ ? "{\n" : "";
    out += fmt::format("{}: {{{}: {}, {}: {}}}", key("header"), key("stamp"), time(m.start.value_or(0)),
                       key("frame_id"), "\"\"");
    out += fmt::format("{}{}: {}", end(), key("joint_names"), names());
    out += fmt::format("{}{}:", end(), key("points"));
    out += json_ || m.points.empty() ? " [" : "";
    for (std::size_t i = 0; i < m.points.size(); ++i) out += point(m.points[i], i > 0);
    if (json_ || m.points.empty()) out += "]";
    return out + (json_ ? "}\n" : "\n");
  }

 private:
  std::string key(const char* word) const { return json_ ? quoted(word) : word; }
  const char* end() const { return json_ ? ",\n" : "\n"; }
  std::string time(Nanoseconds t) const {
    const auto [whole, part] = split(t);
    return fmt::format("{{{}: {}, {}: {}}}", key(words_.whole), whole, key(words_.part), part);
  }
  std::string point(const TrajectoryPoint& p, bool later) const {
    std::string out = json_ ? (later ? ",\n {" : "\n {") : "\n- ";
    const char* between = "";
    const char* next = json_ ? ",\n  " : "\n  ";
    for (const Field& f : kFields) {
      out += fmt::format("{}{}: {}", between, key(f.name), list_text(p.*f.values));
      between = next;
    }
    out += fmt::format("{}{}: {}", next, key("time_from_start"), time(nanoseconds(p.time_from_start)));
    return out + (json_ ? "}" : "");
  }

  bool json_;
  Words words_;
};

}  // namespace

std::string to_yaml(const TrajectoryMessage& message, TimeWords words) {
  return Writer(false, words)(message);
}
std::string to_json(const TrajectoryMessage& message, TimeWords words) {
  return Writer(true, words)(message);
}

}  // namespace polyarm::ros_files
