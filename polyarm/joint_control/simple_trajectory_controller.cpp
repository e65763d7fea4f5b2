#include "polyarm/joint_control/simple_trajectory_controller.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

SimpleTrajectoryController::~SimpleTrajectoryController() {
  delete points_;
}

CallbackReturn SimpleTrajectoryController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::vector<std::string> commands{"position", "velocity"}, states{"position", "velocity"};
  announced_.clear();
  joints_.clear();
  p.read("joints", announced_, {"the joints, in the order of commands"});
  p.read("command_interfaces", commands,
         {.text = "interfaces to command", .choices = {"position", "velocity"}});
  p.read("state_interfaces", states, {.text = "interfaces to read", .choices = {"position", "velocity"}});
  asked_.reset(announced_.size());
  for (const std::string& joint : announced_) {
    joints_.push_back(context.whole_joint(joint));
    asked_.set(joints_.size() - 1, joint, context.find_joint(joints_.back()));
  }
  position_command_.assign(joints_.size(), -1);
  velocity_command_.assign(joints_.size(), -1);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const auto asked = [&](const char* quantity) {
      return std::find(commands.begin(), commands.end(), quantity) != commands.end();
    };
    if (asked("position")) position_command_[j] = static_cast<int>(claim_command(joints_[j] + "/position"));
    if (asked("velocity")) velocity_command_[j] = static_cast<int>(claim_command(joints_[j] + "/velocity"));
    claim_state(joints_[j] + "/position");
  }
  for (const std::string& joint : joints_)
    for (const std::string& state : states) claim_state(joint + "/" + state);
  period_s_ = seconds(context.period);
  return joints_.empty() ? CallbackReturn::failure : CallbackReturn::success;
}

CallbackReturn SimpleTrajectoryController::on_activate(const Cycle&) noexcept {
  stop();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (position_command_[j] < 0) continue;
    const auto place = static_cast<std::size_t>(position_command_[j]);
    if (!std::isfinite(command(place))) set_command(place, state(j));
  }
  return CallbackReturn::success;
}

void SimpleTrajectoryController::stop() noexcept {
  inbox_.put_back(std::exchange(points_, nullptr));
  for (const int place : velocity_command_)
    if (place >= 0) set_command(static_cast<std::size_t>(place), 0);
}

void SimpleTrajectoryController::on_deactivate(const Cycle&) noexcept {
  while (Points* waiting = inbox_.take()) inbox_.put_back(waiting);
  stop();
}

void SimpleTrajectoryController::check_limits(const TrajectoryMessage& message,
                                              const std::vector<std::size_t>& order) const {
  Problems problems;
  for (std::size_t i = 0; i < message.points.size(); ++i)
    for (std::size_t j = 0; j < order.size(); ++j) {
      const trajectory::TrajectoryPoint& p = message.points[i];
      const std::string at = " at point " + std::to_string(i + 1);
      asked_.check(problems, j, Asked::position, p.positions[order[j]], at);
      if (!p.velocities.empty()) asked_.check(problems, j, Asked::velocity, p.velocities[order[j]], at);
    }
  problems.throw_if_errors();
}

std::uint64_t SimpleTrajectoryController::receive(const std::string&, const Input& message, bool) {
  const auto* trajectory = std::get_if<TrajectoryMessage>(&message);
  if (!trajectory)
    throw Error("wrong-message", "this controller takes trajectories (trajectory_msgs/JointTrajectory)");
  std::vector<std::size_t> order;
  for (std::size_t j = 0; j < announced_.size(); ++j) {
    const auto& names = trajectory->joints;
    const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
      return name == announced_[j] || name == joints_[j];
    });
    if (found == names.end())
      throw Error("missing-joint", "the trajectory leaves out " + announced_[j], "name all joints");
    order.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  trajectory::TrajectoryPoint start;
  start.positions.assign(trajectory->joints.size(), 0.0);
  Problems problems;
  for (const Problem& problem :
       trajectory::check_points(start, trajectory->points, {.allow_nonzero_velocity_at_end = true}))
    problems.add(problem);
  problems.throw_if_errors();
  check_limits(*trajectory, order);
  auto points = std::make_unique<Points>();
  for (const trajectory::TrajectoryPoint& given : trajectory->points) {
    trajectory::TrajectoryPoint point;
    point.time_from_start = given.time_from_start;
    for (const std::size_t k : order) {
      point.positions.push_back(given.positions[k]);
      point.velocities.push_back(given.velocities.empty() ? 0.0 : given.velocities[k]);
    }
    points->push_back(std::move(point));
  }
  if (!inbox_.give(points)) throw Error("busy", "the controller has not taken the last trajectories yet");
  return 0;
}

ReturnType SimpleTrajectoryController::update(const Cycle&, const Verdict& verdict) noexcept {
  if (Points* arrived = inbox_.take()) {
    inbox_.put_back(std::exchange(points_, arrived));
    time_ = 0;
    at_ = 0;
  }
  for (std::size_t j = 0; j < joints_.size(); ++j) asked_.note_position(j, state(j));
  if (verdict.speed <= 0) {
    stop();
    return ReturnType::ok;
  }
  if (!points_) return ReturnType::ok;
  const Points& points = *points_;
  while (at_ + 1 < points.size() && time_ >= points[at_ + 1].time_from_start) ++at_;
  const trajectory::TrajectoryPoint& from = points[at_];
  const trajectory::TrajectoryPoint& to = points[std::min(at_ + 1, points.size() - 1)];
  const double length = to.time_from_start - from.time_from_start;
  const double share = length > 0 ? std::clamp((time_ - from.time_from_start) / length, 0.0, 1.0) : 1.0;
  const bool over = time_ >= points.back().time_from_start;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const auto between = [&](const std::vector<double>& a, const std::vector<double>& b) {
      return a[j] + share * (b[j] - a[j]);
    };
    if (position_command_[j] >= 0)
      set_command(static_cast<std::size_t>(position_command_[j]), between(from.positions, to.positions));
    if (velocity_command_[j] >= 0)
      set_command(static_cast<std::size_t>(velocity_command_[j]),
                  over ? 0.0 : between(from.velocities, to.velocities));
  }
  time_ += period_s_;
  if (over) stop();
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
