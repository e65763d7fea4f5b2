#include "polyarm/setup/moving_base.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace polyarm::cell {

namespace {

/// Pose of a link in the root link with all joints at zero; the root's if there is no such link. The link
/// that odometry tracks is fixed to the root.
Pose in_root(const description::RobotModel& model, const std::string& frame) {
  const auto named = [&](const description::Link& link) {
    return !link.name.empty() && (frame == link.name || frame.ends_with("/" + link.name));
  };
  const auto found = std::find_if(model.links.begin(), model.links.end(), named);
  Pose out;
  if (found == model.links.end()) return out;
  for (int joint = found->parent_joint; joint >= 0;) {
    const description::Joint& j = model.joints[static_cast<std::size_t>(joint)];
    out = j.origin * out;
    joint = model.links[static_cast<std::size_t>(j.parent_link)].parent_joint;
  }
  return out;
}

}  // namespace

MovingBase::MovingBase(const CellRobot& robot, const hardware::InterfaceTable& table,
                       controllers::BaseController* wheels)
    : start_(robot.entry.base) {
  if (const auto first = table.find_state(robot.entry.name + "/base/position.x"))
    first_state_ = static_cast<int>(*first);
  if (wheels) output_ = wheels->odometry_output();
  if (!output_) return;
  odometry_name_ = output_->texts["frame_id"];
  base_name_ = output_->texts["child_frame_id"];
  tracked_ = in_root(robot.model, base_name_);
}

void MovingBase::look() {
  if (!output_) return;
  output_->fetch();
  const controllers::Output::Sample& sample = output_->value();
  if (sample.time == 0 || sample.values.size() < 7) return;
  const std::vector<double>& v = sample.values;
  odometry_ = {{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
}

std::optional<Pose> MovingBase::known(const control::Snapshot& snapshot) const {
  const auto first = static_cast<std::size_t>(first_state_);
  if (!in_physics() || snapshot.states.size() < first + 7) return std::nullopt;
  const double* v = snapshot.states.data() + first;
  if (!std::all_of(v, v + 7, [](double each) { return std::isfinite(each); })) return std::nullopt;
  return Pose{{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
}

Pose MovingBase::pose(const control::Snapshot& snapshot) const {
  if (carrier_) return carrier_->pose(snapshot) * inverse(carrier_->start_) * start_;
  if (const auto there = known(snapshot)) return *there;
  return start_ * tracked_ * odometry();
}

Pose MovingBase::odometry_frame(const control::Snapshot& snapshot) const {
  if (const auto there = known(snapshot)) return *there * inverse(odometry());
  return start_ * tracked_;
}

}  // namespace polyarm::cell
