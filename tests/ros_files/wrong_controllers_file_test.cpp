#include <gtest/gtest.h>

#include <random>

#include "polyarm/ros_files/superseded_keys.hpp"
#include "tests/ros_files/controllers_texts.hpp"
#include "tests/support/damaged.hpp"

namespace polyarm::ros_files::controllers_texts {
namespace {

struct Wrong {
  const char* text;
  const char* code;
  const char* place;
  Severity severity;
  const char* says;
};

TEST(ControllersFile, DeclaresNoMoreControllersThanABoundedNumber) {
  std::string text = "controller_manager:\n  ros__parameters:\n";
  for (int i = 0; i < 3000; ++i) text += "    c" + std::to_string(i) + ": {type: a/B}\n";
  try {
    only(text.c_str());
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.problems().front().code, "too-many");
  }
}

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
           Line{"other: {params_file: []}", "no-type", 13, kWarning, "'other' is left out: "},
           Line{"other: {type: JointTrajectoryController}", "bad-type", 13, kWarning, "PACKAGE/CLASS"},
           Line{"jtc.fallback_controllers: [jtc]", "bad-fallback", 0, kWarning, "its own fallback"},
           Line{"update_rate:", "no-value", 5, kWarning, "has no value"},
           Line{"jtc: {type: c/D}", "duplicate-name", 5, kWarning, "here and in line 3"},
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
              "c.yaml:4:5", kWarning, "write 'type: PACKAGE/CLASS'"},
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
              "bad-value", "c.yaml:2:25", kWarning, "true or false"},
        Wrong{"- a\n- b\n", "not-parameters", "c.yaml:1:1", kError, "begins with 'controller_manager:'"},
        Wrong{"", "no-controllers", "c.yaml:1:1", kWarning, "names no controllers"},
        Wrong{"MyRobot:\n  JointA_EffortController:\n    joint: JointA\n", "no-type", "c.yaml:2:3", kWarning,
              "'/MyRobot/JointA_EffortController' has no type"},
        Wrong{"arm_controller: {type: JointEffortController, joint: a}\n", "bad-type", "c.yaml:1:18",
              kWarning, "effort_controllers/JointEffortController"}));

TEST(WrongYaml, ValuesOfNoNodeBesideAManagerOfAnyNamespaceAreToldAndDropped) {
  const auto [file, problems] = read("type: a/B\n/**: {ros__parameters: {jtc: {type: a/B}}}\n");
  ASSERT_EQ(problems.list().size(), 1u) << all(problems);
  EXPECT_EQ(problems.list()[0].where.text(), "c.yaml:1:1");
  EXPECT_EQ(problems.list()[0].code, "no-ros-parameters");
  EXPECT_EQ(file.controllers.size(), 1u);
}

TEST(WrongYaml, ATabIsNamedAsSuch) {
  const std::string said = thrown("controller_manager:\n  ros__parameters:\n\tupdate_rate: 10\n");
  EXPECT_NE(said.find("c.yaml:3:1: error: the indentation contains a tab"), std::string::npos) << said;
  EXPECT_NE(said.find("replace it by spaces"), std::string::npos) << said;
}

TEST(WrongYaml, AliasesWithoutEndAreRefused) {
  EXPECT_NE(thrown("a: &a\n  b: *a\n").find("inside the node that it names"), std::string::npos);
  EXPECT_NE(thrown("jtc: {ros__parameters: &a {b: *a}}\n").find("inside the node that it names"),
            std::string::npos);
  EXPECT_NE(thrown("a: &a {x: 1}\nb: &b {<<: *b}\n").find("inside the node that it names"),
            std::string::npos);
  std::string laughs = "l0: &l0 {a: 1, b: 2}\n";
  for (int i = 1; i < 30; ++i) {
    const std::string before = "*l" + std::to_string(i - 1);
    laughs +=
        "l" + std::to_string(i) + ": &l" + std::to_string(i) + " {a: " + before + ", b: " + before + "}\n";
  }
  EXPECT_NE(thrown(laughs).find(" values"), std::string::npos);
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

// --- anything at all ---

const std::vector<std::string> kPieces{":",
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

TEST(DamagedControllersFiles, EndInAResultOrASentence) {
  std::mt19937 random(20261121);
  int read_well = 0, refused = 0;
  const std::string with_alias =
      "controller_manager: &a {ros__parameters: &b {jtc: {type: a/B}}}\nx: *a\ny: {<<: *b}\n";
  for (int i = 0; i < 9000; ++i) {
    const std::string text = test::damaged(i % 3 == 0   ? kHumble
                                           : i % 3 == 1 ? std::string(kMyRobot)
                                                        : with_alias,
                                           kPieces, 12, random);
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
}  // namespace polyarm::ros_files::controllers_texts
