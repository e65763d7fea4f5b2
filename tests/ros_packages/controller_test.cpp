/// The wrapper that makes a controller of ros2_control one of Polyarm: its numbers, parameters, messages, stops.
#include "polyarm_ros/controller.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "controller_interface/test_utils.hpp"
#include "polyarm/controllers/controller_rig.hpp"
#include "std_msgs/msg/string.hpp"
#include "tests/ros_packages/two_joints/src/scale.cpp"
#include "tests/support/realtime_guard.hpp"
#include "urdf/model.hpp"

namespace wrapped_controllers {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;
using controller_interface::return_type;

/// Moves a position or turns a velocity; what it does is up to the test.
class Mover : public controller_interface::ControllerInterface {
 public:
  static inline std::string interface = "position";
  static inline bool throws = false;
  static inline int activations = 0;
  CallbackReturn on_init() override {
    return auto_declare<double>("speed", 0.5) > 0 ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
  }
  InterfaceConfiguration command_interface_configuration() const override {
    return {interface_configuration_type::INDIVIDUAL, {"elbow/" + interface}};
  }
  InterfaceConfiguration state_interface_configuration() const override {
    return {interface_configuration_type::INDIVIDUAL, {"elbow/position"}};
  }
  CallbackReturn on_activate(const rclcpp_lifecycle::State&) override {
    ++activations;
    at_ = state_interfaces_[0].get_value();
    turns_ = interface == "velocity";
    return CallbackReturn::SUCCESS;
  }
  return_type update(const rclcpp::Time&, const rclcpp::Duration& period) override {
    if (throws) throw std::runtime_error("the spring is broken");
    at_ += 0.5 * period.seconds();
    command_interfaces_[0].set_value(turns_ ? (activations == 1 ? 0.5 : 0.0) : at_);
    return return_type::OK;
  }

 private:
  double at_ = 0;
  bool turns_ = false;
};

/// Measures how old the last message is.
class Listening : public controller_interface::ControllerInterface {
 public:
  static inline double age = 0;  ///< s
  CallbackReturn on_init() override { return CallbackReturn::SUCCESS; }
  InterfaceConfiguration command_interface_configuration() const override {
    return {interface_configuration_type::INDIVIDUAL, {"elbow/velocity"}};
  }
  InterfaceConfiguration state_interface_configuration() const override {
    return {interface_configuration_type::NONE, {}};
  }
  CallbackReturn on_configure(const rclcpp_lifecycle::State&) override {
    subscription_ = get_node()->create_subscription<geometry_msgs::msg::TwistStamped>(
        "~/cmd_vel", rclcpp::QoS(1), [this](const geometry_msgs::msg::TwistStamped& m) { stamp_ = m.header.stamp; });
    return CallbackReturn::SUCCESS;
  }
  return_type update(const rclcpp::Time& time, const rclcpp::Duration&) override {
    age = (time - rclcpp::Time(stamp_, RCL_ROS_TIME)).seconds();
    command_interfaces_[0].set_value(0.5);
    return return_type::OK;
  }

 private:
  builtin_interfaces::msg::Time stamp_;
  rclcpp::Subscription<geometry_msgs::msg::TwistStamped>::SharedPtr subscription_;
};

/// Sleeps in the callback of its subscription.
class Dozing : public controller_interface::ControllerInterface {
 public:
  static inline int called = 0, sleep_ms = 0;
  CallbackReturn on_init() override { return CallbackReturn::SUCCESS; }
  InterfaceConfiguration command_interface_configuration() const override {
    return {interface_configuration_type::INDIVIDUAL, {"elbow/position"}};
  }
  InterfaceConfiguration state_interface_configuration() const override {
    return {interface_configuration_type::NONE, {}};
  }
  CallbackReturn on_configure(const rclcpp_lifecycle::State&) override {
    publisher_ = get_node()->create_publisher<std_msgs::msg::String>("~/words", 10);
    subscription_ = get_node()->create_subscription<std_msgs::msg::String>(
        "~/words", rclcpp::QoS(10), [](const std_msgs::msg::String&) {
          ++called;
          std::this_thread::sleep_for(std::chrono::milliseconds(sleep_ms));
        });
    for (int i = 0; i < 4; ++i) publisher_->publish(std_msgs::msg::String());
    return CallbackReturn::SUCCESS;
  }
  return_type update(const rclcpp::Time&, const rclcpp::Duration&) override { return return_type::OK; }

 private:
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr publisher_;
  rclcpp::Subscription<std_msgs::msg::String>::SharedPtr subscription_;
};

/// Takes a reference from others and exports a state.
class Follower : public controller_interface::ChainableControllerInterface {
 public:
  CallbackReturn on_init() override { return CallbackReturn::SUCCESS; }
  InterfaceConfiguration command_interface_configuration() const override {
    return {interface_configuration_type::ALL, {}};
  }
  InterfaceConfiguration state_interface_configuration() const override {
    return {interface_configuration_type::NONE, {}};
  }

 protected:
  std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() override {
    exported_reference_interface_names_ = {"elbow/position"};
    return ChainableControllerInterface::on_export_reference_interfaces();
  }
  std::vector<hardware_interface::StateInterface> on_export_state_interfaces() override {
    exported_state_interface_names_ = {"twice"};
    return ChainableControllerInterface::on_export_state_interfaces();
  }
  return_type update_reference_from_subscribers(const rclcpp::Time&, const rclcpp::Duration&) override {
    reference_interfaces_[0] = 0.125;
    return return_type::OK;
  }
  return_type update_and_write_commands(const rclcpp::Time&, const rclcpp::Duration&) override {
    state_interfaces_values_[0] = 2 * reference_interfaces_[0];
    command_interfaces_[0].set_value(reference_interfaces_[0]);
    return return_type::OK;
  }
};

/// Code of Foxy takes a controller's node for a plain one.
double offset_of(const rclcpp::Node::SharedPtr& node) {
  return node->get_parameter("offset").as_double();
}

/// Written for Galactic and Foxy: init with a name, the node as a member, update without a time.
class Early : public controller_interface::ControllerInterface {
 public:
  static inline std::string description;
  return_type init(const std::string& name) override {
    if (const auto result = ControllerInterface::init(name); result != return_type::SUCCESS) return result;
    node_->declare_parameter<double>("speed", 0.5);
    return return_type::SUCCESS;
  }
  /// In Humble what the file gives is declared without a word.
  CallbackReturn on_configure(const rclcpp_lifecycle::State&) override {
    std::map<std::string, rclcpp::Parameter> gains;
    const bool whole = node_->has_parameter("offset") && !node_->has_parameter("other") &&
                       node_->get_parameters("gains", gains) && gains.size() == 2;
    description = node_->get_parameter("robot_description").as_string();
    const std::shared_ptr<rclcpp::Node> node = get_node();
    if (node->shared_from_this() != node_ || node_->shared_from_this() != node_) return CallbackReturn::ERROR;
    publisher_ = node->create_publisher<std_msgs::msg::String>("~/word", 1);
    if (whole) offset_ = offset_of(node_) + gains.at("b").as_double();
    return whole ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
  }
  InterfaceConfiguration command_interface_configuration() const override {
    return {interface_configuration_type::INDIVIDUAL, {"elbow/position"}};
  }
  InterfaceConfiguration state_interface_configuration() const override {
    return {interface_configuration_type::NONE, {}};
  }
  return_type update() override {
    command_interfaces_[0].set_value(node_->get_parameter("speed").as_double() + offset_);
    return return_type::SUCCESS;
  }

 private:
  double offset_ = 0;
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr publisher_;
};

}  // namespace wrapped_controllers

PLUGINLIB_EXPORT_CLASS(wrapped_controllers::Early, controller_interface::ControllerInterface)
PLUGINLIB_EXPORT_CLASS(wrapped_controllers::Mover, controller_interface::ControllerInterface)
PLUGINLIB_EXPORT_CLASS(wrapped_controllers::Listening, controller_interface::ControllerInterface)
PLUGINLIB_EXPORT_CLASS(wrapped_controllers::Dozing, controller_interface::ControllerInterface)
PLUGINLIB_EXPORT_CLASS(wrapped_controllers::Follower, controller_interface::ChainableControllerInterface)

namespace polyarm_ros {
namespace {

using polyarm::controllers::ControllerRig;
using polyarm::controllers::Numbers;
using wrapped_controllers::Mover;
using Return = polyarm::controllers::ReturnType;

ControllerRig rig(const char* type, const ControllerRig::Values& values = {}) {
  Mover::interface = "position", Mover::throws = false, Mover::activations = 0;
  return ControllerRig(std::make_unique<RosController>(type), {"elbow"}, values);
}

TEST(RosController, CommandsOfAMessageGoThroughItsParameters) {
  ControllerRig arm(std::make_unique<RosController>("two_joints::Scale"), {"elbow", "wrist"},
                    {{"joints", {"elbow", "wrist"}}, {"gain", {"2"}}, {"offsets.wrist.value", {"0.25"}}});
  ASSERT_TRUE(arm.start());
  EXPECT_EQ(arm.update(), Return::ok);
  EXPECT_TRUE(std::isnan(arm.command("elbow/position")));  // it has written nothing yet
  ASSERT_EQ(arm.controller().inputs().size(), 1u);
  EXPECT_EQ(arm.controller().inputs()[0].name, "commands");
  arm.controller().receive("commands", Numbers{{0.5, -0.5}}, false);
  arm.update();
  EXPECT_EQ(arm.command("elbow/position"), 1.0);
  EXPECT_EQ(arm.command("wrist/position"), -0.75);

  arm.change("gain", "3");
  arm.update();
  EXPECT_EQ(arm.command("elbow/position"), 1.5);
  try {
    arm.change("gain", "-1");
    ADD_FAILURE() << "the controller's own rule is not asked";
  } catch (const polyarm::Error& e) {
    EXPECT_NE(std::string(e.what()).find("gain"), std::string::npos) << e.what();
  }
  arm.update();
  EXPECT_EQ(arm.command("elbow/position"), 1.5);
}

TEST(RosController, OneOfAnEarlyReleaseInitializesAndUpdatesInItsOwnForm) {
  ControllerRig arm = rig("wrapped_controllers::Early", {{"speed", {"0.75"}},
                                                         {"offset", {"0.125"}},
                                                         {"gains.a", {"1.5"}},
                                                         {"gains.b", {"0.25"}},
                                                         {"lost", {"1"}}});
  ASSERT_TRUE(arm.start());
  EXPECT_EQ(arm.update(), Return::ok);
  EXPECT_EQ(arm.command("elbow/position"), 1.125);
  const auto& problems = arm.context().parameters.problems().list();  // values that nobody read
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].text().find("'lost'"), std::string::npos) << problems[0].text();
}

/// In ROS the launch file gives it to every node of the controller manager's process.
TEST(RosController, ItsNodeHasTheDescriptionOfItsRobotAsAParameter) {
  polyarm::description::RobotModel robot;
  robot.name = "pump";
  robot.links = {{.name = "base"}};
  for (const bool own : {false, true}) {
    auto controller = std::make_unique<RosController>("wrapped_controllers::Early");
    controller->set_models({{"arm", &robot}});
    ControllerRig::Values values{{"offset", {"0"}}, {"gains.a", {"1.5"}}, {"gains.b", {"0.25"}}};
    if (own) values["robot_description"] = {"<robot name=\"other\"/>"};
    ControllerRig arm(std::move(controller), {"elbow"}, values);
    ASSERT_TRUE(arm.start());
    EXPECT_NE(wrapped_controllers::Early::description.find(own ? "other" : "pump"), std::string::npos);
    for (const auto& each : arm.context().parameters.declared()) EXPECT_NE(each.key, "robot_description");
  }
}

/// Its tests in ROS compare these words.
TEST(RosController, AnErrorOfATransitionIsInTheWordsOfRos) {
  class Broken : public Mover {
    wrapped_controllers::CallbackReturn on_configure(const rclcpp_lifecycle::State&) override {
      return wrapped_controllers::CallbackReturn::ERROR;
    }
    wrapped_controllers::CallbackReturn on_error(const rclcpp_lifecycle::State&) override {
      return wrapped_controllers::CallbackReturn::FAILURE;
    }
  };
  const auto broken = std::make_unique<Broken>();
  ci::ControllerInterfaceParams params;
  params.controller_name = "broken";
  ASSERT_EQ(broken->init(params), ci::return_type::OK);
  try {
    controller_interface::configure_succeeds(broken);
    FAIL() << "it does not throw";
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(), "Unexpected controller state in configure_succeeds: 4");
  }
}

TEST(RosController, ParametersThatWereNeverReadAreOld) {
  const auto node = std::make_shared<rclcpp_lifecycle::LifecycleNode>(
      "scale", rclcpp::NodeOptions().append_parameter_override("joints", std::vector<std::string>{"elbow"}));
  two_joints::ParamListener listener(node);
  two_joints::Params params;
  EXPECT_TRUE(listener.is_old(params));
  EXPECT_TRUE(listener.try_update_params(params));
  EXPECT_FALSE(listener.is_old(params));
  EXPECT_EQ(params.joints, std::vector<std::string>{"elbow"});
}

TEST(RosController, ParametersThatItsRulesRefuseEndTheConfiguration) {
  for (const auto& values : {ControllerRig::Values{{"joints", {"elbow", "elbow"}}},
                             ControllerRig::Values{{"joints", {"elbow"}}, {"mode", {"cubed"}}},
                             ControllerRig::Values{}}) {
    ControllerRig arm = rig("two_joints::Scale", values);
    EXPECT_THROW(arm.configure(), polyarm::Error);
  }
}

TEST(RosController, AStopSlowsItsTimeSoThatItStaysOnItsPath) {
  ControllerRig arm = rig("wrapped_controllers::Mover");
  ASSERT_TRUE(arm.start());
  for (int i = 0; i < 100; ++i) arm.update();
  double before = arm.command("elbow/position"), step = 0.0005;
  EXPECT_NEAR(before, 0.05, 1e-9);
  arm.verdict.speed = 0;
  int cycles = 0;
  for (; cycles < 5000 && (cycles < 3 || !arm.controller().standing()); ++cycles) {
    arm.update();
    const double now = arm.command("elbow/position");
    EXPECT_LE(now - before, step + 1e-9);  // slower and slower, never back
    EXPECT_GE(now - before, -1e-12);
    step = now - before;
    before = now;
  }
  EXPECT_GT(cycles, 10);
  EXPECT_LT(cycles, 5000);
  for (int i = 0; i < 100; ++i) arm.update();
  EXPECT_EQ(arm.command("elbow/position"), before);
  arm.verdict.speed = 1;  // it goes on where it was
  arm.update();
  EXPECT_NEAR(arm.command("elbow/position"), before, 0.0005);
  for (int i = 0; i < 3000; ++i) arm.update();
  EXPECT_GT(arm.command("elbow/position"), before + 0.5);
  EXPECT_EQ(Mover::activations, 1);
}

TEST(RosController, ACutBrakesTheJointAndItStartsAgainFromThere) {
  ControllerRig arm = rig("wrapped_controllers::Mover");
  ASSERT_TRUE(arm.start());
  for (int i = 0; i < 10; ++i) arm.update();
  arm.verdict.speed = 0, arm.verdict.cut = true;
  for (int i = 0; i < 1000; ++i) arm.update();
  EXPECT_TRUE(arm.controller().standing());
  arm.state("elbow/position") = arm.command("elbow/position");
  const double held = arm.command("elbow/position");
  arm.verdict = {};
  arm.update();
  EXPECT_EQ(Mover::activations, 2);
  EXPECT_NEAR(arm.command("elbow/position"), held, 0.0005);
}

TEST(RosController, AVelocityIsBrakedToZeroAndDoesNotReturn) {
  ControllerRig arm = rig("wrapped_controllers::Mover");
  Mover::interface = "velocity";
  arm.offer("elbow/velocity");
  ASSERT_TRUE(arm.start());
  arm.update();
  EXPECT_EQ(arm.command("elbow/velocity"), 0.5);
  arm.verdict.speed = 0;
  arm.update();
  EXPECT_LT(arm.command("elbow/velocity"), 0.5);
  EXPECT_GT(arm.command("elbow/velocity"), 0.4);
  for (int i = 0; i < 1000; ++i) arm.update();
  EXPECT_EQ(arm.command("elbow/velocity"), 0);
  arm.verdict.speed = 1;
  for (int i = 0; i < 100; ++i) arm.update();
  EXPECT_EQ(arm.command("elbow/velocity"), 0);  // the controller was activated again
}

TEST(RosController, AStampOfNowIsNowAfterSlowedTimeAndAfterAStop) {
  ControllerRig arm = rig("wrapped_controllers::Listening");
  arm.offer("elbow/velocity");
  ASSERT_TRUE(arm.start());
  const auto age = [&] {
    polyarm::controllers::Twist twist;
    twist.stamp = arm.time();
    arm.controller().receive("cmd_vel", twist, false);
    arm.update();
    return wrapped_controllers::Listening::age;
  };
  arm.verdict.speed = 0.5;
  for (int i = 0; i < 2000; ++i) arm.update();
  EXPECT_NEAR(age(), 0, 0.002) << "a watchdog of commands would never end";
  arm.verdict.speed = 0;
  for (int i = 0; i < 2000; ++i) arm.update();
  arm.verdict.speed = 1;
  arm.update();
  EXPECT_NEAR(age(), 0, 0.002);
}

TEST(RobotText, IsReadBackByTheModelOfUrdf) {
  polyarm::description::RobotModel robot;
  robot.name = "one & two";
  robot.links = {{.name = "base"}, {.name = "arm"}};
  polyarm::description::Joint joint;
  joint.name = "elbow", joint.type = polyarm::description::JointType::revolute;
  joint.parent_link = 0, joint.child_link = 1;
  joint.origin.position = {0.5, 0, 1};
  joint.axis = {0, 0, 1};
  joint.limits.lower = -1.5, joint.limits.upper = 2, joint.limits.velocity = 3;
  robot.joints = {joint};
  polyarm::description::Shape wheel;
  wheel.kind = polyarm::description::ShapeKind::cylinder;
  wheel.radius = 0.25, wheel.length = 0.1;
  robot.links[1].collisions = {wheel};
  urdf::Model model;
  ASSERT_TRUE(model.initString(robot_text(robot)));
  EXPECT_EQ(model.getRoot()->name, "base");
  const auto read = model.getJoint("elbow");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->type, urdf::Joint::REVOLUTE);
  EXPECT_FALSE(model.getLink("base")->collision);
  const auto shape = model.getLink(read->child_link_name)->collision;
  ASSERT_TRUE(shape);
  EXPECT_EQ(std::dynamic_pointer_cast<urdf::Cylinder>(shape->geometry)->radius, 0.25);
  EXPECT_EQ(read->limits->upper, 2);
  EXPECT_EQ(read->axis.z, 1);
  EXPECT_EQ(read->parent_to_joint_origin_transform.position.x, 0.5);
  EXPECT_FALSE(urdf::Model().initString("<robot><link name='a'/>"));
  EXPECT_FALSE(urdf::Model().initString("no robot"));
}

TEST(RosController, RequestsAfterItsCleanupAreRefused) {
  ControllerRig arm(std::make_unique<RosController>("two_joints::Scale"), {"elbow"},
                    {{"joints", {"elbow"}}, {"gain", {"2"}}});
  ASSERT_TRUE(arm.start());
  arm.deactivate();
  arm.cleanup();
  EXPECT_FALSE(arm.controller().cancel(1));
  EXPECT_THROW(arm.change("gain", "3"), polyarm::Error);
  EXPECT_THROW(arm.controller().receive("commands", Numbers{{0.5}}, false), polyarm::Error);
}

TEST(RosController, WhatItThrowsIsAnError) {
  ControllerRig arm = rig("wrapped_controllers::Mover");
  ASSERT_TRUE(arm.start());
  Mover::throws = true;
  EXPECT_EQ(arm.update(), Return::error);
}

/// The cell waits for these callbacks: after one that takes long, the next one waits for the next tick.
TEST(RosController, CallbacksShareTheCellsThreadAndSlowOnesAreNamed) {
  wrapped_controllers::Dozing::called = 0, wrapped_controllers::Dozing::sleep_ms = 120;
  ControllerRig arm = rig("wrapped_controllers::Dozing");
  ASSERT_TRUE(arm.start());
  const int before = wrapped_controllers::Dozing::called;
  ::testing::internal::CaptureStderr();
  arm.controller().next_goal_event();
  EXPECT_EQ(wrapped_controllers::Dozing::called, before + 1);
  arm.controller().next_goal_event();
  EXPECT_EQ(wrapped_controllers::Dozing::called, before + 2);
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("its subscription '~/words' took "), std::string::npos) << log;
}

TEST(CallWatch, NamesACallThatDoesNotReturn) {
  CallWatch watch;
  ::testing::internal::CaptureStderr();
  CallWatch::Call* const call = watch.begin("arm_driver", "service", "/arm_driver/reset");
  ASSERT_TRUE(call);
  watch.look();
  std::this_thread::sleep_for(std::chrono::nanoseconds(CallWatch::kStuck));
  watch.look();
  watch.look();
  watch.end(*call);
  const std::string log = ::testing::internal::GetCapturedStderr();
  const auto first = log.find("[arm_driver]: its service '/arm_driver/reset' has not returned");
  ASSERT_NE(first, std::string::npos) << log;
  EXPECT_EQ(log.find("has not returned", first + 60), std::string::npos) << "once: " << log;
}

TEST(RosController, ReferencesAndStatesOfAChainAreNamedAfterIt) {
  ControllerRig arm = rig("wrapped_controllers::Follower");
  ASSERT_TRUE(arm.start());
  EXPECT_EQ(arm.controller().reference_interfaces(), std::vector<std::string>{"tested/elbow/position"});
  EXPECT_EQ(arm.controller().exported_states(), std::vector<std::string>{"tested/twice"});
  EXPECT_EQ(arm.controller().command_interfaces(), std::vector<std::string>{"arm/elbow/position"});
  arm.update();
  EXPECT_EQ(arm.command("elbow/position"), 0.125);
}

TEST(RosController, AChainedControllerFollowsItsReferenceThroughAStop) {
  ControllerRig arm = rig("wrapped_controllers::Follower");
  ASSERT_TRUE(arm.start());
  arm.controller().set_chained(true);
  arm.command("tested/elbow/position") = 0.5;
  arm.verdict.speed = 0;
  arm.update();
  EXPECT_EQ(arm.command("elbow/position"), 0.5);
  EXPECT_EQ(arm.state("tested/twice"), 1.0);
  arm.command("tested/elbow/position") = 0.75;
  arm.update();
  EXPECT_EQ(arm.command("elbow/position"), 0.75);
}

TEST(RosController, TheWrapperAllocatesNothingInACycle) {
  if (!polyarm::test::RealtimeGuard::watches()) GTEST_SKIP() << "a sanitizer watches the allocations";
  ControllerRig arm = rig("wrapped_controllers::Mover");
  ASSERT_TRUE(arm.start());
  for (int i = 0; i < 10; ++i) arm.update();
  std::string violations;
  {
    const polyarm::test::RealtimeGuard guard;
    for (int i = 0; i < 5000; ++i) {  // a stop on the path, and on again
      arm.verdict.speed = i < 300 || i > 3000 ? 1 : 0;
      arm.update();
    }
    violations = guard.violations();
  }
  EXPECT_EQ(violations, "");
}

}  // namespace
}  // namespace polyarm_ros
