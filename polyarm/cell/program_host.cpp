#include "polyarm/cell/program_host.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

std::vector<double> joints_by_name(const description::RobotModel& model, const data::JointState& joints,
                                   const std::string& what) {
  const std::vector<std::string> names = model.joint_names();
  for (const std::string& joint : joints.names)
    if (std::find(names.begin(), names.end(), joint) == names.end())
      throw Error("unknown-joint",
                  fmt::format("{} names the joint '{}', which {} does not have{}", what, joint, model.name,
                              did_you_mean(joint, names)),
                  "joint states belong to one make of robot; a pose works for all");
  std::vector<double> out;
  for (const std::string& joint : names) {
    const double* position = joints.find(joint);
    if (!position)
      throw Error("missing-joint",
                  fmt::format("{} has no value for the joint '{}' of {}", what, joint, model.name), {});
    out.push_back(*position);
  }
  return out;
}

void ProgramHost::set(const std::string& name, data::Value value, const Location&) {
  c_.store->set(name, std::move(value), c_.task);
}

program::Handle ProgramHost::start_move(const program::Move& move, const Location& where) {
  if (!c_.motion)
    throw Error(
        Problem{"no-robot", where, "'" + c_.task + "' moves no robot", "only the robot program can moveto"});
  if (move.kind != program::Move::Kind::joint || !move.waits || move.targets.size() != 1)
    throw Error(Problem{"not-yet", where, "this cell makes joint moves to one point only", "write `moveto`"});
  motion::Pace pace;
  pace.speed = c_.pace.speed;
  pace.thesis_scale = c_.pace.thesis_scale;
  pace.seconds = c_.pace.seconds;
  const auto& [point, name] = move.targets.front();
  if (const data::JointState* joints = point.as_joints())
    last_move_ =
        c_.motion->move_to_joints(joints_by_name(*c_.motion->robot().model, *joints, name), pace, name);
  else if (const data::Point* pose = point.as_point())
    last_move_ = c_.motion->move_to_pose(pose->pose, pace, name);
  else
    throw Error(
        Problem{"not-a-point", where, "'" + name + "' is " + data::name(point.kind()) + ", not a point", {}});
  target_ = name;
  moving_ = true;
  return static_cast<program::Handle>(last_move_);
}

program::Handle ProgramHost::start_arrival(const std::string&) {
  return static_cast<program::Handle>(last_move_);
}

program::Progress ProgramHost::poll_move(program::Handle handle) {
  const motion::MoveState state =
      handle == 0 ? motion::MoveState::done : c_.motion->state_of(static_cast<std::uint64_t>(handle));
  if (state == motion::MoveState::running) return {};
  moving_ = false;
  if (state == motion::MoveState::done) return program::Progress::done();
  if (state == motion::MoveState::discarded)
    return program::Progress::ended({"discarded", {}, "the move to " + target_ + " was discarded", {}});
  return program::Progress::failed(
      {"refused",
       {},
       "the controller refused the move to " + target_ + ": it would have begun with a jump",
       {}});
}

program::Progress ProgramHost::poll_load(program::Handle handle) {
  try {
    return c_.files->poll_load(handle) ? program::Progress::done() : program::Progress{};
  } catch (const Error& e) {
    return program::Progress::failed(e.problems().front());
  }
}

program::Handle ProgramHost::start_ask(const std::string& text, const Location& where) {
  if (c_.answers->given().empty() && !c_.answers->somebody_there)
    throw Error(Problem{"nobody-there", where, "the program waits for a user, and there is none: " + text,
                        "run it in a terminal, or give the answer in advance with --answer TEXT"});
  c_.observer->on_question(text.empty() ? "The program waits for you. Press Enter to go on." : text);
  return 1;
}

program::Progress ProgramHost::poll_ask(program::Handle) {
  if (c_.answers->given().empty()) return {};
  c_.answers->given().pop_front();
  return program::Progress::done();
}

}  // namespace polyarm::cell
