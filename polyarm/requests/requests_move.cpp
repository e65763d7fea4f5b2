/// The request that moves a robot to points, one after the other, and reports its progress.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/operation/point_edits.hpp"
#include "polyarm/protocol/jog.hpp"
#include "polyarm/requests/families.hpp"
#include "polyarm/tasks/program_host.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// The parts of the cell that moves to points need.
struct MoveOwners {
  const CellSetup& setup;
  Machine& machine;
  const CellData& data;
  Motions& motions;
  const Programs& programs;
  const Jogging& jogging;
  const Arming& arming;
};
using Json = nlohmann::json;

constexpr Nanoseconds kTellMoveEvery = 100'000'000;
/// A jog that has just ended releases the robot within this time.
constexpr Nanoseconds kJogPatience = 2'000'000'000;
constexpr std::size_t kMostPoints = 1000;
constexpr double kLongestWay = 1e6;  // s, for the whole path and per rad of it

double quantity(const Json& value, const std::string& of, Dimension dimension) {
  if (value.is_number() && std::isfinite(value.get<double>())) return value.get<double>();
  if (value.is_string())
    if (const auto number = parse_quantity(value.get<std::string>(), dimension)) return *number;
  throw Error("bad-argument",
              of + " is " + (value.is_string() ? value.get<std::string>() : value.dump()) + ", not " +
                  name(dimension),
              "bare numbers are m, rad and s");
}

std::vector<double> numbers(const Json& list, const std::string& of, std::initializer_list<Dimension> as) {
  if (!list.is_array() || list.size() != as.size())
    throw Error("bad-argument", fmt::format("{} is not a list of {} numbers", of, as.size()));
  std::vector<double> out;
  for (const Dimension dimension : as) out.push_back(quantity(list[out.size()], of, dimension));
  return out;
}

Pose pose_of(const Json& map, const std::string& of) {
  constexpr auto m = Dimension::length;
  constexpr auto rad = Dimension::angle;
  constexpr auto one = Dimension::none;
  const bool rpy = map.is_object() && map.contains("rpy");
  if (!map.is_object() || !map.contains("position") || rpy == map.contains("orientation") || map.size() != 2)
    throw Error("bad-argument", of + " is not a pose",
                "{position: [x, y, z], rpy: [roll, pitch, yaw]} or with orientation: [x, y, z, w]");
  const std::vector<double> p = numbers(map["position"], "the position of " + of, {m, m, m});
  if (rpy) {
    const std::vector<double> r = numbers(map["rpy"], "the rotation of " + of, {rad, rad, rad});
    return {{p[0], p[1], p[2]}, from_rpy(r[0], r[1], r[2])};
  }
  const std::vector<double> q = numbers(map["orientation"], "the quaternion of " + of, {one, one, one, one});
  if (!(std::abs(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])) - 1) < 1e-3))
    throw Error("bad-argument", "the quaternion of " + of + " has not the length 1",
                "x, y, z, w; no rotation is 0, 0, 0, 1");
  return {{p[0], p[1], p[2]}, normalized(Quaternion{q[0], q[1], q[2], q[3]})};
}

data::JointState joints_of(const Json& map, const CellRobot& robot, const std::string& of) {
  if (!map.is_object()) throw Error("bad-argument", of + " is not a map of joints", "{elbow_joint: 1.2, …}");
  const std::vector<std::string> known = robot.model.joint_names();
  data::JointState out;
  for (const auto& [joint, value] : map.items()) {
    const auto at = std::find(known.begin(), known.end(), joint);
    const bool slides =
        at != known.end() && robot.facts->chain.slides(static_cast<std::size_t>(at - known.begin()));
    out.names.push_back(joint);
    out.positions.push_back(
        quantity(value, joint + " of " + of, slides ? Dimension::length : Dimension::angle));
  }
  return out;
}

/// The target given by a value of the data, a joint state or a pose.
moves::MoveTarget target_of(const MoveOwners& cell, const CellRobot& robot, const Json& point,
                            const std::string& what) {
  if (point.contains("joints"))
    return {joints_by_name(robot.model, joints_of(point["joints"], robot, what), what), what};
  if (point.contains("pose")) {
    const std::string frame = point.value("frame", "");
    return {frame_in_world(cell.setup, cell.data.store, frame, &robot, &cell.motions) *
                pose_of(point["pose"], what),
            what};
  }
  const std::string name = point.value("point", "");
  const data::Value* value = cell.data.store.find(name);
  if (!value)
    throw Error("unknown-point",
                "there is no point '" + name + "'" + did_you_mean(name, cell.data.store.names()),
                "name a point of the cell's data, or give {joints: …} or {pose: …}");
  if (const data::JointState* joints = value->as_joints())
    return {joints_by_name(robot.model, *joints, name), name};
  if (const data::Point* place = value->as_point())
    return {point_in_world(cell.setup, cell.data.store, *place, &robot, &cell.motions), name};
  throw Error("not-a-point", "'" + name + "' is " + data::name(value->kind()) + ", not a point");
}

void check_keys(const Json& point, const std::string& what) {
  const std::vector<std::string> known = {"joints", "pose", "point", "frame", "name", "duration"};
  int places = 0;
  for (const auto& [key, value] : point.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw Error("bad-argument", what + " has no '" + key + "'" + did_you_mean(key, known),
                  "it takes " + join(known, ", "));
    if (key == "name" && !value.is_string())
      throw Error("bad-argument", "the name of " + what + " is not a text");
    if (key == "point" && !value.is_string())
      throw Error("bad-argument", "the point of " + what + " is not a name");
    if (key == "frame" && !(value.is_string() && point.contains("pose")))
      throw Error("bad-argument",
                  "the frame of " + what + (value.is_string() ? " has no pose" : " is not a name"),
                  "a frame belongs to a pose: {pose: …, frame: pallet}");
    places += key == "joints" || key == "pose" || key == "point" ? 1 : 0;
  }
  if (places != 1) throw Error("bad-argument", what + " needs one of joints, pose and point");
}

/// Joins lines through several points into one curve of the TCP.
std::vector<moves::Move> one_curve(std::vector<moves::Move> lines) {
  moves::Move curve = lines.front();
  curve.kind = moves::MoveKind::spline;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    curve.targets.push_back(lines[i].targets.front());
    curve.duration += lines[i].duration;
  }
  return {curve};
}

std::vector<moves::Move> read_move(const MoveOwners& cell, const CellRobot& robot, const MoveTo& request) {
  const bool line = request.kind == MoveKind::line;
  const double pace = request.pace.value_or(0), share = request.speed.value_or(1);
  if (!(pace >= 0 && pace <= kLongestWay))
    throw Error("bad-argument", "'pace' is " + format_number(pace), "s for each rad, at least 0");
  if (!(share > 0 && share <= 1))
    throw Error("bad-argument", "'speed' is " + format_number(share), "a share of the limits: 0.01 to 1");
  const Json& given = request.points.json();
  const Json points = given.is_array() ? given : Json::array({given});
  if (points.empty() || points.size() > kMostPoints)
    throw Error("bad-argument", fmt::format("'points' has {} points", points.size()),
                fmt::format("1 to {}", kMostPoints));
  std::vector<moves::Move> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Json point = points[i].is_string() ? Json{{"point", points[i]}} : points[i];
    const std::string number = fmt::format("point {}", i + 1);
    if (!point.is_object()) throw Error("bad-argument", number + " is neither a name nor a map");
    check_keys(point, number);
    moves::Move move;
    move.kind = line ? moves::MoveKind::line : moves::MoveKind::joint;
    move.targets = {target_of(cell, robot, point, point.value("name", number))};
    move.speed = share * (move.kind == moves::MoveKind::joint ? cell.setup.file.motion.speed : 1);
    if (move.kind == moves::MoveKind::joint) move.joint_pace = pace;
    if (point.contains("duration"))
      move.duration = quantity(point["duration"], "the duration of " + number, Dimension::time);
    if (!(move.duration >= 0 && move.duration <= kLongestWay))
      throw Error("bad-argument", fmt::format("the duration of {} is {} s", number, move.duration),
                  fmt::format("a time above 0, at most {} s", kLongestWay));
    move.through = !request.rests && i + 1 < points.size();
    out.push_back(std::move(move));
  }
  return line && !request.rests && out.size() > 1 ? one_curve(std::move(out)) : out;
}

void require_may_move(const MoveOwners& cell, std::size_t i) {
  const std::string& robot = cell.setup.robots[i]->entry.name;
  if (!cell.arming.armed())
    throw Error("disarmed", "'" + robot + "' is not moved: the real hardware is not armed",
                "polyarm control arm");
  if (!cell.motions.motion(i))
    throw Error("no-motion", "no trajectory controller moves all joints of '" + robot + "'",
                "leave 'controllers' out of the cell, or name a joint_trajectory_controller for them");
  const control::RunState state = cell.machine.snapshot().state;
  if (state == control::RunState::fault)
    throw Error("fault", "'" + robot + "' is not moved: the cell is in a fault",
                "polyarm control recover, resume");
  if (state == control::RunState::stopping || state == control::RunState::backing)
    throw Error("stopping", "'" + robot + "' is not moved: the cell is " + control::name(state),
                "try again when it is at rest");
  if (state != control::RunState::running)
    throw Error("held", "'" + robot + "' is not moved: the cell is " + control::name(state),
                "continue: polyarm control resume; or discard the motion: polyarm control discard");
  if (cell.programs.runs())
    throw Error("program-runs", "'" + robot + "' is not moved: the program is running and has control",
                "pause it: program.pause");
  if (!cell.motions.idle(i))
    throw Error("moving", "'" + robot + "' is moving already", "wait until it has arrived");
}

/// Tracks the moves of one client; if the client disconnects, the robot stops on its path.
class UnderWay {
 public:
  explicit UnderWay(const MoveOwners& cell) : cell_(cell) {}
  UnderWay(const UnderWay&) = delete;
  UnderWay& operator=(const UnderWay&) = delete;
  ~UnderWay() {
    if (first != 0 && !over) cell_.machine.supervisor().latch().request(realtime::StopKind::controlled);
  }
  std::uint64_t first = 0, last = 0;
  bool over = false;

 private:
  MoveOwners cell_;
};

MoveTo::Answer progress_of(const MoveOwners& cell, std::size_t i, const UnderWay& moves, Nanoseconds begun) {
  const moves::Travel way = cell.motions.motion(i)->travel(moves.first, moves.last);
  MoveTo::Answer out;
  out.robot = cell.setup.robots[i]->entry.name;
  out.cell = control::name(cell.machine.snapshot().state);
  out.cause = control::name(cell.machine.snapshot().cause);
  out.elapsed_s = seconds(cell.machine.now() - begun);
  if (!std::isfinite(way.remaining)) return out;
  out.left_s = way.remaining;
  out.left_m = way.left;
  return out;
}

/// Throws for the first move that did not end well. A failed move explains more than moves that were
/// discarded because of it.
void throw_bad_end(const moves::RobotMotion& motion, UnderWay& moves) {
  std::optional<moves::MoveState> worst;
  for (std::uint64_t id = moves.first; id <= moves.last; ++id) {
    const moves::MoveState state = motion.state_of(id);
    if (state == moves::MoveState::failed || state == moves::MoveState::refused) {
      moves.over = true;
      throw Error(motion.problem_of(id).value_or(
          Problem{"refused", {}, "the controller refused the move: it would have begun with a jump", {}}));
    }
    if (state == moves::MoveState::discarded) worst = state;
  }
  if (!worst) return;
  moves.over = true;
  throw Error("discarded", "the rest of the motion was discarded", "the robot stays where it was stopped");
}

Poll<MoveTo::Answer> follow_moves(const MoveOwners& cell, std::size_t i, std::vector<moves::Move> asked) {
  using Moved = Progress<MoveTo::Answer>;
  return [cell, i, asked = std::move(asked), moves = std::shared_ptr<UnderWay>(), stood = false,
          requested_at = Nanoseconds{-1}, begun = Nanoseconds{0}, reported = Nanoseconds{0}]() mutable {
    if (requested_at < 0) requested_at = cell.machine.now();
    if (!moves) {  // a robot that was jogged is released first; moves begin where it is
      const bool free = !cell.jogging.engaged(i) && cell.machine.snapshot().standing;
      if (!free && cell.machine.now() - requested_at > kJogPatience)
        throw Error("jogged",
                    "'" + cell.setup.robots[i]->entry.name + "' is moved by hand or by another client now",
                    "wait until that has ended");
      if (!free || !std::exchange(stood, true)) return Moved{};
      require_may_move(cell, i);
      moves = std::make_shared<UnderWay>(cell);
      for (moves::Move& move : asked) {
        moves->last = cell.motions.motion(i)->queue(std::move(move));
        if (moves->first == 0) moves->first = moves->last;
      }
      cell.motions.motion(i)->close();
      begun = reported = cell.machine.now();
      return Moved{};
    }
    if (!cell.motions.motion(i)) {
      moves->over = true;
      throw Error("discarded", "the controller that moved it was unloaded");
    }
    throw_bad_end(*cell.motions.motion(i), *moves);
    MoveTo::Answer out = progress_of(cell, i, *moves, begun);
    if (cell.motions.motion(i)->state_of(moves->last) == moves::MoveState::done &&
        cell.machine.snapshot().standing) {
      moves->over = true;
      out.done = true;
      return Moved::done(std::move(out));
    }
    if (cell.machine.now() - reported < kTellMoveEvery) return Moved{};
    reported = cell.machine.now();
    return Moved::more(std::move(out));
  };
}

Poll<MoveTo::Answer> move(const MoveOwners& cell, const MoveTo& request) {
  const std::size_t i = robot_named(cell.setup, request.robot);
  require_may_move(cell, i);
  return follow_moves(cell, i, read_move(cell, *cell.setup.robots[i], request));
}

}  // namespace

std::vector<Handler> move_handlers() {
  return handlers<move>();
}

}  // namespace polyarm::cell
