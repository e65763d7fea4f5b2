/// The component that wraps a plugin of ros2_control: its numbers, its life cycle, its failures.
#include <gtest/gtest.h>

#include <algorithm>
#include <exception>
#include <limits>

#include "hardware_interface/base_interface.hpp"
#include "mock_components/generic_system.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm_ros/component.hpp"
#include "polyarm_ros/module.hpp"
#include "tests/support/realtime_guard.hpp"

namespace wrapped {

using hardware_interface::CallbackReturn;
using hardware_interface::return_type;

/// By hand, as in Humble. What happens in a cycle is up to the test.
class ByHand : public hardware_interface::SystemInterface {
 public:
  static inline std::string throws_in;
  static inline return_type returns = return_type::OK;
  static inline double written_speed = 0;
  static inline std::vector<std::string> calls, started;

  CallbackReturn on_init(const hardware_interface::HardwareInfo& info) override {
    if (SystemInterface::on_init(info) != CallbackReturn::SUCCESS) return CallbackReturn::ERROR;
    position_.assign(info_.joints.size(), 0.25), command_.assign(info_.joints.size(), 0.0), speed_ = 0;
    return CallbackReturn::SUCCESS;
  }
  std::vector<hardware_interface::StateInterface> export_state_interfaces() override {
    std::vector<hardware_interface::StateInterface> out;
    for (std::size_t i = 0; i < position_.size(); ++i)
      out.emplace_back(info_.joints[i].name, "position", &position_[i]);
    return out;
  }
  std::vector<hardware_interface::CommandInterface> export_command_interfaces() override {
    std::vector<hardware_interface::CommandInterface> out;
    for (std::size_t i = 0; i < command_.size(); ++i)
      out.emplace_back(info_.joints[i].name, "position", &command_[i]);
    out.emplace_back(info_.joints[0].name, "velocity", &speed_);
    return out;
  }
  CallbackReturn on_activate(const rclcpp_lifecycle::State& before) override {
    calls.push_back("activate after " + before.label());
    if (throws_in == "activate") throw std::runtime_error("the motor is hot");
    return CallbackReturn::SUCCESS;
  }
  return_type perform_command_mode_switch(const std::vector<std::string>& start,
                                          const std::vector<std::string>&) override {
    started = start;
    return return_type::OK;
  }
  return_type read(const rclcpp::Time&, const rclcpp::Duration&) override {
    if (throws_in == "read") throw std::runtime_error("the cable is cut");
    if (throws_in == "number") throw 7;
    for (std::size_t i = 0; i < position_.size(); ++i) position_[i] = command_[i];
    RCLCPP_DEBUG(rclcpp::get_logger("ByHand"), "this level is off");
    return returns;
  }
  return_type write(const rclcpp::Time&, const rclcpp::Duration&) override {
    written_speed = speed_;
    return return_type::OK;
  }

 private:
  std::vector<double> position_, command_;
  double speed_ = 0;
};

/// Reports its state, as in Rolling.
class Reporting : public hardware_interface::SystemInterface {
 public:
  static inline bool devices = true;
  CallbackReturn init_hardware_status_message(control_msgs::msg::HardwareStatus& out) override {
    out.hardware_device_states.resize(devices ? 1 : 0);
    if (devices) out.hardware_device_states[0].device_id = "pump";
    return CallbackReturn::SUCCESS;
  }
  return_type update_hardware_status_message(control_msgs::msg::HardwareStatus& out) override {
    out.hardware_id = std::to_string(++updates_) + (out.hardware_id.empty() ? "" : " kept");
    return updates_ == 1 ? return_type::ERROR : return_type::OK;  // the first one is not sent
  }

 private:
  int updates_ = 0;
};

/// By description, as in Rolling.
class ByDescription : public hardware_interface::SystemInterface {
 public:
  CallbackReturn on_init(const hardware_interface::HardwareComponentInterfaceParams& params) override {
    if (SystemInterface::on_init(params) != CallbackReturn::SUCCESS) return CallbackReturn::ERROR;
    for (const auto& [name, description] : joint_state_interfaces_) names_.push_back(name);
    return names_.size() == 2 ? CallbackReturn::SUCCESS : CallbackReturn::FAILURE;
  }
  CallbackReturn on_configure(const rclcpp_lifecycle::State&) override {
    for (const std::string& name : names_) set_state(name, 0.5), set_command(name, 0.5);
    return CallbackReturn::SUCCESS;
  }
  return_type read(const rclcpp::Time&, const rclcpp::Duration&) override {
    for (const std::string& name : names_) set_state(name, get_command(name));
    return return_type::OK;
  }
  return_type write(const rclcpp::Time&, const rclcpp::Duration&) override { return return_type::OK; }

 private:
  std::vector<std::string> names_;
};

/// Its port is not open, and closing it throws: also in the destructor.
struct Port {
  static inline std::atomic<int> closed{0};
  bool open = false;
  void close() {
    ++closed;
    if (!open) throw std::runtime_error("the port is not open");
  }
};
class Unplugged : public hardware_interface::SystemInterface {
 public:
  ~Unplugged() override { port_.close(); }
  CallbackReturn on_configure(const rclcpp_lifecycle::State&) override { return CallbackReturn::ERROR; }
  return_type read(const rclcpp::Time&, const rclcpp::Duration&) override { return return_type::OK; }
  return_type write(const rclcpp::Time&, const rclcpp::Duration&) override { return return_type::OK; }

 private:
  Port port_;
};

/// Ends as one does whose thread nobody joined.
class Unjoined : public hardware_interface::SystemInterface {
 public:
  ~Unjoined() override { std::terminate(); }
  return_type read(const rclcpp::Time&, const rclcpp::Duration&) override { return return_type::OK; }
  return_type write(const rclcpp::Time&, const rclcpp::Duration&) override { return return_type::OK; }
};

/// Inside its namespace and before life cycles, as in Foxy.
class OfFoxy : public hardware_interface::BaseInterface<hardware_interface::SystemInterface> {
 public:
  static inline bool started = false;
  return_type configure(const hardware_interface::HardwareInfo& info) override {
    if (configure_default(info) != return_type::OK) return return_type::ERROR;
    return return_type::OK;
  }
  std::vector<hardware_interface::StateInterface> export_state_interfaces() override {
    std::vector<hardware_interface::StateInterface> out;
    out.emplace_back(hardware_interface::StateInterface(info_.joints[0].name, "position", &value_));
    return out;
  }
  return_type start() override {
    started = true;
    status_ = hardware_interface::status::STARTED;
    return return_type::OK;
  }
  return_type stop() override { return return_type::OK; }
  return_type read() override { return value_ = 3, return_type::OK; }
  return_type write() override { return return_type::OK; }

 private:
  double value_ = 0;
};

PLUGINLIB_EXPORT_CLASS(Unplugged, hardware_interface::SystemInterface)
PLUGINLIB_EXPORT_CLASS(Unjoined, hardware_interface::SystemInterface)
PLUGINLIB_EXPORT_CLASS(OfFoxy, hardware_interface::SystemInterface)

/// The mock of ros2_control with a state more.
class Mocked : public mock_components::GenericSystem {
 public:
  std::vector<hardware_interface::StateInterface::ConstSharedPtr> on_export_state_interfaces() override {
    auto out = GenericSystem::on_export_state_interfaces();
    out.push_back(std::make_shared<hardware_interface::StateInterface>("bench", "cycles", &cycles_));
    return out;
  }
  return_type read(const rclcpp::Time& time, const rclcpp::Duration& period) override {
    ++cycles_;
    return GenericSystem::read(time, period);
  }

 private:
  double cycles_ = 0;
};

PLUGINLIB_EXPORT_CLASS(Mocked, hardware_interface::SystemInterface)

}  // namespace wrapped

PLUGINLIB_EXPORT_CLASS(wrapped::ByHand, hardware_interface::SystemInterface)
PLUGINLIB_EXPORT_CLASS(wrapped::ByDescription, hardware_interface::SystemInterface)

namespace polyarm {
namespace {

using hardware::CallbackReturn;
using hardware::ReturnType;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A robot with two joints, and a block for them.
struct Robot {
  description::RobotModel model;
  hardware::ComponentContext context;
  Robot() {
    description::HardwareInfo block;
    block.name = "bench", block.type = "system", block.plugin = "any/Plugin";
    for (const char* name : {"a", "b"}) {
      description::Joint joint;
      joint.name = name, joint.type = description::JointType::revolute;
      joint.limits.lower = -2, joint.limits.upper = 2, joint.limits.velocity = 3;
      model.joints.push_back(joint);
      description::ComponentInfo component;
      component.name = name, component.kind = "joint";
      description::InterfaceInfo position;
      position.name = "position";
      position.parameters["min"] = "-1.5";
      component.state_interfaces = component.command_interfaces = {position};
      block.components.push_back(component);
    }
    hardware::RobotInstance instance;
    instance.name = "arm", instance.model = &model, instance.hardware = {block};
    context.name = "bench", context.robots = {instance};
    context.parameters["port"] = "/dev/null";
  }
};

struct Wrapper : testing::Test {
  void SetUp() override {
    wrapped::ByHand::throws_in.clear();
    wrapped::ByHand::returns = wrapped::return_type::OK;
    wrapped::ByHand::calls.clear();
  }
  Robot robot;
  polyarm_ros::RosComponent by_hand{"any/ByHand", "wrapped::ByHand", true};
  hardware::Cycle cycle{0, 1'000'000, 0};

  void activate(hardware::Component& component) {
    ASSERT_EQ(component.on_init(robot.context), CallbackReturn::success) << component.reason();
    ASSERT_EQ(component.on_configure(), CallbackReturn::success) << component.reason();
    ASSERT_EQ(component.on_activate(), CallbackReturn::success) << component.reason();
  }
};

TEST_F(Wrapper, PutsTheRobotsNameInFrontOfInterfaces) {
  activate(by_hand);
  ASSERT_EQ(by_hand.state_interfaces().size(), 2u);
  EXPECT_EQ(by_hand.state_interfaces()[1].name, "arm/b/position");
  ASSERT_EQ(by_hand.command_interfaces().size(), 3u);
  EXPECT_EQ(by_hand.command_interfaces()[2].name, "arm/a/velocity");
}

TEST_F(Wrapper, CarriesCommandsInAndStatesOut) {
  activate(by_hand);
  std::vector<double> states(2), commands{0.5, -0.75, kNone};
  EXPECT_EQ(by_hand.write(cycle, commands), ReturnType::ok);
  EXPECT_EQ(by_hand.read(cycle, states), ReturnType::ok);
  EXPECT_EQ(states, (std::vector<double>{0.5, -0.75}));
}

TEST_F(Wrapper, KeepsAPositionThatNobodyCommandsAndZeroesASpeed) {
  activate(by_hand);
  std::vector<double> states(2), commands{0.5, 0.5, 2.0};
  by_hand.write(cycle, commands);
  EXPECT_EQ(wrapped::ByHand::written_speed, 2.0);
  commands = {kNone, kNone, kNone};
  by_hand.write(cycle, commands);
  EXPECT_EQ(wrapped::ByHand::written_speed, 0.0);
  by_hand.read(cycle, states);
  EXPECT_EQ(states, (std::vector<double>{0.5, 0.5}));
}

TEST_F(Wrapper, DescribesTheBlockAsPluginsReadIt) {
  const auto info =
      polyarm_ros::hardware_info(robot.context.robots[0].hardware[0], robot.model, robot.context.parameters);
  EXPECT_EQ(info.hardware_plugin_name, "any/Plugin");
  EXPECT_EQ(info.hardware_parameters.at("port"), "/dev/null");
  EXPECT_EQ(info.joints[1].command_interfaces[0].min, "-1.5");
  EXPECT_EQ(info.limits.at("a").max_position, 2);
  EXPECT_TRUE(info.limits.at("a").has_velocity_limits);
}

TEST_F(Wrapper, TellsThePluginWhichStateItLeaves) {
  activate(by_hand);
  EXPECT_EQ(wrapped::ByHand::calls, std::vector<std::string>{"activate after inactive"});
}

TEST_F(Wrapper, MakesWhatIsThrownInACycleAnErrorWithItsText) {
  activate(by_hand);
  std::vector<double> states(2);
  for (const auto& [where, text] :
       {std::pair{"read", "the cable is cut"}, std::pair{"number", "not a std::exception"}}) {
    wrapped::ByHand::throws_in = where;
    EXPECT_EQ(by_hand.read(cycle, states), ReturnType::error);
    EXPECT_NE(by_hand.reason().find(text), std::string::npos) << by_hand.reason();
  }
}

TEST_F(Wrapper, MakesWhatACallbackThrowsAnError) {
  wrapped::ByHand::throws_in = "activate";
  ASSERT_EQ(by_hand.on_init(robot.context), CallbackReturn::success);
  ASSERT_EQ(by_hand.on_configure(), CallbackReturn::success);
  EXPECT_EQ(by_hand.on_activate(), CallbackReturn::error);
  EXPECT_EQ(by_hand.reason(), "on_activate: the motor is hot");
}

TEST_F(Wrapper, PassesErrorsAndTheWishToBeDeactivated) {
  activate(by_hand);
  std::vector<double> states(2);
  wrapped::ByHand::returns = wrapped::return_type::ERROR;
  EXPECT_EQ(by_hand.read(cycle, states), ReturnType::error);
  wrapped::ByHand::returns = wrapped::return_type::DEACTIVATE;
  EXPECT_EQ(by_hand.read(cycle, states), ReturnType::deactivate);
}

TEST_F(Wrapper, GivesModeSwitchesWithoutTheRobotsName) {
  activate(by_hand);
  const std::vector<std::string> start{"arm/a/velocity", "other/a/velocity", "arm/c/position"};
  EXPECT_EQ(by_hand.prepare_command_mode_switch(start, {}), ReturnType::ok);
  EXPECT_EQ(by_hand.perform_command_mode_switch(start, {}), ReturnType::ok);
  EXPECT_EQ(wrapped::ByHand::started, std::vector<std::string>{"a/velocity"});
}

TEST_F(Wrapper, ExportsByDescriptionWhereThePluginExportsNothing) {
  polyarm_ros::RosComponent component("any/ByDescription", "wrapped::ByDescription", true);
  activate(component);
  ASSERT_EQ(component.state_interfaces().size(), 2u);
  std::vector<double> states(2), commands{kNone, 1.0};
  component.write(cycle, commands);
  component.read(cycle, states);
  EXPECT_EQ(states, (std::vector<double>{0.5, 1.0}));
}

TEST(HardwareStatus, IsPublishedAtItsRateUnderTheNodesNameInLowerCase) {
  for (const std::string rate : {"1000", "0", "often", "no device"}) {
    wrapped::Reporting plugin;
    wrapped::Reporting::devices = rate != "no device";
    hardware_interface::HardwareComponentParams params;
    params.hardware_info.name = "Left/Pump", params.hardware_info.type = "system";
    params.hardware_info.hardware_parameters["status_publish_rate"] = rate == "no device" ? "1000" : rate;
    params.logger = rclcpp::get_logger("test");
    const auto executor = std::make_shared<rclcpp::executors::SingleThreadedExecutor>();
    params.executor = executor;
    control_msgs::msg::HardwareStatus heard;
    const auto node = std::make_shared<rclcpp::Node>("listener");
    const auto subscription = node->create_subscription<control_msgs::msg::HardwareStatus>(
        "/left_pump/hardware_status", 10, [&](const control_msgs::msg::HardwareStatus& m) { heard = m; });
    ASSERT_EQ(plugin.init(params), wrapped::CallbackReturn::SUCCESS);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (rate == "1000" && heard.hardware_id.empty() && std::chrono::steady_clock::now() < end) {
      executor->spin_some();
      rclcpp::spin_some(node);
    }
    executor->spin_some();
    rclcpp::spin_some(node);
    ASSERT_EQ(heard.hardware_device_states.size(), rate == "1000" ? 1u : 0u) << rate;
    if (rate != "1000") continue;
    EXPECT_EQ(heard.hardware_device_states[0].device_id, "pump");
    EXPECT_EQ(heard.hardware_id.find("kept"), std::string::npos) << "each begins as it was set up";
    EXPECT_GT(heard.header.stamp.sec, 0);
  }
}

TEST_F(Wrapper, OutlivesAPluginWhoseDestructorThrows) {
  for (int i = 1; i <= 2; ++i) {
    {
      polyarm_ros::RosComponent component("any/Unplugged", "wrapped::Unplugged", true);
      ASSERT_EQ(component.on_init(robot.context), CallbackReturn::success);
      EXPECT_EQ(component.on_configure(), CallbackReturn::error);
    }
    EXPECT_EQ(wrapped::Port::closed, i);
  }
}

TEST_F(Wrapper, SaysThatADestructorTerminatedWithoutAnException) {
  ::testing::internal::CaptureStderr();
  {
    polyarm_ros::RosComponent component("any/Unjoined", "wrapped::Unjoined", true);
    ASSERT_EQ(component.on_init(robot.context), CallbackReturn::success);
  }
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("it called std::terminate"), std::string::npos) << log;
  EXPECT_EQ(log.find("threw"), std::string::npos) << log;
}

TEST_F(Wrapper, RunsAPluginOfFoxy) {
  polyarm_ros::RosComponent component("any/OfFoxy", "wrapped::OfFoxy", true);
  activate(component);
  EXPECT_TRUE(wrapped::OfFoxy::started);
  std::vector<double> states(1);
  EXPECT_EQ(component.read(cycle, states), ReturnType::ok);
  EXPECT_EQ(states[0], 3);
}

TEST_F(Wrapper, RunsAPluginThatDerivesFromTheMockOfRos) {
  polyarm_ros::RosComponent component("any/Mocked", "wrapped::Mocked", true);
  activate(component);
  std::vector<std::string> names;
  for (const auto& each : component.state_interfaces()) names.push_back(each.name);
  const auto commanded = component.command_interfaces();
  std::vector<double> states(names.size()), commands(commanded.size(), kNone);
  const auto state = [&](const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), "arm/" + name);
    return at == names.end() ? kNone : states[static_cast<std::size_t>(at - names.begin())];
  };
  for (std::size_t i = 0; i < commanded.size(); ++i)
    if (commanded[i].name == "arm/a/position") commands[i] = 0.7;
  EXPECT_EQ(component.write(cycle, commands), ReturnType::ok);
  EXPECT_EQ(component.read(cycle, states), ReturnType::ok);
  EXPECT_EQ(state("a/position"), 0.7) << ::testing::PrintToString(names);
  EXPECT_EQ(state("b/position"), 0) << ::testing::PrintToString(names);
  EXPECT_EQ(state("bench/cycles"), 1);
}

TEST_F(Wrapper, RefusesAClassThatIsNotExported) {
  EXPECT_THROW(polyarm_ros::RosComponent("any/Nothing", "wrapped::Nothing", true), std::runtime_error);
}

TEST_F(Wrapper, IsRealUnlessItWasBuiltAsSimulated) {
  EXPECT_FALSE(by_hand.real());
  EXPECT_TRUE(polyarm_ros::RosComponent("any/ByHand", "wrapped::ByHand", false).real());
}

TEST_F(Wrapper, NeitherAllocatesNorLocksInACycle) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "a sanitizer watches the allocations";
  polyarm_ros::RosComponent described("any/ByDescription", "wrapped::ByDescription", true);
  activate(by_hand);
  std::vector<double> states(2), commands{0.1, 0.2, 0.3};
  std::string violations;
  {
    const test::RealtimeGuard guard;
    for (int i = 0; i < 1000; ++i) {
      by_hand.read(cycle, states);
      by_hand.write(cycle, commands);
    }
    violations = guard.violations();
  }
  EXPECT_EQ(violations, "");
}

TEST_F(Wrapper, LogsInACycleWithoutWaiting) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "a sanitizer watches the allocations";
  const rclcpp::Logger logger = rclcpp::get_logger("loop");
  std::string violations;
  polyarm_ros::in_cycle() = true;
  {
    const test::RealtimeGuard guard;
    RCLCPP_INFO(logger, "cycle %d", 3);
    violations = guard.violations();
  }
  polyarm_ros::in_cycle() = false;
  EXPECT_EQ(violations, "");
}

}  // namespace
}  // namespace polyarm
