#include "polyarm/tasks/program_moves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/data/point_frames.hpp"
#include "polyarm/moves/forward_plan.hpp"
#include "polyarm/setup/relative_moves.hpp"
#include "polyarm/tasks/program_host.hpp"

namespace polyarm::cell {

namespace {
/// The share of speed and acceleration of moves on a belt.
constexpr double kShareOnBelts = 0.7;
}  // namespace

ProgramMoves::ProgramMoves(std::string task, std::vector<Robot> robots, const MotionEntry& pace,
                           const data::DataStore& store)
    : task_(std::move(task)), pace_(pace), store_(store) {
  for (const Robot& robot : robots) arms_.push_back({robot, {}, {}});
}

std::size_t ProgramMoves::robot_of(const std::string& robot, const Location& where) const {
  if (arms_.empty())
    throw Error(
        Problem{"no-robot", where, "'" + task_ + "' moves no robot", "only the robot program can move"});
  std::vector<std::string> names;
  std::size_t found = arms_.size();
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    names.push_back(arms_[i].robot.robot->entry.name);
    if (names.back() == robot || (robot.empty() && arms_.size() == 1)) found = i;
  }
  if (found == arms_.size())
    throw Error(Problem{"unknown-robot", where,
                        robot.empty() ? "the cell has several robots, and the move does not name one"
                                      : "the cell has no robot '" + robot + "'" + did_you_mean(robot, names),
                        "write `use robot " + names.front() + "`, or a robot clause: " + join(names, ", ")});
  return found;
}

/// The index of a robot whose joints a controller moves.
std::size_t ProgramMoves::arm_of(const std::string& robot, const Location& where) const {
  const std::size_t found = robot_of(robot, where);
  if (!arms_[found].robot.motion)
    throw Error(
        Problem{"no-motion", where,
                "no trajectory controller moves all joints of '" + arms_[found].robot.robot->entry.name + "'",
                "leave 'controllers' out of the cell, or name a joint_trajectory_controller for them"});
  return found;
}

data::FrameChain ProgramMoves::chain_of(const std::string& frame) const {
  return data::frame_chain(frame, [this](const std::string& name) -> const data::Point* {
    if (belts_ && belts_->has(name)) return nullptr;
    const data::Value* value = store_.find(name);
    return value ? value->as_point() : nullptr;
  });
}

/// T_world_frame of a frame on a robot; empty: there is no such robot.
std::optional<Pose> ProgramMoves::on_robot(const data::RobotFrame& frame, const Arm* own) const {
  using Part = data::RobotFrame::Part;
  if (frame.robot.empty()) return own ? std::optional(own->robot.robot->entry.base) : std::nullopt;
  for (const Arm& arm : arms_) {
    const CellRobot& robot = *arm.robot.robot;
    if (robot.entry.name != frame.robot) continue;
    if (frame.part == Part::base) return robot.entry.base;
    if (!arm.robot.motion) return std::nullopt;
    const auto index = static_cast<std::size_t>(&arm - arms_.data());
    if (busy_ ? busy_(index) : !arm.robot.motion->idle())
      throw Error("frame-moves",
                  "the frame '" + frame.robot + (frame.part == Part::tcp ? "/tcp" : "/flange") +
                      "' is under way: '" + robot.entry.name + "' has moves to do",
                  "let it arrive first: moveto, or `wait 0s` behind the move");
    const Pose tcp = arm.robot.motion->robot().chain.forward(arm.robot.motion->planned());
    return frame.part == Part::tcp ? tcp : tcp * inverse(robot.tool.tcp);
  }
  return std::nullopt;
}

Pose ProgramMoves::frame_named(const std::string& name, const Arm& arm, const Location& where) const {
  const data::FrameChain chain = chain_of(name);
  if (chain.root.empty()) return chain.pose;
  if (belts_ && belts_->has(chain.root)) return belt_frame(chain.root, arm, where) * chain.pose;
  if (const auto part = data::robot_frame(chain.root))
    if (const auto on = on_robot(*part, &arm)) return *on * chain.pose;
  throw Error(Problem{"unknown-frame", where,
                      "there is no frame '" + chain.root + "'" + did_you_mean(chain.root, store_.names()),
                      data::kFramesAre});
}

/// A point stays in a frame that each robot has for itself.
data::Point ProgramMoves::in_world(const data::Point& point) const {
  if (point.frame().empty()) return point;
  const data::FrameChain chain = chain_of(point.frame());
  if (belts_ && belts_->has(chain.root)) return point;
  const bool each_has_it = chain.root == "base" && arms_.size() > 1;
  if (each_has_it || (arms_.empty() && !chain.root.empty())) return point;
  const Pose frame = arms_.empty() ? chain.pose : frame_named(point.frame(), arms_.front(), {});
  data::Point out = data::converted(point, "world", normalized(frame.rotation * data::axes_of(point)));
  out.pose = frame * point.pose;
  return out;
}

Pose ProgramMoves::frame_of(const program::Move& move, const Arm& arm, const Location& where) const {
  const Pose named = frame_named(move.named_frame(), arm, where);
  return move.frame_pose ? named * *move.frame_pose : named;
}

/// T_tool0_tcp.
Pose ProgramMoves::tcp_of_tool(const std::string& name, const Arm& arm, const Location& where) const {
  const description::Tool& own = arm.robot.robot->tool;
  if (name.empty() || name == own.name) return own.tcp;
  if (const data::Value* value = store_.find(name))
    if (const data::Point* point = value->as_point()) return point->pose;
  if (name == "tool0" || name == "none") return {};
  throw Error(
      Problem{"unknown-tool", where, "there is no tool '" + name + "'" + did_you_mean(name, store_.names()),
              "a tool is a point of the data (the pose of its TCP in tool0), '" + own.name + "' or 'tool0'"});
}

std::shared_ptr<const moves::RobotFacts> ProgramMoves::tool_of(const std::string& name, Arm& arm,
                                                               const Location& where) {
  const Pose tcp = tcp_of_tool(name, arm, where);
  if (tcp == arm.robot.robot->tool.tcp) return nullptr;
  MadeTool& made = arm.tools[name];
  if (!made.facts || made.tcp != tcp) {
    const description::RobotModel& model = arm.robot.robot->model;
    made = {tcp,
            moves::with_chain(arm.robot.motion->robot(),
                              kinematics::Chain(model, model.tool_link(), arm.robot.robot->entry.base, tcp))};
  }
  return made.facts;
}

moves::MoveTarget ProgramMoves::target_of(const program::Move::Target& target, const program::Move& move,
                                          const Arm& arm, const Location& where) const {
  if (const data::JointState* joints = target.value.as_joints())
    return {joints_by_name(arm.robot.robot->model, *joints, target.name), target.name};
  if (const data::Point* point = target.value.as_point()) {
    // A point that names a frame is in that frame, whatever the frame of the move.
    const Pose own =
        point->frame().empty() ? frame_of(move, arm, where) : frame_named(point->frame(), arm, where);
    return {own * point->pose, target.name};
  }
  throw Error(Problem{"not-a-point",
                      where,
                      "'" + target.name + "' is " + data::name(target.value.kind()) + ", not a point",
                      {}});
}

void ProgramMoves::pace(const program::Move& from, moves::Move& to) const {
  to.speed = pace_.speed;
  if (from.speed) {
    const double value = from.speed->value;
    switch (from.speed->dimension) {
      case Dimension::speed:
        to.tcp_speed = value;
        break;
      case Dimension::angular_speed:
        (to.kind == moves::MoveKind::joint ? to.joint_speed : to.turn_speed) = value;
        break;
      default:
        to.speed = value;
    }
  }
  if (from.accel) {
    const double value = from.accel->value;
    switch (from.accel->dimension) {
      case Dimension::acceleration:
        to.tcp_acceleration = value;
        break;
      case Dimension::angular_acceleration:
        (to.kind == moves::MoveKind::joint ? to.joint_acceleration : to.turn_acceleration) = value;
        break;
      default:
        to.acceleration = value;
    }
  }
  if (from.duration) to.duration = from.duration->value;
  if (!from.duration && from.exact) to.duration = pace_.seconds.value_or(0);
  if (from.waits && !from.duration && !from.speed) to.joint_pace = pace_.thesis_scale.value_or(0);
}

std::vector<moves::Move> ProgramMoves::moves_of(const program::Move& move, const Arm& arm,
                                                const Location& where) const {
  moves::Move made;
  made.kind = move.kind == program::Move::Kind::joint  ? moves::MoveKind::joint
              : move.kind == program::Move::Kind::line ? moves::MoveKind::line
                                                       : moves::MoveKind::arc;
  pace(move, made);
  made.around = !move.touch && move.around.value_or(pace_.around);
  const bool curve = move.smooth && move.targets.size() > 1;
  if (curve) made.kind = moves::MoveKind::spline;
  const double blend = move.blend ? move.blend->value : 0;
  std::vector<moves::Move> out;
  for (std::size_t i = 0; i < move.targets.size(); ++i) {
    const bool last = i + 1 == move.targets.size();
    made.targets.push_back(target_of(move.targets[i], move, arm, where));
    if ((made.kind == moves::MoveKind::arc || curve) && !last) continue;
    made.blend = last && move.exact ? 0 : blend;
    out.push_back(made);
    made.targets.clear();
  }
  if (move.duration && out.size() > 1)
    throw Error(Problem{"bad-move", where,
                        "a duration applies to one move, here are " + std::to_string(out.size()),
                        "write one move for each point, or state a speed"});
  return out;
}

namespace {
/// A point taught with this robot is reached in the taught arm configuration, with any tool and for the
/// present pose of its frame; if that is impossible, in the nearest one.
void keep_as_taught(const program::Move& move, const CellRobot& own, const moves::RobotFacts& robot,
                    std::vector<moves::Move>& moves) {
  if (move.kind != program::Move::Kind::joint || moves.size() != move.targets.size()) return;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const data::Point* point = move.targets[i].value.as_point();
    const data::Taught* taught = point ? point->taught.get() : nullptr;
    if (!taught || taught->joints.positions.empty() || taught->robot != own.entry.model) continue;
    moves::MoveTarget& target = moves[i].targets.back();
    const Pose* pose = std::get_if<Pose>(&target.at);
    try {
      if (pose)
        target.at = moves::joints_for(robot, *pose, joints_by_name(own.model, taught->joints, target.name),
                                      target.name);
    } catch (const Error&) {
    }
  }
}
}  // namespace

ProgramMoves::Prepared ProgramMoves::prepare(const program::Move& move, const Location& where) {
  const std::size_t index = arm_of(move.robot, where);
  Arm& arm = arms_[index];
  auto facts = tool_of(move.tool, arm, where);
  std::vector<moves::Move> moves = moves_of(move, arm, where);
  if (!belt_of(move, where).empty())  // the rest of the limits is for the motion of the belt
    for (moves::Move& one : moves)
      one.speed *= kShareOnBelts, one.acceleration *= kShareOnBelts, one.around = false;
  check_payload(move, arm, where);
  check_forward(move, moves, arm, where);
  const moves::RobotFacts& own = arm.robot.motion ? arm.robot.motion->robot() : *arm.robot.robot->facts;
  if (move.near)
    keep_near(*move.near, facts ? *facts : own, moves);
  else
    keep_as_taught(move, *arm.robot.robot, facts ? *facts : own, moves);
  return {index, std::move(moves), std::move(facts)};
}

/// What a controller that interpolates itself cannot do. The cell's file says whether it does; so `check`
/// finds it, too.
void ProgramMoves::check_forward(const program::Move& move, const std::vector<moves::Move>& moves,
                                 const Arm& arm, const Location& where) const {
  const RobotEntry& entry = arm.robot.robot->entry;
  const auto motion = entry.parameters.find("motion");
  if (motion == entry.parameters.end() || motion->second != "forward") return;
  const auto no = [&](const std::string& what, const char* advice) {
    throw Error(Problem{"forward-mode", where,
                        "'" + entry.name + "' has `motion: forward`, and its controller " + what, advice});
  };
  for (const moves::Move& one : moves)
    if (auto problem = moves::refuse_forward(one, entry.name)) {
      problem->where = where;
      throw Error(std::move(*problem));
    }
  if (move.step.members > 1)
    no("cannot move in step with other robots",
       "write the moves outside of `together`, or set `motion: stream`");
  if (!belt_of(move, where).empty())
    no("follows no belt", "stop the belt and use a point, or set `motion: stream`");
}

program::Handle ProgramMoves::start(const program::Move& asked, const Location& where) {
  if (asked.of_base()) return start_base(asked, where);
  const std::size_t index = arm_of(asked.robot, where);
  Arm& arm = arms_[index];
  if (const auto bad = bad_end(arm, arm.robot.motion->last_id())) throw Error(*bad->problem);
  require_compliance(arm, where);
  begin_ride(asked, arm, where);
  program::Move move = asked;
  if (is_relative(move)) {
    data::Point place = *here(move.robot, move.tool, move.named_frame()).as_point();
    if (move.frame_pose) place.pose = inverse(*move.frame_pose) * place.pose;
    move = from_here(std::move(move), place, *arm.robot.robot, arm.robot.motion->planned());
  }
  auto [of, moves, facts] = prepare(move, where);
  if (move.step.group != 0 && move.step.members > 1 && moves.size() > 1 &&
      std::any_of(moves.begin(), moves.end(), [](const moves::Move& one) { return moves::bends(one); }))
    throw Error(Problem{
        "bad-move", where,
        "in 'together' a move around obstacles has one point, here are " + std::to_string(moves.size()),
        "write `around false`, or one point"});
  const auto step = step_of(move, index, where);
  Moves queued{index, arm.robot.motion->last_id() + 1, 0};
  for (moves::Move& one : moves) {
    std::string name = one.end().name;
    queued.last = arm.robot.motion->queue(std::move(one), facts, step);
    arm.open.push_back({queued.last, where, std::move(name), move.called});
  }
  note_touch(arm, queued, move.touch, where);
  forget_ended();
  asked_[++last_handle_] = {queued};
  return last_handle_;
}

/// Converts poses to the joint states nearest to `near`.
void ProgramMoves::keep_near(const data::JointState& near, const moves::RobotFacts& robot,
                             std::vector<moves::Move>& moves) const {
  const std::vector<double> joints = joints_by_name(*robot.model, near, "'near'");
  for (moves::Move& move : moves)
    for (moves::MoveTarget& target : move.targets)
      if (const Pose* pose = std::get_if<Pose>(&target.at))
        target.at = moves::joints_for(robot, *pose, joints, target.name);
}

void ProgramMoves::check_payload(const program::Move& move, const Arm& arm, const Location& where) const {
  const auto& rated = arm.robot.robot->model.provenance.payload_kg;
  if (!move.payload || !rated || move.payload->value <= *rated) return;
  throw Error(Problem{"limit", where,
                      fmt::format("a payload of {:g} kg is more than the {:g} kg that {} may carry",
                                  move.payload->value, *rated, arm.robot.robot->model.name),
                      "carry less, or take a stronger robot"});
}

/// The state shared by moves of one group. Two moves of one robot cannot be in the same group.
std::shared_ptr<moves::InStep> ProgramMoves::step_of(const program::Move& move, std::size_t arm,
                                                     const Location& where) {
  if (move.step.group == 0 || move.step.members < 2) return nullptr;
  if (step_.group != move.step.group)
    step_ = {move.step.group, std::make_shared<moves::InStep>(move.step.members), {}};
  if (std::find(step_.arms.begin(), step_.arms.end(), arm) != step_.arms.end()) {
    step_.shared->leave();
    throw Error(Problem{"two-moves", where,
                        "'" + arms_[arm].robot.robot->entry.name +
                            "' is moved twice in one 'together': its statements run at the same time",
                        "put these moves one after the other outside of 'together', or name another robot"});
  }
  step_.arms.push_back(arm);
  return step_.shared;
}

void ProgramMoves::forget(const moves::BaseMotion& base) {
  for (Arm& arm : arms_)
    if (arm.robot.base == &base) arm.robot.base = nullptr;
}

/// Forgets the oldest moves, which nobody waits for.
void ProgramMoves::forget_ended() {
  constexpr std::size_t kKept = 2000;
  while (asked_.size() > kKept) asked_.erase(asked_.begin());
}

/// The result of the first unreported move that did not end well; removes the ones that did.
std::optional<program::Progress> ProgramMoves::bad_end(Arm& arm, std::uint64_t through) {
  const moves::RobotMotion& motion = *arm.robot.motion;
  while (!arm.open.empty() && arm.open.front().id <= through &&
         motion.state_of(arm.open.front().id) == moves::MoveState::done)
    arm.open.pop_front();
  if (arm.open.empty() || !motion.ended_badly_from(arm.open.front().id)) return std::nullopt;
  // A failed move explains more than moves that were discarded because of it.
  for (const auto wanted : {moves::MoveState::failed, moves::MoveState::refused, moves::MoveState::discarded})
    for (const Open& open : arm.open) {
      if (open.id > through || motion.state_of(open.id) != wanted) continue;
      const Open told = open;
      arm.open.clear();
      if (wanted == moves::MoveState::discarded)
        return program::Progress::ended({"discarded",
                                         told.where,
                                         "the move to " + told.name + " was discarded",
                                         {},
                                         Severity::error,
                                         {{"target", told.name}}});
      Problem problem = motion.problem_of(told.id).value_or(
          Problem{"refused",
                  {},
                  "the controller refused the move to " + told.name + ": it would have begun with a jump",
                  {}});
      if (problem.where.file.empty()) problem.where = told.where;
      problem.what += told.called;
      problem.facts.push_back({"robot", arm.robot.robot->entry.name});
      return program::Progress::failed(std::move(problem));
    }
  return std::nullopt;
}

program::Progress ProgramMoves::poll(program::Handle handle) {
  if (const auto at = interruptions_.find(handle); at != interruptions_.end()) {
    if (!is_over(at->second)) return {};
    const Interruption over = std::move(at->second);
    interruptions_.erase(at);
    return result_of(over);
  }
  const auto found = asked_.find(handle);
  if (found == asked_.end()) return program::Progress::done();
  bool arrived = true;
  for (const Moves& moves : found->second) {
    Arm& arm = arms_[moves.arm];
    if (moves.base) {
      using State = moves::BaseMotion::State;
      const State state = arm.robot.base ? arm.robot.base->state_of(moves.last) : State::discarded;
      if (state == State::running) return {};
      Problem why{"discarded", {}, "the move of the base was discarded", {}};
      if (state == State::failed && arm.robot.base->problem()) why = *arm.robot.base->problem();
      asked_.erase(found);
      return state == State::done     ? program::Progress::done()
             : state == State::failed ? program::Progress::failed(std::move(why))
                                      : program::Progress::ended(std::move(why));
    }
    // A failure of a later move also ends the wait for this one.
    if (auto bad = bad_end(arm, arm.robot.motion->last_id())) {
      asked_.erase(found);
      return std::move(*bad);
    }
    arrived = arrived && arm.robot.motion->state_of(moves.last) != moves::MoveState::running;
  }
  if (!arrived) return {};
  asked_.erase(found);
  return program::Progress::done();
}

bool ProgramMoves::has_room(const std::string& robot) {
  const Arm& arm = arms_[robot_of(robot, {})];
  return !arm.robot.motion || arm.robot.motion->has_room();
}

/// False for a move that failed, was refused or was discarded.
static bool arrives(moves::MoveState state) {
  return state == moves::MoveState::running || state == moves::MoveState::done;
}

/// Waits for one robot, or for all.
program::Handle ProgramMoves::start_arrival(const std::string& robot) {
  Asked asked;
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    moves::RobotMotion* motion = arms_[i].robot.motion;
    if (!motion || (!robot.empty() && arms_[i].robot.robot->entry.name != robot)) continue;
    motion->close();
    std::uint64_t last = motion->newest_present();  // moves before one that failed may be under way
    while (last > 0 && !arrives(motion->state_of(last))) --last;
    asked.push_back({i, 0, last});
  }
  asked_[++last_handle_] = std::move(asked);
  return last_handle_;
}

program::Travel ProgramMoves::travel(program::Handle handle) const {
  const auto found = asked_.find(handle);
  constexpr Nanoseconds kForever = std::numeric_limits<Nanoseconds>::max();
  if (found == asked_.end() || found->second.empty())  // it ended long ago
    return {std::numeric_limits<double>::infinity(), 0, kForever, 0};
  const Moves& moves = found->second.front();
  if (moves.base) return {0, std::numeric_limits<double>::infinity(), 0, kForever};
  const moves::Travel way = arms_[moves.arm].robot.motion->travel(moves.first, moves.last);
  const auto time = [](double s) { return s < 1e9 ? static_cast<Nanoseconds>(1e9 * s) : kForever; };
  if (way.left == 0 && way.remaining == 0 && way.covered == 0)  // the robot has arrived
    return {std::numeric_limits<double>::infinity(), 0, kForever, 0};
  return {way.covered, way.left, time(way.elapsed), time(way.remaining)};
}

void ProgramMoves::end(program::Handle handle) {
  const auto found = asked_.find(handle);
  if (found == asked_.end()) return;
  for (const Moves& moves : found->second) {
    Arm& arm = arms_[moves.arm];
    if (!moves.base) {
      moves::RobotMotion& motion = *arm.robot.motion;
      motion.end(moves.first);
      std::erase_if(arm.open, [&](const Open& open) {  // their failures are not reported any more
        return open.id >= moves.first && !arrives(motion.state_of(open.id));
      });
    } else if (arm.robot.base) {
      arm.robot.base->drop();
    }
  }
}

data::Value ProgramMoves::here(const std::string& robot, const std::string& tool,
                               const std::string& frame) const {
  if (const auto base = only_base(robot)) return place_in(arms_[*base].robot.base->pose(), *base, frame);
  return here_at(
      robot, tool, frame, [this](std::size_t arm) { return present_joints(arm); },
      is_on_its_way(arm_of(robot, {})));
}

/// True while the robot is not at the end of what is planned: conditions are evaluated then, too.
bool ProgramMoves::is_on_its_way(std::size_t arm) const {
  const moves::RobotMotion& motion = *arms_[arm].robot.motion;
  return joints_now_ && (!motion.at_end() || motion.complying());
}

std::vector<double> ProgramMoves::present_joints(std::size_t arm) const {
  return is_on_its_way(arm) ? joints_now_(arm) : arms_[arm].robot.motion->planned();
}

data::JointState ProgramMoves::here_joints(const std::string& robot) const {
  return here_joints(robot, [this](std::size_t arm) { return present_joints(arm); });
}

data::JointState ProgramMoves::here_joints(const std::string& robot, const JointsOf& joints_of) const {
  const std::size_t index = arm_of(robot, {});
  return joint_state(arms_[index].robot.robot->model, joints_of(index));
}

data::JointState ProgramMoves::joints_at(const data::Value& place, const data::JointState* near,
                                         const std::string& robot, const std::string& tool,
                                         const std::string& frame) {
  return joints_at(place, near, robot, tool, frame,
                   [this](std::size_t arm) { return arms_[arm].robot.motion->planned(); });
}

/// The joints in which a joint move to `place` would end.
data::JointState ProgramMoves::joints_at(const data::Value& place, const data::JointState* near,
                                         const std::string& robot, const std::string& tool,
                                         const std::string& frame, const JointsOf& joints_of) {
  program::Move move;
  move.targets = {{place, "the place of ik()"}};
  move.robot = robot, move.tool = tool, move.frame = frame;
  if (near) move.near = *near;
  const Prepared made = prepare(move, {});
  const CellRobot& own = *arms_[made.arm].robot.robot;
  const moves::MoveTarget& end = made.moves.front().end();
  if (const auto* joints = std::get_if<std::vector<double>>(&end.at)) return joint_state(own.model, *joints);
  return joint_state(own.model, moves::joints_for(made.with ? *made.with : *own.facts, std::get<Pose>(end.at),
                                                  joints_of(made.arm), end.name));
}

data::Value ProgramMoves::pose_at(const data::JointState& joints, const std::string& robot,
                                  const std::string& tool, const std::string& frame) const {
  return here_at(robot, tool, frame, [&](std::size_t arm) {
    return joints_by_name(arms_[arm].robot.robot->model, joints, "fk()");
  });
}

data::Value ProgramMoves::here_at(const std::string& robot, const std::string& tool, const std::string& frame,
                                  const JointsOf& joints_of, bool shifted) const {
  const std::size_t index = arm_of(robot, {});
  const Arm& arm = arms_[index];
  const Pose tcp = arm.robot.motion->robot().chain.forward(joints_of(index));
  Pose tool0 = tcp * inverse(arm.robot.robot->tool.tcp);
  if (const bool on_belt = !belt_of_frame(frame).empty(); on_belt == shifted) {
    const Pose moved = arm.robot.motion->ride_moved();
    tool0 = (shifted ? inverse(moved) : moved) * tool0;
  }
  return data::Point{inverse(frame_named(frame, arm, {})) * tool0 * tcp_of_tool(tool, arm, {}), true};
}

void ProgramMoves::forget(const moves::RobotMotion& motion) {
  for (Arm& arm : arms_)
    if (arm.robot.motion == &motion) arm.robot.motion = nullptr, arm.open.clear();
  asked_.clear();
}

Location ProgramMoves::place_of(const moves::RobotMotion& motion, std::uint64_t move) const {
  for (const Arm& arm : arms_)
    for (const Open& open : arm.open)
      if (arm.robot.motion == &motion && open.id == move) return open.where;
  return {};
}

bool ProgramMoves::under_way(program::Handle handle) const {
  const auto found = asked_.find(handle);
  if (found == asked_.end()) return false;
  return std::any_of(found->second.begin(), found->second.end(), [&](const Moves& moves) {
    const Robot& robot = arms_[moves.arm].robot;
    if (moves.base)
      return robot.base && robot.base->state_of(moves.last) == moves::BaseMotion::State::running;
    return robot.motion && robot.motion->state_of(moves.last) == moves::MoveState::running &&
           robot.motion->move_under_way() <= moves.last;
  });
}

bool ProgramMoves::given_up(program::Handle handle) const {
  const auto found = asked_.find(handle);
  if (found == asked_.end()) return false;
  return std::any_of(found->second.begin(), found->second.end(), [&](const Moves& moves) {
    const Robot& robot = arms_[moves.arm].robot;
    using Base = moves::BaseMotion::State;
    if (moves.base) {
      const Base state = robot.base ? robot.base->state_of(moves.last) : Base::discarded;
      return state != Base::running && state != Base::done;
    }
    return !robot.motion || !arrives(robot.motion->state_of(moves.last));
  });
}

bool ProgramMoves::moving() const {
  return std::any_of(arms_.begin(), arms_.end(), [](const Arm& arm) {
    return (arm.robot.motion && !arm.robot.motion->idle()) || (arm.robot.base && !arm.robot.base->idle());
  });
}

}  // namespace polyarm::cell
