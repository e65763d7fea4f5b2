#include "polyarm/force/admittance_controller.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::controllers {

namespace {
constexpr double kStill = 1e-4;        // rad/s or m/s
constexpr double kBeyondLimit = 1e-4;  // rad or m
constexpr const char* kAxes[] = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
constexpr const char* kFrameKey = "frame_id=";

void require_finite(std::span<const double> values, const char* what) {
  for (const double value : values)
    if (!std::isfinite(value))
      throw Error("not-a-number", std::string(what) + " has a value that is not finite; it is ignored");
}
}  // namespace

std::vector<InputPort> AdmittanceController::inputs() const {
  return {{"joint_references", {"trajectory_msgs/JointTrajectoryPoint"}},
          {"wrench_reference", {"geometry_msgs/WrenchStamped"}}};
}

std::uint64_t AdmittanceController::receive(const std::string& port, const Input& message, bool goal) {
  if (port == "wrench_reference") {
    const auto* named = std::get_if<NamedValues>(&message);
    if (!named) throw Error("wrong-message", "wrench_reference takes a wrench (geometry_msgs/WrenchStamped)");
    SixVector wrench{};
    for (std::size_t i = 0; i < named->names.size(); ++i) {
      const std::string& name = named->names[i];
      const auto axis = std::find(std::begin(kAxes), std::end(kAxes), name);
      if (axis != std::end(kAxes)) wrench[static_cast<std::size_t>(axis - kAxes)] = named->values[i];
      if (!name.starts_with(kFrameKey) || name == kFrameKey + sensor_frame_) continue;
      throw Error("wrong-message", "the wrench is in the frame '" + name.substr(9) + "'",
                  "send it in '" + sensor_frame_ + "', the frame of the sensor, or without a frame");
    }
    require_finite(wrench, "the wrench");
    wrench_inbox_.write(wrench);
    return 0;
  }
  if (port != "joint_references") return Controller::receive(port, message, goal);
  const auto* trajectory = std::get_if<TrajectoryMessage>(&message);
  if (!trajectory || trajectory->points.size() != 1)
    throw Error("wrong-message", "joint_references takes one point (trajectory_msgs/JointTrajectoryPoint)");
  const trajectory::TrajectoryPoint& point = trajectory->points.front();
  for (const auto* values : {&point.positions, &point.velocities}) {
    require_finite(*values, "the point");
    if (!values->empty() && values->size() != joints_.size())
      throw Error("wrong-size", "the point has " + std::to_string(values->size()) + " values for " +
                                    std::to_string(joints_.size()) + " joints");
  }
  for (std::size_t i = 0; i < point.positions.size(); ++i) {
    const JointFacts& joint = joints_[i].facts;
    if (point.positions[i] < joint.lower - kBeyondLimit || point.positions[i] > joint.upper + kBeyondLimit)
      throw Error("beyond-limits", "'" + joint.name + "' gets a command for a position of " +
                                       std::to_string(point.positions[i]) + " outside its limits");
  }
  points_inbox_.write({point.positions, point.velocities});
  return 0;
}

void AdmittanceController::on_parameters_changed() noexcept {
  if (!rule_) return;
  rule_->set_joint_damping(joint_damping_);
  rule_->set_filter(filter_);
  rule_->set_weight(weight_);
}

void AdmittanceController::measure() noexcept {
  bool whole = true;
  for (const JointPort& joint : joints_) whole = whole && std::isfinite(state(joint.position_state));
  for (std::size_t i = 0; i < joints_.size(); ++i)
    measured_[i] = whole ? state(joints_[i].position_state) : last_command_[i];
}

CallbackReturn AdmittanceController::on_activate(const Cycle&) noexcept {
  points_inbox_.fetch();  // what was sent while it was not active is forgotten
  wrench_inbox_.fetch();
  requested_wrench_ = {};
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const JointPort& joint = joints_[i];
    const double last = joint.position_command == kNone ? NAN : Controller::command(joint.position_command);
    const double now = state(joint.position_state);
    if (!std::isfinite(now)) return CallbackReturn::failure;
    last_command_[i] = reference_[i] = std::isfinite(last) ? last : now;
    reference_velocity_[i] = 0;
    if (joint.position_reference != kNone) set_reference(joint.position_reference, reference_[i]);
    if (joint.velocity_reference != kNone) set_reference(joint.velocity_reference, 0);
  }
  rule_->reset();
  on_parameters_changed();
  standing_.store(true, std::memory_order_relaxed);
  return CallbackReturn::success;
}

void AdmittanceController::on_deactivate(const Cycle&) noexcept {
  rule_->reset();
  for (const JointPort& joint : joints_)
    if (joint.velocity_command != kNone) set_command(joint.velocity_command, 0);
  standing_.store(true, std::memory_order_relaxed);
}

/// From the controller before this one, or from messages. A reference of NaN leaves the last one.
void AdmittanceController::take_inputs() noexcept {
  if (wrench_inbox_.fetch()) requested_wrench_ = wrench_inbox_.value();
  if (!chained() && points_inbox_.fetch()) {
    const Point& point = points_inbox_.value();
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      if (!point.positions.empty()) reference_[i] = point.positions[i];
      reference_velocity_[i] = point.velocities.empty() ? 0 : point.velocities[i];
    }
    return;
  }
  if (!chained()) return;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const JointPort& joint = joints_[i];
    if (joint.position_reference != kNone)
      if (const double value = reference(joint.position_reference); std::isfinite(value))
        reference_[i] = value;
    if (joint.velocity_reference != kNone) {
      const double value = reference(joint.velocity_reference);
      reference_velocity_[i] = std::isfinite(value) ? value : 0;
    }
  }
}

/// A wrench that is not measured counts as zero.
SixVector AdmittanceController::wrench() noexcept {
  SixVector out = requested_wrench_, measured;
  bool whole = true;
  for (std::size_t i = 0; i < 6; ++i) {
    measured[i] = state(sensor_[i]);
    whole = whole && std::isfinite(measured[i]);
  }
  for (std::size_t i = 0; whole && i < 6; ++i) out[i] += measured[i];
  return out;
}

void AdmittanceController::command() noexcept {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const JointPort& joint = joints_[i];
    const double lower = std::min(joint.facts.lower, reference_[i]),
                 upper = std::max(joint.facts.upper, reference_[i]);
    rule_->bound(i, lower - reference_[i], upper - reference_[i]);
    last_command_[i] = reference_[i] + rule_->offset()[i];
    if (joint.position_command != kNone) set_command(joint.position_command, last_command_[i]);
    if (joint.velocity_command != kNone)
      set_command(joint.velocity_command, reference_velocity_[i] + rule_->velocity()[i]);
  }
}

ReturnType AdmittanceController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  take_inputs();
  measure();
  bool well = true;
  const bool stopped = verdict.speed <= 0 || verdict.immediate || verdict.discard;
  if (stopped)
    rule_->freeze();
  else
    well = rule_->update(measured_, reference_, wrench(), seconds(cycle.period));
  command();
  const auto velocity = rule_->velocity();
  standing_.store(
      std::all_of(velocity.begin(), velocity.end(), [](double v) { return std::abs(v) < kStill; }),
      std::memory_order_relaxed);
  publish(cycle);
  return well ? ReturnType::ok : ReturnType::error;
}

void AdmittanceController::publish(const Cycle& cycle) noexcept {
  if (!status_->wanted()) return;
  auto out = status_->draft().values.begin();
  const auto put = [&](std::span<const double> values) {
    out = std::copy(values.begin(), values.end(), out);
  };
  const auto put_pose = [&](const Vec3& p, const Quaternion& q) {
    put(std::array{p.x, p.y, p.z, q.x, q.y, q.z, q.w});
  };
  SixVector axes;
  for (std::size_t i = 0; i < 6; ++i) axes[i] = parameters_.axes[i] ? 1 : 0;
  put(parameters_.mass);
  put(rule_->damping());
  put(parameters_.stiffness);
  put(axes);
  const Quaternion& control = rule_->control_rotation();
  put(std::array{control.x, control.y, control.z, control.w});
  put_pose(rule_->reference_pose().position, rule_->reference_pose().rotation);
  const SixVector& x = rule_->displacement();
  const Vec3 turn{x[3], x[4], x[5]};
  put_pose({x[0], x[1], x[2]}, from_axis_angle(normalized(turn), norm(turn)));
  put(rule_->twist_rate());
  put(rule_->twist());
  put(rule_->wrench());
  put(rule_->offset());
  put(rule_->velocity());
  put(rule_->acceleration());
  status_->publish(cycle.time);
}

}  // namespace polyarm::controllers
