#include "polyarm/cell/controllers_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/superseded_keys.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;

struct Read {
  ControllersFile file;
  Problems problems;
};

Read read(const std::string& text) {
  Read out;
  out.file = read_controllers({{"c.yaml", "", text}}, out.problems);
  return out;
}

std::string all(const Problems& problems) {
  std::string out;
  for (const Problem& problem : problems.list()) out += problem.text() + "\n";
  return out;
}

/// The one finding of a text, and that there is no other.
Problem only(const std::string& text) {
  const Read got = read(text);
  EXPECT_EQ(got.problems.list().size(), 1u) << all(got.problems);
  return got.problems.list().empty() ? Problem{} : got.problems.list().front();
}

std::string thrown(const std::string& text) {
  try {
    read(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing";
}

const ControllerEntry& find(const ControllersFile& file, const std::string& full_name) {
  for (const ControllerEntry& entry : file.controllers)
    if (entry.full_name() == full_name) return entry;
  throw std::runtime_error("no controller " + full_name);
}

std::string text_of(const ControllerEntry& entry, const std::string& key) {
  return join(entry.parameters.list(key), ",");
}

constexpr const char* kHumble = R"(controller_manager:
  ros__parameters:
    update_rate: 250  # Hz

    joint_state_broadcaster:
      type: joint_state_broadcaster/JointStateBroadcaster

    arm_controller:
      type: joint_trajectory_controller/JointTrajectoryController

arm_controller:
  ros__parameters:
    joints:
      - shoulder
      - elbow
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints:
      stopped_velocity_tolerance: 0.01
      shoulder: {trajectory: 0.2, goal: 0.1}
      elbow.goal: 0.05
)";

// --- forms of ROS 2 ---

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
  EXPECT_EQ(all(problems), "");
  const ManagerParameters& m = file.manager;
  EXPECT_EQ(m.update_rate, 500);
  EXPECT_FALSE(m.enforce_command_limits || m.handle_exceptions || m.overruns_manage ||
               m.overruns_print_warnings || m.deactivate_controllers_on_hardware_self_deactivate);
  EXPECT_TRUE(m.shutdown_on_initial_state_failure && m.allow_controller_activation_with_inactive_hardware &&
              m.expect_blocking_read_write);
  EXPECT_EQ(m.unconfigured, std::vector<std::string>{"arm"});
  EXPECT_EQ(m.inactive, (std::vector<std::string>{"gripper", "lift"}));
  EXPECT_EQ(m.strictness, "best_effort");
  EXPECT_EQ(m.thread_priority, 60);
  EXPECT_EQ(m.cpu_affinity, std::vector<double>{3});
  EXPECT_EQ(m.minimum_cycle_time, 0.0002);
  std::vector<std::string> unused;
  for (const UnusedKey& key : file.unused) unused.push_back(key.key);
  EXPECT_EQ(join(unused, " "),
            "diagnostics.threshold.controller_manager.periodicity.mean_error.error "
            "diagnostics.threshold.controller_manager.periodicity.mean_error.warn lock_memory use_sim_time");
}

TEST(Ros2Controllers, ParametersUnsaidHaveTheDefaultsOfRos) {
  const ManagerParameters m = read(kHumble).file.manager;
  EXPECT_TRUE(m.enforce_command_limits && m.handle_exceptions && m.overruns_manage);
  EXPECT_EQ(m.strictness, "strict");
  EXPECT_EQ(m.thread_priority, 50);
  EXPECT_EQ(m.minimum_cycle_time, 1e-4);
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
  EXPECT_NE(problems.list()[0].what.find("says nothing about '/other'"), std::string::npos);
}

TEST(Ros2Controllers, AMissingParamsFileIsAnErrorAtItsLine) {
  const Problem problem = only(
      "controller_manager:\n  ros__parameters:\n    jtc: {type: a/B}\n"
      "    jtc.params_file: nowhere.yaml\n");
  EXPECT_EQ(problem.code, "params-file");
  EXPECT_EQ(problem.where.line, 4);
  EXPECT_EQ(problem.severity, Severity::error);
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

// --- what is wrong, and where ---

struct Wrong {
  const char* text;
  const char* code;
  const char* place;
  Severity severity;
  const char* says;
};

class WrongFile : public testing::TestWithParam<Wrong> {};

TEST_P(WrongFile, IsToldInOneSentenceWithItsPlace) {
  const Wrong& wrong = GetParam();
  const Problem problem = only(wrong.text);
  EXPECT_EQ(problem.code, wrong.code) << problem.text();
  EXPECT_EQ(problem.where.text(), wrong.place) << problem.text();
  EXPECT_EQ(problem.severity, wrong.severity) << problem.text();
  EXPECT_NE(problem.text().find(wrong.says), std::string::npos) << problem.text();
  EXPECT_NE(problem.advice, "") << problem.text();
}

constexpr Severity kError = Severity::error, kWarning = Severity::warning;
constexpr const char* kManager = "controller_manager:\n  ros__parameters:\n    jtc: {type: a/B}\n    ";
std::string under_manager(const char* line) {
  return kManager + std::string(line) + "\n";
}

TEST(WrongManagerParameter, IsToldWithItsPlaceAndWhatToWrite) {
  struct Line {
    const char* text;
    const char* code;
    int column;
    Severity severity;
    const char* says;
  };
  for (const Line& line : {
           Line{"update_rat: 100", "unknown-key", 5, kWarning, "did you mean 'update_rate'?"},
           Line{"hardware_component_initial_state: {inactive: [a]}", "unknown-key", 40, kWarning,
                "did you mean 'hardware_components_initial_state.inactive'?"},
           Line{"update_rate: fast", "bad-value", 5, kError, "write a whole number from 1 to 10000"},
           Line{"update_rate: -5", "bad-value", 5, kError, "write a whole number from 1 to 10000"},
           Line{"update_rate: 1e300", "bad-value", 5, kError, "write a whole number from 1 to 10000"},
           Line{"update_rate: 100.0", "bad-value", 5, kWarning, "write 100"},
           Line{"update_rate: [100]", "bad-value", 5, kError, "is a list"},
           Line{"enforce_command_limits: 1", "bad-value", 5, kError, "write true or false"},
           Line{"overruns.manage: maybe", "bad-value", 5, kError, "write true or false"},
           Line{"thread_priority: 100", "bad-value", 5, kError, "write a whole number from 1 to 99"},
           Line{"cpu_affinity: [a]", "bad-value", 5, kError, "write a list of whole numbers"},
           Line{"defaults.switch_controller.strictness: strickt", "bad-value", 5, kError,
                "did you mean 'strict'?"},
           Line{"configure_components_on_start: [arm]", "superseded-key", 5, kWarning,
                "hardware_components_initial_state: inactive"},
           Line{"jtc.joints: [a]", "misplaced-key", 5, kWarning, "'ros__parameters:' at the left margin"},
           Line{"other: {tpye: a/B, type: a/B}", "unknown-key", 13, kWarning, "did you mean 'type'?"},
           Line{"other: {params_file: []}", "no-type", 13, kError, "has no type"},
           Line{"other: {type: JointTrajectoryController}", "bad-type", 13, kError, "PACKAGE/CLASS"},
           Line{"jtc.fallback_controllers: [jtc]", "bad-fallback", 0, kError, "its own fallback"},
           Line{"update_rate:", "no-value", 5, kWarning, "has no value"},
           Line{"jtc: {type: c/D}", "duplicate-name", 5, kError, "here and in line 3"},
           Line{"diagnostics.x: [[1, 2], [3]]", "bad-value", 21, kError, "a list of plain values"},
       }) {
    const Read got = read(under_manager(line.text));
    ASSERT_GE(got.problems.list().size(), 1u) << line.text;
    const Problem& problem = got.problems.list().front();
    EXPECT_EQ(problem.code, line.code) << all(got.problems);
    EXPECT_EQ(problem.severity, line.severity) << problem.text();
    if (line.column > 0) {
      EXPECT_EQ(problem.where.line, 4) << problem.text();
      EXPECT_EQ(problem.where.column, line.column) << problem.text();
    }
    EXPECT_NE(problem.text().find(line.says), std::string::npos) << problem.text();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Forms, WrongFile,
    testing::Values(
        Wrong{"controller_manager:\n  update_rate: 10\n  jtc:\n    type: a/B\n", "no-ros-parameters",
              "c.yaml:2:3", kError,
              "write 'ros__parameters:' in a line of its own below 'controller_manager:'"},
        Wrong{"controller_manager:\n  ros_parameters:\n    jtc: {type: a/B}\n", "unknown-key", "c.yaml:2:3",
              kError, "two underscores"},
        Wrong{"controller_manager:\n  ros__parameters:\n    jtc: {type: a/B}\njtc:\n  joints: [a]\n",
              "no-ros-parameters", "c.yaml:5:3", kError, "below 'jtc:'"},
        Wrong{"controller_manager:\n  ros__parameters: {jtc: {type: a/B}}\njct:\n  ros__parameters: {x: 1}\n",
              "no-type", "c.yaml:4:3", kWarning, "did you mean 'jtc'?"},
        Wrong{"controller_manager:\n  ros__parameters: {jtc: {type: a/B}}\narm_controller:\n"
              "  ros__parameters: {joints: [a]}\n",
              "no-type", "c.yaml:4:3", kWarning, "no controller manager declares"},
        Wrong{"controller_manager:\n  ros__parameters:\n    jtc: {}\n    jtc.params_file: []\n", "no-type",
              "c.yaml:4:5", kError, "write 'type: PACKAGE/CLASS'"},
        Wrong{"/left/controller_manager:\n  ros__parameters: {jtc: {type: a/B}}\njtc:\n  ros__parameters: "
              "{x: 1}\n",
              "other-namespace", "c.yaml:4:3", kWarning, "write '/left/jtc:'"},
        Wrong{"controller_manager: {ros__parameters: {jtc: {type: a/B}}}\njtc:\n  ros__parameters:\n    x: "
              "1\n    x: 2\n",
              "duplicate-key", "c.yaml:5:5", kWarning, "here and in line 4"},
        Wrong{"controller_manager: {ros__parameters: {jtc: {type: a/B}}}\njtc:\n  ros__parameters: [x]\n",
              "bad-value", "c.yaml:3:3", kError, "no names and values"},
        Wrong{"controller_manager: {ros__parameters: {jtc: {type: a/B}}}\njtc: {ros__parameters: {is_async: "
              "2}}\n",
              "bad-value", "c.yaml:2:25", kError, "true or false"},
        Wrong{"- a\n- b\n", "not-parameters", "c.yaml:1:1", kError, "begins with 'controller_manager:'"},
        Wrong{"", "no-controllers", "c.yaml:1:1", kWarning, "names no controllers"},
        Wrong{"MyRobot:\n  JointA_EffortController:\n    joint: JointA\n", "no-type", "c.yaml:2:3", kError,
              "'/MyRobot/JointA_EffortController' has no type"},
        Wrong{"arm_controller: {type: JointEffortController, joint: a}\n", "bad-type", "c.yaml:1:18", kError,
              "effort_controllers/JointEffortController"}));

TEST(WrongYaml, ValuesOfNoNodeBesideAManagerOfAnyNamespaceAreToldAndDropped) {
  const auto [file, problems] = read("type: a/B\n/**: {ros__parameters: {jtc: {type: a/B}}}\n");
  ASSERT_EQ(problems.list().size(), 1u) << all(problems);
  EXPECT_EQ(problems.list()[0].where.text(), "c.yaml:1:1");
  EXPECT_EQ(problems.list()[0].code, "no-ros-parameters");
  EXPECT_EQ(file.controllers.size(), 1u);
}

TEST(WrongYaml, ATabIsNamedAsSuch) {
  const std::string said = thrown("controller_manager:\n  ros__parameters:\n\tupdate_rate: 10\n");
  EXPECT_NE(said.find("c.yaml:3:1: error: a tab stands in the indentation"), std::string::npos) << said;
  EXPECT_NE(said.find("replace it by spaces"), std::string::npos) << said;
}

TEST(WrongYaml, AliasesWithoutEndAreRefused) {
  EXPECT_NE(thrown("a: &a\n  b: *a\n").find("64 deep"), std::string::npos);
  EXPECT_NE(thrown("jtc: {ros__parameters: &a {b: *a}}\n").find("64 deep"), std::string::npos);
  EXPECT_NE(thrown("a: &a {x: 1}\nb: &b {<<: *b}\n").find("64 deep"), std::string::npos);
  std::string laughs = "l0: &l0 {a: 1, b: 2}\n";
  for (int i = 1; i < 30; ++i) {
    const std::string before = "*l" + std::to_string(i - 1);
    laughs +=
        "l" + std::to_string(i) + ": &l" + std::to_string(i) + " {a: " + before + ", b: " + before + "}\n";
  }
  EXPECT_NE(thrown(laughs).find("100000 values"), std::string::npos);
  EXPECT_NE(thrown(std::string(500, '/') + "a: 1\n" +
                   [] {
                     std::string deep;
                     for (int i = 0; i < 100; ++i) deep += "/a";
                     return deep;
                   }() +
                   ": 2\n")
                .find("64 deep"),
            std::string::npos);
}

// --- superseded ---

TEST(SupersededKeys, AreWarningsThatSayWhatToWrite) {
  const auto [file, problems] = read(R"(controller_manager:
  ros__parameters:
    drive: {type: diff_drive_controller/DiffDriveController}
    jtc: {type: joint_trajectory_controller/JointTrajectoryController}
    states: {type: joint_state_controller/JointStateController}
drive:
  ros__parameters:
    publish_rate: 50.0
    use_stamped_vel: false
    linear.x.has_velocity_limits: true
    enable_odom_tf: true
jtc:
  ros__parameters:
    state_publish_rate: 50.0
    open_loop_control: true
    start_with_holding: true
    allow_partial_joints_goal: true
)");
  std::vector<int> lines;
  for (const Problem& problem : problems.list()) {
    EXPECT_TRUE(problem.code == "superseded-key" || problem.code == "superseded-type") << problem.text();
    EXPECT_EQ(problem.severity, kWarning);
    lines.push_back(problem.where.line);
  }
  EXPECT_EQ(lines, (std::vector<int>{5, 8, 9, 10, 14, 15, 16}));
  EXPECT_NE(all(problems).find("joint_state_broadcaster/JointStateBroadcaster"), std::string::npos);
  EXPECT_NE(all(problems).find("interpolate_from_desired_state"), std::string::npos);
}

TEST(SupersededKeys, OfTodayAreNotAmongThem) {
  const char* drive = "diff_drive_controller/DiffDriveController";
  for (const char* key : {"enable_odom_tf", "wheel_radius", "linear.x.max_velocity", "cmd_vel_timeout",
                          "linear.x.max_deceleration", "position_feedback"})
    EXPECT_EQ(superseded(drive, key), nullptr) << key;
  const char* jtc = "joint_trajectory_controller/JointTrajectoryController";
  for (const char* key :
       {"allow_partial_joints_goal", "allow_nonzero_velocity_at_trajectory_end", "gains.j.p",
        "gains.j.i_clamp_max", "gains.j.antiwindup_strategy", "constraints.goal_time"})
    EXPECT_EQ(superseded(jtc, key), nullptr) << key;
  for (const char* type :
       {drive, jtc, "joint_state_broadcaster/JointStateBroadcaster",
        "forward_command_controller/ForwardCommandController", "pid_controller/PidController",
        "parallel_gripper_action_controller/GripperActionController"})
    EXPECT_EQ(superseded_type(type), nullptr) << type;
}

TEST(SupersededKeys, OldTypesNameTheirSuccessors) {
  EXPECT_NE(superseded_type("position_controllers/JointGroupPositionController"), nullptr);
  EXPECT_NE(superseded_type("velocity_controllers/JointGroupVelocityController"), nullptr);
  EXPECT_NE(superseded_type("effort_controllers/JointGroupEffortController"), nullptr);
  EXPECT_NE(superseded_type("effort_controllers/GripperActionController"), nullptr);
  EXPECT_STREQ(superseded_type("joint_state_controller/JointStateController"),
               "write joint_state_broadcaster/JointStateBroadcaster");
  EXPECT_STREQ(superseded("my_controllers/Own", "thread_priority"), "write async_parameters.thread_priority");
}

TEST(SupersededKeys, EveryRowSaysSomethingAndIsFoundByItsOwnName) {
  for (const Superseded& row : superseded_keys()) {
    EXPECT_GT(std::string(row.instead).size(), 10u) << row.key;
    EXPECT_NE(superseded(row.type, row.key), nullptr) << row.type << " " << row.key;
    EXPECT_FALSE(std::string(row.instead).ends_with(".")) << row.instead;
  }
}

// --- ROS 1 ---

// The values are those of the page "ros_control" that prints them line by line: the controllers of MyRobot
// with `pid: {p: 100.0, i: 10.0, d: 1.0}`, publish_rate 50 and the limits below.
constexpr const char* kMyRobot = R"(MyRobot:
  # Publish all joint states
  joint_state_controller:
    type: joint_state_controller/JointStateController
    publish_rate: 50
  JointA_EffortController:
    type: effort_controllers/JointEffortController
    joint: JointA # Name of the joint for which this controller belongs to.
    pid: {p: 100.0, i: 10.0, d: 1.0} # PIDvalues
  JointB_EffortController:
    type: effort_controllers/JointEffortController
    joint: JointB
    pid: {p: 100.0, i: 10.0, d: 1.0}
  JointC_PositionController:
    type: position_controllers/JointPositionController
    joint: JointC
)";

TEST(Ros1Controllers, MyRobotIsRead) {
  const auto [file, problems] = read(kMyRobot);
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(file.controllers.size(), 4u);
  EXPECT_EQ(file.controllers[0].full_name(), "/MyRobot/joint_state_controller");
  EXPECT_EQ(file.controllers[0].parameters.number("publish_rate", 0), 50);
  const ControllerEntry& a = file.controllers[1];
  EXPECT_EQ(a.full_name(), "/MyRobot/JointA_EffortController");
  EXPECT_EQ(a.type, "effort_controllers/JointEffortController");
  EXPECT_TRUE(a.ros1);
  EXPECT_EQ(text_of(a, "joint"), "JointA");
  EXPECT_EQ(a.parameters.number("pid.p", 0), 100);
  EXPECT_EQ(a.parameters.number("pid.i", 0), 10);
  EXPECT_EQ(a.parameters.number("pid.d", 0), 1);
  EXPECT_EQ(a.parameters.entries.at("pid.p").where.line, 9);
  EXPECT_EQ(text_of(file.controllers[3], "joint"), "JointC");
}

TEST(Ros1Controllers, LimitsAreFoundAtAnyDepthForTheirReader) {
  for (const char* text :
       {"MyRobot:\n  joint_limits:\n    JointA:\n      has_position_limits: true\n"
        "      min_position: -1.57\n      max_position: 3.14\n      has_velocity_limits: true\n"
        "      max_velocity: 1.5\n",
        "joint_limits: {JointC: {has_velocity_limits: false, max_velocity: 0}}\n",
        "/**:\n  ros__parameters:\n    planning: {joint_limits: {a: {max_velocity: 1.5}}}\n"}) {
    const auto [file, problems] = read(text);
    EXPECT_EQ(all(problems), "");
    ASSERT_EQ(file.joint_limits.size(), 1u) << text;
    EXPECT_EQ(file.joint_limits[0].keys.back(), "joint_limits");
    EXPECT_TRUE(file.controllers.empty());
    EXPECT_TRUE(file.unused.empty()) << file.unused[0].key;
  }
  const JointLimitsSource limits =
      read("MyRobot:\n  joint_limits: {a: {max_velocity: 1.5}}\n").file.joint_limits.at(0);
  EXPECT_EQ(limits.keys, (std::vector<std::string>{"MyRobot", "joint_limits"}));
  EXPECT_EQ(limits.ns, "/MyRobot");
  EXPECT_EQ(limits.where.text(), "c.yaml:2:3");
  Problems problems;
  const ControllersFile whole =
      read_controllers({{"c.yaml", "/MyRobot/joint_limits", "a: {max_velocity: 1.5}"}}, problems);
  EXPECT_EQ(all(problems), "");
  ASSERT_EQ(whole.joint_limits.size(), 1u);
  EXPECT_TRUE(whole.joint_limits[0].keys.empty());
  EXPECT_EQ(whole.joint_limits[0].ns, "/MyRobot");
}

TEST(Ros1Controllers, SeveralNamespacesAndNoneStandSideBySide) {
  const auto [file, problems] =
      read(R"(left: {arm: {jtc: {type: position_controllers/JointTrajectoryController, joints: [a, b]}}}
/right/jtc: {type: effort_controllers/JointTrajectoryController, joints: [c], gains: {c: {p: 1, i: 2, d: 3, i_clamp: 4}}}
gripper_controller: {type: position_controllers/JointPositionController, joint: g}
jtc/constraints/goal_time: 0.5
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(text_of(find(file, "/left/arm/jtc"), "joints"), "a,b");
  EXPECT_EQ(find(file, "/right/jtc").parameters.number("gains.c.i_clamp", 0), 4);
  EXPECT_EQ(find(file, "/gripper_controller").ns, "/");
}

TEST(Ros1Controllers, GainsOfGazeboAndTheLoopRateAreKept) {
  const auto [file, problems] = read(R"(/gazebo_ros_control:
  pid_gains:
    elbow: {p: 100.0, i: 0.01, d: 10.0}
hardware_control_loop: {loop_hz: 125}
arm_controller: {type: velocity_controllers/JointTrajectoryController, joints: [elbow]}
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.pid_gains.number("elbow.p", 0), 100);
  EXPECT_EQ(file.update_rate, 125);
  EXPECT_EQ(file.controllers.size(), 1u);
}

TEST(Ros1Controllers, OldKeysAreTheirOwnAndNoCauseForWarnings) {
  const auto [file, problems] = read(R"(drive:
  type: diff_drive_controller/DiffDriveController
  left_wheel: l
  right_wheel: r
  publish_rate: 50
  linear: {x: {has_velocity_limits: false, max_velocity: 0}}
)");
  EXPECT_EQ(all(problems), "");
  EXPECT_TRUE(file.controllers.at(0).parameters.has("publish_rate"));
}

TEST(Ros1Controllers, ListsOfMapsKeepTheirNames) {
  const auto [file, problems] = read(R"(states:
  type: joint_state_controller/JointStateController
  extra_joints:
    - {name: wheel, position: 0.5}
    - {position: rad(1.5), velocity: deg(180)}
)");
  EXPECT_EQ(all(problems), "");
  const ControllerEntry& states = file.controllers.at(0);
  EXPECT_EQ(text_of(states, "extra_joints"), "wheel,1");
  EXPECT_EQ(states.parameters.number("extra_joints.wheel.position", 0), 0.5);
  EXPECT_EQ(states.parameters.number("extra_joints.1.position", 0), 1.5);
  EXPECT_NEAR(states.parameters.number("extra_joints.1.velocity", 0), 3.14159265358979, 1e-12);
}

TEST(Ros1Controllers, HardwareAndAPlannersListAreNoControllers) {
  const auto [file, problems] = read(
      "arm_hw: {type: my_robot/MyRobotHW, joints: [a]}\n"
      "hardware_interface: {joints: [a, b]}\n"
      "jtc: {type: a/B}\n");
  EXPECT_EQ(all(problems), "");
  EXPECT_EQ(file.controllers.size(), 1u);
  EXPECT_EQ(file.unused.size(), 3u);
}

TEST(Ros1Controllers, SourcesMayStandInANamespaceAndBeOneValue) {
  Problems problems;
  ParameterSource value{"top.launch", "/MyRobot/JointA_EffortController/pid/p", "55"};
  value.literal = true;
  value.where = {"top.launch", 9, 0};
  const ControllersFile file =
      read_controllers({{"a.yaml", "/MyRobot", "JointA_EffortController: {type: a/B, pid: {p: 1}}"},
                        value,
                        {"b.yaml", "/MyRobot/JointA_EffortController/joints", "[x, y]"}},
                       problems);
  EXPECT_EQ(all(problems), "");
  const ControllerEntry& a = find(file, "/MyRobot/JointA_EffortController");
  EXPECT_EQ(a.parameters.number("pid.p", 0), 55);
  EXPECT_EQ(a.parameters.entries.at("pid.p").where.line, 9);
  EXPECT_EQ(text_of(a, "joints"), "x,y");
}

// --- anything at all ---

std::string damaged(std::string text, std::mt19937& random) {
  static const std::vector<std::string> kPieces = {":",
                                                   "\n",
                                                   "  ",
                                                   "\t",
                                                   "{",
                                                   "}",
                                                   "[",
                                                   "]",
                                                   "*a",
                                                   "&a ",
                                                   "<<: *a\n",
                                                   "/**",
                                                   "ros__parameters:",
                                                   "type: a/B",
                                                   "''",
                                                   "\"",
                                                   "- ",
                                                   "? ",
                                                   "#",
                                                   "\xff",
                                                   std::string(1, '\0'),
                                                   "1e999",
                                                   ".nan",
                                                   "!!binary ",
                                                   "---\n",
                                                   "|\n",
                                                   ">",
                                                   "controller_manager:",
                                                   "joint_limits:",
                                                   "params_file: c.yaml",
                                                   "~",
                                                   "null",
                                                   "/",
                                                   "."};
  const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const std::size_t times = 1 + pick(6);
  for (std::size_t i = 0; i < times; ++i) {
    const std::size_t at = pick(text.size() + 1), length = pick(12);
    switch (pick(4)) {
      case 0:
        text.erase(at, length);
        break;
      case 1:
        text.insert(at, kPieces[pick(kPieces.size())]);
        break;
      case 2:
        text.insert(at, text.substr(pick(text.size() + 1), length * 4));
        break;
      default:
        if (at < text.size()) text[at] = static_cast<char>(random());
    }
  }
  return text;
}

TEST(DamagedControllersFiles, EndInAResultOrASentence) {
  std::mt19937 random(20261121);
  int read_well = 0, refused = 0;
  const std::string with_alias =
      "controller_manager: &a {ros__parameters: &b {jtc: {type: a/B}}}\nx: *a\ny: {<<: *b}\n";
  for (int i = 0; i < 9000; ++i) {
    const std::string text = damaged(i % 3 == 0   ? kHumble
                                     : i % 3 == 1 ? std::string(kMyRobot)
                                                  : with_alias,
                                     random);
    try {
      read(text);
      ++read_well;
    } catch (const Error& error) {
      EXPECT_FALSE(error.problems().empty());
      ++refused;
    }
  }
  EXPECT_GT(read_well, 1000);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace polyarm::cell
