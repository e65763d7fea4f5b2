#include "polyarm/tasks/program_host.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/data/rows.hpp"

namespace polyarm::cell {

namespace {
/// The model's joint turns or slides, and the position was given for the other kind.
void check_unit(const description::RobotModel& model, std::size_t joint, Dimension given, double position,
                const std::string& what) {
  if (given != Dimension::angle && given != Dimension::length) return;
  const description::Joint& own = model.joints[static_cast<std::size_t>(model.actuated[joint])];
  const bool slides = own.type == description::JointType::prismatic;
  if (slides == (given == Dimension::length)) return;
  throw Error("joint-unit",
              fmt::format("{} has {} for '{}' of {}, which {}", what, slides ? "an angle" : "a length",
                          own.name, model.name, slides ? "slides" : "turns"),
              slides ? fmt::format("write a length, such as {:.0f}mm", 1000 * position)
                     : "write an angle, such as 30deg");
}
}  // namespace

std::vector<double> joints_by_name(const description::RobotModel& model, const data::JointState& joints,
                                   const std::string& what) {
  const std::vector<std::string> names = model.joint_names();
  if (joints.names.empty() && !joints.positions.empty()) {  // in the robot's joint order
    if (joints.positions.size() == names.size()) {
      for (std::size_t j = 0; j < names.size(); ++j)
        check_unit(model, j, joints.given_at(j), joints.positions[j], what);
      return joints.positions;
    }
    throw Error("missing-joint",
                fmt::format("{} has {} values, {} has {} joints: {}", what, joints.positions.size(),
                            model.name, names.size(), join(names, ", ")),
                "write joints(NAME = 30deg, …)");
  }
  for (const std::string& joint : joints.names)
    if (std::find(names.begin(), names.end(), joint) == names.end())
      throw Error("unknown-joint",
                  fmt::format("{} names the joint '{}', which {} does not have{}", what, joint, model.name,
                              did_you_mean(joint, names)),
                  "joint states fit one robot model; a pose works for all");
  std::vector<double> out;
  for (const std::string& joint : names) {
    const double* position = joints.find(joint);
    if (!position)
      throw Error("missing-joint",
                  fmt::format("{} has no value for the joint '{}' of {}", what, joint, model.name),
                  "write `here_joints() with NAME = 20deg` to change some joints only");
    check_unit(model, out.size(),
               joints.given_at(static_cast<std::size_t>(position - joints.positions.data())), *position,
               what);
    out.push_back(*position);
  }
  return out;
}

const data::Value* ProgramHost::find(std::string_view name) const {
  const data::Value* value = c_.store->find(name);
  const data::Point* point = value ? value->as_point() : nullptr;
  if (!point || (!c_.moves && !c_.in_world) || point->frame().empty()) return value;
  data::Value& out = in_world_[std::string(name)];
  out = in_world(*point);
  return &out;
}

void ProgramHost::set(const std::string& name, data::Value value, const Location&) {
  c_.store->set(name, std::move(value), c_.task);
}

program::Handle ProgramHost::start_move(const program::Move& move, const Location& where) {
  if (!c_.moves)
    throw Error(Problem{"no-robot", where, "'" + c_.task + "' moves no robot",
                        "only the robot program can move one"});
  return c_.moves->start(move, where);
}

program::Handle ProgramHost::start_arrival(const std::string& robot) {
  return c_.moves ? c_.moves->start_arrival(robot) : 0;
}

program::Handle ProgramHost::suspend(const std::vector<std::string>& robots) {
  return c_.moves ? c_.moves->suspend(robots) : 0;
}

program::Handle ProgramHost::resume(const std::vector<std::string>& robots) {
  return c_.moves ? c_.moves->resume(robots) : 0;
}

void ProgramHost::abandon(const std::vector<std::string>& robots) {
  if (c_.moves) c_.moves->abandon(robots);
}

program::Progress ProgramHost::poll_move(program::Handle handle) {
  return c_.moves ? c_.moves->poll(handle) : program::Progress::done();
}

data::Value ProgramHost::here(const std::string& robot, const std::string& tool,
                              const std::string& frame) const {
  return moves().here(robot, tool, frame);
}

ProgramMoves& ProgramHost::moves() const {
  if (!c_.moves) throw Error("no-robot", "'" + c_.task + "' moves no robot");
  return *c_.moves;
}

data::JointState ProgramHost::here_joints(const std::string& robot) const {
  return moves().here_joints(robot);
}

data::JointState ProgramHost::joints_at(const data::Value& place, const data::JointState* near,
                                        const std::string& robot, const std::string& tool,
                                        const std::string& frame) const {
  return moves().joints_at(place, near, robot, tool, frame);
}

data::Value ProgramHost::pose_at(const data::JointState& joints, const std::string& robot,
                                 const std::string& tool, const std::string& frame) const {
  return moves().pose_at(joints, robot, tool, frame);
}

std::array<double, 6> ProgramHost::wrench(const std::string& robot) {
  return c_.force ? c_.force->wrench(moves().name_of(robot)) : Host::wrench(robot);
}

void ProgramHost::comply(const std::string& robot, const program::Compliance& how) {
  c_.force ? moves().comply(robot, how, *c_.force) : Host::comply(robot, how);
}

void ProgramHost::stiff(const std::string& robot) {
  if (c_.moves) c_.moves->stiff(robot);
}

void ProgramHost::zero_force(const std::string& robot) {
  c_.force ? c_.force->zero(moves().name_of(robot)) : Host::zero_force(robot);
}

bool ProgramHost::next_part(const std::string& belt, const std::string& robot) {
  return c_.belts ? moves().next_part(belt, robot) : Host::next_part(belt, robot);
}

double ProgramHost::waiting_parts(const std::string& belt) {
  return c_.belts ? static_cast<double>(c_.belts->waiting(belt)) : Host::waiting_parts(belt);
}

double ProgramHost::missed_parts(const std::string& belt) {
  return c_.belts ? static_cast<double>(c_.belts->missed(belt)) : Host::missed_parts(belt);
}

void ProgramHost::add_part(const std::string& belt, const Pose& at) {
  c_.belts ? c_.belts->add(belt, at) : Host::add_part(belt, at);
}

Streams& ProgramHost::streams(const std::string& wanted) const {
  if (!c_.streams) throw Error("unknown-stream", "the cell has no stream '" + wanted + "'");
  return *c_.streams;
}

Stream& ProgramHost::used(const std::string& stream) {
  return streams(stream).used(stream, now());
}

bool ProgramHost::is_connected(const std::string& stream) {
  return streams(stream).is_connected(stream, now());
}

data::List ProgramHost::rows_of(const std::string& file) {
  return rows_in(c_.folder, file);
}

data::List rows_in(const std::filesystem::path& folder, const std::string& file) {
  std::error_code unknown;
  if (!file.empty() && !std::filesystem::exists(folder / file, unknown) && !unknown)
    throw Error("no-table",
                "there is no file '" + file + "'" +
                    did_you_mean(std::filesystem::path(file).filename().string(),
                                 data::file_names_in((folder / file).parent_path())),
                "rows_of() reads a table in the folder of the cell");
  return data::read_rows(read_file(folder / file, data::kMostRowBytes), file);
}

void ProgramHost::hold(const std::string& reason, const Location& where) {
  if (!c_.hold) return Host::hold(reason, where);
  c_.hold(reason, where);
}

program::Handle ProgramHost::start_load(const std::string& name, program::LoadForm, const Location& where) {
  return c_.files->start_load(name, where);
}

program::Progress ProgramHost::poll_load(program::Handle handle) {
  try {
    return c_.files->poll_load(handle) ? program::Progress::done() : program::Progress{};
  } catch (const Error& e) {
    return program::Progress::failed(e.problems().front());
  }
}

program::Handle ProgramHost::start_ask(const std::string& text, const Location& where) {
  c_.answers->begin();
  if (c_.answers->none() && !c_.answers->can_answer)
    throw Error(Problem{"nobody-there", where, "the program waits for a user, but nobody can answer: " + text,
                        "run it in a terminal, or give the answer in advance with --answer TEXT"});
  c_.observer->on_question(text.empty() ? "The program waits for you. Press Enter to continue." : text);
  return 1;
}

program::Progress ProgramHost::poll_ask(program::Handle) {
  std::optional<std::string> answer = c_.answers->take();
  if (!answer) return {};
  answer_ = std::move(*answer);
  return program::Progress::done();
}

void ProgramHost::run_program(const std::string& name, const Location& where) {
  if (!c_.run_program) return Host::run_program(name, where);
  c_.run_program(name, where);
}

data::Value ProgramHost::call(std::string_view function, std::span<const data::Value> arguments,
                              const Location& where) {
  return c_.call ? c_.call(function, arguments, where) : Host::call(function, arguments, where);
}

}  // namespace polyarm::cell
