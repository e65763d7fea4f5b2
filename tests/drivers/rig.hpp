#pragma once
/// A driver under test: its interfaces by name, its clock, and small robots and things to put around it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/description/model_builder.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::test {

/// Writes, then reads, once a cycle; the commands stay until they are changed.
class Rig {
 public:
  Rig(std::unique_ptr<hardware::Component> component, hardware::ComponentContext context)
      : component_(std::move(component)), context_(std::move(context)) {
    EXPECT_EQ(component_->on_init(context_), hardware::CallbackReturn::success);
    EXPECT_EQ(component_->on_configure(), hardware::CallbackReturn::success);
    EXPECT_EQ(component_->on_activate(), hardware::CallbackReturn::success);
    for (const auto& d : component_->state_interfaces()) {
      state_index_[d.name] = states_.size();
      states_.push_back(d.initial);
    }
    for (const auto& d : component_->command_interfaces()) {
      command_index_[d.name] = commands_.size();
      commands_.push_back(std::numeric_limits<double>::quiet_NaN());
    }
    cycle_.period = context_.period;
    component_->read(cycle_, states_);
  }

  double& command(const std::string& name) { return commands_[command_index_.at(name)]; }
  double state(const std::string& name) const { return states_[state_index_.at(name)]; }
  bool has_state(const std::string& name) const { return state_index_.contains(name); }
  bool has_command(const std::string& name) const { return command_index_.contains(name); }
  const std::vector<double>& states() const { return states_; }
  const hardware::WorldState& world() const { return *component_->world(); }
  const hardware::PartState& part(std::size_t i) const { return world().parts[i]; }
  hardware::Component& component() { return *component_; }
  double now() const { return seconds(cycle_.time); }

  /// One cycle; the worse of what write and read return.
  hardware::ReturnType cycle() {
    const hardware::ReturnType written = component_->write(cycle_, commands_);
    cycle_.time += cycle_.period;
    ++cycle_.index;
    const hardware::ReturnType read = component_->read(cycle_, states_);
    return written == hardware::ReturnType::ok ? read : written;
  }
  void run(double duration) {
    for (const Nanoseconds end = cycle_.time + nanoseconds(duration); cycle_.time < end;)
      ASSERT_EQ(cycle(), hardware::ReturnType::ok) << "at " << now() << " s";
  }
  /// Moves commands from where they are to `goal` in `duration` seconds, smoothly: rest to rest without a step
  /// in acceleration (the quintic 10 s³ - 15 s⁴ + 6 s⁵).
  void move(const std::map<std::string, double>& goal, double duration) {
    std::map<std::string, double> from;
    for (const auto& [name, to] : goal)
      from[name] = std::isfinite(command(name)) ? command(name) : state(name);
    const double start = now();
    const auto cycles = static_cast<int>(std::lround(duration / seconds(context_.period)));
    for (int k = 1; k <= cycles; ++k) {
      const double s = static_cast<double>(k) / cycles;
      for (const auto& [name, to] : goal)
        command(name) = from[name] + (to - from[name]) * s * s * s * (10 - s * (15 - 6 * s));
      ASSERT_EQ(cycle(), hardware::ReturnType::ok) << "in the move begun at " << start << " s";
      worst_tracking_ = std::max(worst_tracking_, component_->world() ? world().tracking_error : 0.0);
    }
  }
  double worst_tracking() const { return worst_tracking_; }
  void switch_mode(std::vector<std::string> start, std::vector<std::string> stop) {
    ASSERT_EQ(component_->prepare_command_mode_switch(start, stop), hardware::ReturnType::ok);
    ASSERT_EQ(component_->perform_command_mode_switch(start, stop), hardware::ReturnType::ok);
  }
  /// "0.123 s: arm/z_link touches fixture table, 1.2 mm" for each finding.
  std::string findings() const {
    const std::vector<std::string> names = component_->world_names();
    const auto name = [&](int i) { return i < 0 ? std::string("?") : names.at(static_cast<std::size_t>(i)); };
    std::string out;
    for (int i = 0; i < std::min(world().finding_count, hardware::WorldState::kMaxFindings); ++i) {
      const hardware::Contact& c = world().findings[static_cast<std::size_t>(i)];
      out += std::to_string(seconds(c.time)) + " s: " + name(c.a) + " touches " + name(c.b) + ", " +
             std::to_string(c.depth * 1e3) + " mm\n";
    }
    return out;
  }

 private:
  std::unique_ptr<hardware::Component> component_;
  hardware::ComponentContext context_;
  std::map<std::string, std::size_t> state_index_, command_index_;
  std::vector<double> states_, commands_;
  hardware::Cycle cycle_;
  double worst_tracking_ = 0;
};

// --- robots -------------------------------------------------------------------------------------------------

inline description::Link link(const std::string& name, double mass = 0, Vec3 center = {}) {
  description::Link out;
  out.name = name;
  if (mass > 0)
    out.inertial = description::Inertial{mass, center, {0.01 * mass, 0, 0, 0.01 * mass, 0, 0.01 * mass}};
  return out;
}

inline description::NamedJoint joint(const std::string& name, description::JointType type,
                                     const std::string& parent, const std::string& child, const Pose& origin,
                                     const Vec3& axis = {0, 0, 1}, double effort = 0) {
  description::NamedJoint out;
  out.joint.name = name;
  out.joint.type = type;
  out.joint.origin = origin;
  out.joint.axis = axis;
  if (type != description::JointType::fixed) {
    out.joint.limits.lower = -3;
    out.joint.limits.upper = 3;
    out.joint.limits.velocity = 3;
    out.joint.limits.effort = effort;
  }
  out.parent = parent;
  out.child = child;
  return out;
}

inline description::RobotModel tie(description::RobotModel model,
                                   std::vector<description::NamedJoint> joints) {
  Problems problems;
  EXPECT_TRUE(description::tie_together(model, std::move(joints), {"test", 1}, problems, problems));
  problems.throw_if_errors();
  return model;
}

inline description::Shape box(const Vec3& size, const Vec3& at = {}) {
  description::Shape out;
  out.kind = description::ShapeKind::box;
  out.size = size;
  out.pose.position = at;
  return out;
}

/// Three sliding joints x, y, z; at zero tool0 is half a metre above the origin and points down. The last link is a
/// column of 40 mm above tool0.
inline description::RobotModel gantry(double effort = 2000) {
  using description::JointType;
  description::RobotModel model;
  model.name = "gantry";
  model.links = {link("base_link"), link("x_link", 4), link("y_link", 3), link("z_link", 2, {0, 0, 0.1}),
                 link("tool0")};
  model.links[3].collisions = {box({0.04, 0.04, 0.2}, {0, 0, 0.1})};
  return tie(std::move(model),
             {joint("x", JointType::prismatic, "base_link", "x_link", {{0, 0, 0.5}, {}}, {1, 0, 0}, effort),
              joint("y", JointType::prismatic, "x_link", "y_link", {}, {0, 1, 0}, effort),
              joint("z", JointType::prismatic, "y_link", "z_link", {}, {0, 0, 1}, effort),
              joint("flange", JointType::fixed, "z_link", "tool0", pose_xyz_rpy({}, {M_PI, 0, 0}))});
}

/// Two hinges about y, 0.4 m apart, links along x: gravity pulls at both. No shapes.
inline description::RobotModel two_links(double effort = 150) {
  using description::JointType;
  description::RobotModel model;
  model.name = "two_links";
  model.links = {link("base_link"), link("upper", 4, {0.2, 0, 0}), link("lower", 2, {0.2, 0, 0}), link("tool0")};
  return tie(
      std::move(model),
      {joint("shoulder", JointType::revolute, "base_link", "upper", {{0, 0, 1}, {}}, {0, 1, 0}, effort),
       joint("elbow", JointType::revolute, "upper", "lower", {{0.4, 0, 0}, {}}, {0, 1, 0}, effort),
       joint("flange", JointType::fixed, "lower", "tool0", pose_xyz_rpy({0.4, 0, 0}, {0, M_PI / 2, 0}))});
}

// --- scenes -------------------------------------------------------------------------------------------------

inline description::Part cube(const std::string& name, const Vec3& at, double edge = 0.04, double mass = 0.08) {
  description::Part out;
  out.name = name;
  out.kind = "cube";
  out.shape = box({edge, edge, edge});
  out.mass = mass;
  out.start.position = at;
  return out;
}

/// A floor 0.75 m down and a table whose top is z = 0.
inline description::Scene table() {
  description::Scene out;
  out.floor_height = -0.75;
  out.kinds = {"cube"};
  description::Fixture top;
  top.name = "table";
  top.shapes = {box({2, 2, 0.04})};
  top.pose.position.z = -0.02;
  out.fixtures = {top};
  return out;
}

/// Robot, tool and scene of one test, kept where the component may point to them.
struct Stage {
  description::RobotModel model;
  description::Tool tool;
  description::Scene scene;
  std::vector<double> start;
  Pose base;
  bool robot = true;
  int number = 0;  ///< of the robot in its cell

  hardware::ComponentContext context(Nanoseconds period = 1'000'000) const {
    hardware::ComponentContext out;
    out.name = "world";
    out.scene = &scene;
    out.period = period;
    if (robot) {
      hardware::RobotInstance arm;
      arm.name = "arm";
      arm.model = &model;
      arm.tool = tool.name == "none" ? nullptr : &tool;
      arm.base = base;
      arm.number = number;
      arm.initial_positions = start.empty() ? std::vector<double>(model.actuated.size(), 0.0) : start;
      out.robots = {arm};
    }
    return out;
  }
};

}  // namespace polyarm::test
