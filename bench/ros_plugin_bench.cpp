/// A cycle of a ros2_control plugin with six joints: its own read and write called directly, and through the
/// component that wraps it. The difference is what Polyarm adds.
#include <benchmark/benchmark.h>

#include <array>
#include <memory>
#include <vector>

#include "polyarm/description/robot_model.hpp"
#include "polyarm_ros/component.hpp"
#include "polyarm_ros/module.hpp"

namespace six {

constexpr std::size_t kJoints = 6;

class Joints : public hardware_interface::SystemInterface {
 public:
  hardware_interface::CallbackReturn on_init(const hardware_interface::HardwareInfo& info) override {
    for (std::size_t i = 0; i < kJoints; ++i) names_[i] = info.joints.empty() ? "" : info.joints[i].name;
    return hardware_interface::CallbackReturn::SUCCESS;
  }
  std::vector<hardware_interface::StateInterface> export_state_interfaces() override {
    std::vector<hardware_interface::StateInterface> out;
    for (std::size_t i = 0; i < kJoints; ++i) {
      out.emplace_back(names_[i], "position", &position_[i]);
      out.emplace_back(names_[i], "velocity", &velocity_[i]);
    }
    return out;
  }
  std::vector<hardware_interface::CommandInterface> export_command_interfaces() override {
    std::vector<hardware_interface::CommandInterface> out;
    for (std::size_t i = 0; i < kJoints; ++i) out.emplace_back(names_[i], "position", &command_[i]);
    return out;
  }
  hardware_interface::return_type read(const rclcpp::Time&, const rclcpp::Duration& period) override {
    for (std::size_t i = 0; i < kJoints; ++i) {
      velocity_[i] = (command_[i] - position_[i]) / period.seconds();
      position_[i] = command_[i];
    }
    return hardware_interface::return_type::OK;
  }
  hardware_interface::return_type write(const rclcpp::Time&, const rclcpp::Duration&) override {
    benchmark::DoNotOptimize(command_);
    return hardware_interface::return_type::OK;
  }

  std::array<double, kJoints> position_{}, velocity_{}, command_{};

 private:
  std::array<std::string, kJoints> names_;
};

}  // namespace six
PLUGINLIB_EXPORT_CLASS(six::Joints, hardware_interface::SystemInterface)

namespace {

namespace hw = polyarm::hardware;

void direct(benchmark::State& state) {
  const std::unique_ptr<hardware_interface::SystemInterface> plugin = std::make_unique<six::Joints>();
  benchmark::DoNotOptimize(plugin.get());
  std::int64_t now = 0;
  for (auto _ : state) {
    const rclcpp::Time time(now += 1'000'000, RCL_ROS_TIME);
    const rclcpp::Duration period = rclcpp::Duration::from_nanoseconds(1'000'000);
    benchmark::DoNotOptimize(plugin->read(time, period));
    benchmark::DoNotOptimize(plugin->write(time, period));
  }
}
BENCHMARK(direct);

void wrapped(benchmark::State& state) {
  polyarm::description::RobotModel model;
  polyarm::description::HardwareInfo block;
  block.name = "bench", block.type = "system", block.plugin = "six/Joints";
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) {
    polyarm::description::Joint joint;
    joint.name = name, joint.type = polyarm::description::JointType::revolute;
    model.joints.push_back(joint);
    polyarm::description::ComponentInfo component;
    component.name = name, component.kind = "joint";
    polyarm::description::InterfaceInfo position, velocity;
    position.name = "position", velocity.name = "velocity";
    component.command_interfaces = {position}, component.state_interfaces = {position, velocity};
    block.components.push_back(component);
  }
  hw::RobotInstance robot;
  robot.name = "arm", robot.model = &model, robot.hardware = {block};
  hw::ComponentContext context;
  context.name = "bench", context.robots = {robot};
  polyarm_ros::RosComponent component("six/Joints", "six::Joints", true);
  if (component.on_init(context) != hw::CallbackReturn::success ||
      component.on_configure() != hw::CallbackReturn::success ||
      component.on_activate() != hw::CallbackReturn::success) {
    state.SkipWithError(component.reason().c_str());
    return;
  }
  std::vector<double> states(2 * six::kJoints), commands(six::kJoints, 0.5);
  hw::Component& called = component;
  hw::Cycle cycle{0, 1'000'000, 0};
  for (auto _ : state) {
    cycle.time += cycle.period;
    benchmark::DoNotOptimize(called.read(cycle, states));
    benchmark::DoNotOptimize(called.write(cycle, commands));
    benchmark::DoNotOptimize(states.data());
  }
}
BENCHMARK(wrapped);

}  // namespace
