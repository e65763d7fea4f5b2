#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "tests/ros_files/controllers_texts.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::ros_files::controllers_texts {
namespace {

using test::Folder;

TEST(Ros2Controllers, ManagerAndBlocksOfHumbleAreRead) {
  const auto [file, problems] = read(kHumble);
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.update_rate, 250);
  ASSERT_EQ(file.controllers.size(), 2u);
  EXPECT_EQ(file.controllers[0].name, "joint_state_broadcaster");
  const ControllerEntry& arm = file.controllers[1];
  EXPECT_EQ(arm.type, "joint_trajectory_controller/JointTrajectoryController");
  EXPECT_EQ(arm.ns, "/");
  EXPECT_FALSE(arm.ros1);
  EXPECT_EQ(arm.where.line, 9);
  EXPECT_EQ(text_of(arm, "joints"), "shoulder,elbow");
  EXPECT_TRUE(arm.parameters.entries.at("joints").list);
  EXPECT_EQ(arm.parameters.number("constraints.shoulder.goal", 0), 0.1);
  EXPECT_EQ(arm.parameters.number("constraints.elbow.goal", 0), 0.05);
  EXPECT_EQ(arm.parameters.entries.at("constraints.elbow.goal").where.line, 21);
}

TEST(Ros2Controllers, EveryWayToWriteTheNodesNameMeansTheSame) {
  const std::string manager = "  ros__parameters: {update_rate: 50, jtc: {type: a/B}}\n";
  for (const char* name : {"controller_manager", "/controller_manager", "/**/controller_manager",
                           "\"/*controller_manager\"", "/**"})
    for (const char* block : {"jtc", "/jtc", "/**/jtc", "/**", "'**'"}) {
      if (std::string(name) == "\"/*controller_manager\"") continue;
      const auto [file, problems] =
          read(name + std::string(":\n") + manager + (std::string(name) == block ? "/**/jtc" : block) +
               ":\n  ros__parameters: {joints: [a]}\n");
      EXPECT_EQ(all(problems), "") << name << " " << block;
      EXPECT_EQ(file.update_rate, 50) << name;
      ASSERT_EQ(file.controllers.size(), 1u) << name << " " << block;
      EXPECT_EQ(text_of(file.controllers[0], "joints"), "a") << name << " " << block;
    }
}

TEST(Ros2Controllers, WildcardsMayHoldNodesOfTheirOwn) {
  const auto [file, problems] = read(R"(/**:
  controller_manager:
    ros__parameters: {update_rate: 20, jtc.type: a/B}
  jtc:
    ros__parameters: {joints: [a, b]}
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.update_rate, 20);
  EXPECT_EQ(text_of(file.controllers.at(0), "joints"), "a,b");
}

TEST(Ros2Controllers, NamespacesSeparateTwoArms) {
  for (const char* text : {R"(/left/controller_manager:
  ros__parameters: {update_rate: 125, jtc: {type: a/B}}
/right/controller_manager:
  ros__parameters: {update_rate: 125, jtc: {type: a/B}}
/left/jtc: {ros__parameters: {joints: [l1]}}
/right/jtc: {ros__parameters: {joints: [r1]}}
)",
                           R"(left:
  controller_manager:
    ros__parameters: {update_rate: 125, jtc: {type: a/B}}
  jtc: {ros__parameters: {joints: [l1]}}
right:
  controller_manager:
    ros__parameters: {update_rate: 125, jtc: {type: a/B}}
  jtc: {ros__parameters: {joints: [r1]}}
)"}) {
    const auto [file, problems] = read(text);
    EXPECT_EQ(all(problems), "");
    ASSERT_EQ(file.controllers.size(), 2u);
    EXPECT_EQ(text_of(find(file, "/left/jtc"), "joints"), "l1");
    EXPECT_EQ(text_of(find(file, "/right/jtc"), "joints"), "r1");
    EXPECT_EQ(file.manager.ns, "/left");
  }
}

TEST(Ros2Controllers, AManagerOfAnyNamespaceIsWhereItsControllersAre) {
  const auto [file, problems] =
      read(R"(/**/controller_manager: {ros__parameters: {update_rate: 10, jsb: {type: a/S}}}
/**/fwd: {ros__parameters: {type: a/F, interface_name: position}}
/one/fwd: {ros__parameters: {joints: [a]}}
/two/fwd: {ros__parameters: {joints: [b]}}
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.controllers.size(), 4u);
  EXPECT_EQ(text_of(find(file, "/one/fwd"), "joints"), "a");
  EXPECT_EQ(text_of(find(file, "/two/fwd"), "joints"), "b");
  EXPECT_EQ(text_of(find(file, "/two/fwd"), "interface_name"), "position");
  EXPECT_EQ(find(file, "/two/jsb").type, "a/S");
}

TEST(Ros2Controllers, MapsInListsStandDirectlyBelowTheName) {
  const auto [file, problems] = read(R"(gpio_controller:
  ros__parameters:
    type: gpio_controllers/GpioCommandController
    gpios: [io, vacuum]
    command_interfaces:
      io:
        - interfaces:
          - analog_output1
          - analog_output2
      vacuum: [{interfaces: [pump]}]
)");
  EXPECT_EQ(all(problems), "");
  const ControllerEntry& gpio = file.controllers.at(0);
  EXPECT_EQ(text_of(gpio, "command_interfaces.io.interfaces"), "analog_output1,analog_output2");
  EXPECT_EQ(text_of(gpio, "command_interfaces.vacuum.interfaces"), "pump");
  EXPECT_FALSE(gpio.parameters.entries.contains("command_interfaces.io"));
}

TEST(Ros2Controllers, OneRateIsTakenWhereTwoManagersDiffer) {
  const Problem problem = only(R"(/left/controller_manager:
  ros__parameters: {update_rate: 125, a: {type: a/B}}
/right/controller_manager:
  ros__parameters: {update_rate: 500, a: {type: a/B}}
)");
  EXPECT_EQ(problem.code, "several-rates");
  EXPECT_EQ(problem.where.line, 4);
}

TEST(Ros2Controllers, LaterLinesWinWhateverTheirWildcards) {
  const auto [file, problems] = read(R"(controller_manager: {ros__parameters: {jtc: {type: a/B}}}
/**: {ros__parameters: {x: 1, y: 1, use_sim_time: true}}
jtc: {ros__parameters: {x: 2, z: 2}}
/**/jtc: {ros__parameters: {z: 3}}
)");
  EXPECT_EQ(all(problems), "");
  const ControllerEntry& jtc = file.controllers.at(0);
  EXPECT_EQ(text_of(jtc, "x"), "2");
  EXPECT_EQ(text_of(jtc, "y"), "1");
  EXPECT_EQ(text_of(jtc, "z"), "3");
  EXPECT_FALSE(jtc.parameters.has("use_sim_time"));
}

TEST(Ros2Controllers, TheTypeMayStandInTheControllersOwnBlock) {
  const auto [file, problems] = read(
      "controller_manager: {ros__parameters: {update_rate: 10}}\n"
      "fwd: {ros__parameters: {type: f/F, joints: [a]}}\n");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.controllers.at(0).type, "f/F");
  EXPECT_FALSE(file.controllers[0].parameters.has("type"));
  EXPECT_EQ(read("fwd: {ros__parameters: {type: f/F}}").file.controllers.at(0).name, "fwd");
}

TEST(Ros2Controllers, ParametersOfOtherNodesAreNotedAndPassedOver) {
  const auto [file, problems] = read(
      "controller_manager: {ros__parameters: {jtc: {type: a/B}}}\n"
      "robot_state_publisher: {ros__parameters: {publish_frequency: 15.0}}\n");
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(file.unused.size(), 1u);
  EXPECT_EQ(file.unused[0].key, "/robot_state_publisher");
}

TEST(Ros2Controllers, MergeKeysAndAliasesAreFollowed) {
  const auto [file, problems] =
      read(R"(controller_manager: {ros__parameters: {a: {type: t/A}, b: {type: t/A}}}
a: {ros__parameters: &base {joints: [j], p: 1}}
b:
  ros__parameters:
    <<: *base
    p: 2
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(text_of(find(file, "/b"), "joints"), "j");
  EXPECT_EQ(text_of(find(file, "/b"), "p"), "2");
}

TEST(Ros2Controllers, WhatRunsBesideTheCycleIsRead) {
  const auto [file, problems] = read(R"(controller_manager:
  ros__parameters:
    jtc: {type: a/B, fallback_controllers: [hold]}
    hold: {type: a/C}
jtc:
  ros__parameters:
    update_rate: 20
    is_async: true
    async_parameters: {thread_priority: 40, cpu_affinity: [2, 4], scheduling_policy: detached, print_warnings: false}
)");
  EXPECT_EQ(all(problems), "");
  const ControllerEntry& jtc = find(file, "/jtc");
  EXPECT_EQ(jtc.update_rate, 20);
  EXPECT_TRUE(jtc.is_async);
  EXPECT_EQ(jtc.async.thread_priority, 40);
  EXPECT_EQ(jtc.async.cpu_affinity, (std::vector<double>{2, 4}));
  EXPECT_EQ(jtc.async.scheduling_policy, "detached");
  EXPECT_FALSE(jtc.async.print_warnings);
  EXPECT_EQ(jtc.fallback_controllers, std::vector<std::string>{"hold"});
  EXPECT_TRUE(jtc.parameters.entries.empty());
}

TEST(Ros2Controllers, EveryParameterOfTheManagerIsRead) {
  const auto [file, problems] = read(R"(controller_manager:
  ros__parameters:
    update_rate: 500
    enforce_command_limits: false
    handle_exceptions: false
    hardware_components_initial_state:
      unconfigured: [arm]
      inactive: [gripper, "lift"]
      shutdown_on_initial_state_failure: true
    defaults:
      switch_controller.strictness: best_effort
      allow_controller_activation_with_inactive_hardware: true
      deactivate_controllers_on_hardware_self_deactivate: false
    overruns: {print_warnings: false, manage: false}
    thread_priority: 60
    cpu_affinity: 3
    lock_memory: true
    use_sim_time: false
    hardware_synchronization: {expect_blocking_read_write: true, minimum_cycle_time: 0.0002}
    diagnostics.threshold.controller_manager.periodicity.mean_error: {warn: 5.0, error: 10.0}
    jtc: {type: a/B}
)");
  std::vector<std::string> without_effect;
  for (const Problem& problem : problems.list()) {
    EXPECT_EQ(problem.code, "no-effect") << problem.what;
    without_effect.push_back(problem.what.substr(1, problem.what.find('\'', 1) - 1));
  }
  EXPECT_EQ(join(without_effect, ", "),
            "handle_exceptions: false, defaults.allow_controller_activation_with_inactive_hardware: true, "
            "defaults.deactivate_controllers_on_hardware_self_deactivate: false, overruns.manage: false, "
            "hardware_synchronization.expect_blocking_read_write: true");
  const ManagerParameters& m = file.manager;
  EXPECT_EQ(m.update_rate, 500);
  EXPECT_FALSE(m.enforce_command_limits || m.overruns_print_warnings);
  EXPECT_EQ(m.unconfigured, std::vector<std::string>{"arm"});
  EXPECT_EQ(m.inactive, (std::vector<std::string>{"gripper", "lift"}));
  EXPECT_EQ(m.strictness, "best_effort");
  EXPECT_EQ(m.thread_priority, 60);
  EXPECT_EQ(m.cpu_affinity, std::vector<double>{3});
  EXPECT_EQ(m.lock_memory, true);
  std::vector<std::string> unused;
  for (const UnusedKey& key : file.unused) unused.push_back(key.key);
  EXPECT_EQ(join(unused, " "),
            "diagnostics.threshold.controller_manager.periodicity.mean_error.error "
            "diagnostics.threshold.controller_manager.periodicity.mean_error.warn "
            "hardware_synchronization.minimum_cycle_time use_sim_time");
}

TEST(Ros2Controllers, BlocksOfOneNameAreMixedAndTheLaterLineWins) {
  const auto [file, problems] = read(R"(/**:
  controller_manager:
    ros__parameters:
      update_rate: 100
      arm: {type: joint_trajectory_controller/JointTrajectoryController}
/**:
  arm:
    ros__parameters:
      joints: [joint1]
      command_interfaces: [position]
/**:
  arm:
    ros__parameters:
      command_interfaces: [velocity]
      state_interfaces: [position, velocity]
)");
  ASSERT_EQ(problems.list().size(), 2u) << all(problems);
  for (const Problem& problem : problems.list()) {
    EXPECT_EQ(problem.code, "duplicate-name");
    EXPECT_EQ(problem.severity, Severity::warning);
  }
  ASSERT_EQ(file.controllers.size(), 1u);
  const auto& parameters = file.controllers.front().parameters;
  EXPECT_EQ(parameters.entries.at("joints").values, std::vector<std::string>{"joint1"});
  EXPECT_EQ(parameters.entries.at("command_interfaces").values, std::vector<std::string>{"velocity"});
}

TEST(Ros2Controllers, ParametersUnsaidAreThoseOfRosOrToldFromStatedOnes) {
  const ManagerParameters m = read(kHumble).file.manager;
  EXPECT_TRUE(m.enforce_command_limits && m.overruns_print_warnings);
  EXPECT_EQ(m.strictness, "");
  EXPECT_EQ(m.thread_priority, 0);
  EXPECT_FALSE(m.lock_memory);
}

TEST(Ros2Controllers, ParamsFilesAreReadBesideTheFileAndWin) {
  const Folder folder;
  folder.write("one.yaml", "jtc: {ros__parameters: {joints: [a], x: 1}}\n");
  folder.write("two.yaml", "/**: {ros__parameters: {x: 2}}\n");
  const auto main = folder.write("main.yaml", R"(controller_manager:
  ros__parameters:
    jtc:
      type: a/B
      params_file: [one.yaml, two.yaml]
      node_options_args: ["--ros-args", "-p", "y:=7"]
    other: {type: a/B, params_file: one.yaml}
jtc: {ros__parameters: {joints: [b], z: 3}}
)");
  Problems problems;
  const ControllersFile file = read_controllers_file(main, problems);
  const ControllerEntry& jtc = find(file, "/jtc");
  EXPECT_EQ(text_of(jtc, "joints"), "a");
  EXPECT_EQ(text_of(jtc, "x"), "2");
  EXPECT_EQ(text_of(jtc, "y"), "7");
  EXPECT_EQ(text_of(jtc, "z"), "3");
  ASSERT_EQ(problems.list().size(), 1u) << all(problems);
  EXPECT_EQ(problems.list()[0].where.line, 7);
  EXPECT_NE(problems.list()[0].what.find("has no entry for '/other'"), std::string::npos);
}

// A manager need not be called controller_manager; blocks may state the type that it states.
TEST(Ros2Controllers, AManagerOfAnotherNameHasEachControllerOnce) {
  const auto [file, problems] = read(R"(my_manager:
  ros__parameters:
    update_rate: 200
    jtc: {type: a/B}
jtc:
  ros__parameters:
    type: a/B
    joints: [one]
other:
  ros__parameters: {type: c/D}
)");
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(file.controllers.size(), 2u);
  EXPECT_EQ(text_of(find(file, "/jtc"), "joints"), "one");
  EXPECT_EQ(find(file, "/other").type, "c/D");
  EXPECT_EQ(file.update_rate, 200);
}

TEST(Ros2Controllers, TwoManagersOfOneNamespaceHaveEachControllerOnce) {
  const auto [file, problems] = read(R"(left_manager: {ros__parameters: {left: {type: a/B}}}
right_manager: {ros__parameters: {right: {type: a/B}}}
left: {ros__parameters: {type: a/B, joints: [l]}}
right: {ros__parameters: {type: a/B, joints: [r]}}
)");
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(file.controllers.size(), 2u);
  EXPECT_EQ(text_of(find(file, "/left"), "joints"), "l");
  EXPECT_EQ(text_of(find(file, "/right"), "joints"), "r");
}

TEST(Ros2Controllers, WhatIsWrongWithOneLeavesTheOthers) {
  const auto [file, problems] = read(R"(controller_manager:
  ros__parameters:
    good: {type: a/B, fallback_controllers: [nobody]}
    bad: {type: a/B}
    untyped: {params_file: []}
bad: {ros__parameters: {update_rate: -3}}
)");
  EXPECT_FALSE(problems.has_errors()) << all(problems);
  ASSERT_EQ(file.controllers.size(), 1u) << all(problems);
  EXPECT_EQ(file.controllers[0].name, "good");
  EXPECT_TRUE(file.controllers[0].fallback_controllers.empty());
  EXPECT_NE(all(problems).find("'bad' is left out"), std::string::npos) << all(problems);
  EXPECT_NE(all(problems).find("'untyped' is left out"), std::string::npos) << all(problems);
}

TEST(Ros2Controllers, AMissingParamsFileLeavesItsControllerOutAndIsToldAtItsLine) {
  const Problem problem = only(
      "controller_manager:\n  ros__parameters:\n    jtc: {type: a/B}\n"
      "    jtc.params_file: nowhere.yaml\n");
  EXPECT_EQ(problem.code, "params-file");
  EXPECT_EQ(problem.where.line, 4);
  EXPECT_EQ(problem.severity, Severity::warning);
  EXPECT_NE(problem.what.find("'jtc' is left out"), std::string::npos) << problem.what;
}

TEST(Ros2Controllers, LaterFilesReplaceKeyByKey) {
  const Folder folder;
  const auto first = folder.write("first.yaml", kHumble);
  const auto second = folder.write("second.yaml",
                                   "arm_controller: {ros__parameters: {joints: [wrist]}}\n"
                                   "controller_manager: {ros__parameters: {update_rate: 400}}\n");
  Problems problems;
  const ControllersFile file = read_controllers_files({first, second}, problems);
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.update_rate, 400);
  EXPECT_EQ(text_of(find(file, "/arm_controller"), "joints"), "wrist");
  EXPECT_EQ(text_of(find(file, "/arm_controller"), "command_interfaces"), "position");
  EXPECT_EQ(file.controllers[0].name, "joint_state_broadcaster");
}

// The lines are those of the tutorial "Building a ros2_control System: ROS2 Control with the JetBot Part 2"
// (mikelikesrobots), which prints them without their indentation.
TEST(Ros2Controllers, TheJetBotsFileIsRead) {
  const auto [file, problems] = read(R"(controller_manager:
  ros__parameters:
    update_rate: 10 # Hz
    jetbot_base_controller:
      type: diff_drive_controller/DiffDriveController
jetbot_base_controller:
  ros__parameters:
    linear.x.max_velocity: 0.016
    linear.x.min_velocity: -0.016
    angular.z.max_velocity: 0.25
    angular.z.min_velocity: -0.25
    wheel_separation: 0.104
    wheel_radius: 0.032
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.update_rate, 10);
  const ControllerEntry& drive = file.controllers.at(0);
  EXPECT_EQ(drive.type, "diff_drive_controller/DiffDriveController");
  EXPECT_EQ(drive.parameters.number("linear.x.max_velocity", 0), 0.016);
  EXPECT_EQ(drive.parameters.number("angular.z.min_velocity", 0), -0.25);
  EXPECT_EQ(drive.parameters.number("wheel_separation", 0), 0.104);
  EXPECT_EQ(drive.parameters.number("wheel_radius", 0), 0.032);
}

TEST(Ros2Controllers, LinesThatLostTheirIndentationAreToldSo) {
  const auto [file, problems] = read("controller_manager:\nros__parameters:\nupdate_rate: 10 # Hz\n");
  ASSERT_GE(problems.list().size(), 1u);
  EXPECT_EQ(problems.list()[0].code, "no-node-name");
  EXPECT_EQ(problems.list()[0].where.text(), "c.yaml:2:1");
  EXPECT_TRUE(problems.has_errors());
}

}  // namespace
}  // namespace polyarm::ros_files::controllers_texts
