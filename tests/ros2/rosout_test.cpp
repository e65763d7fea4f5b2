/// What happens to the cell and to goals, as a subscriber of /rosout reads it; and spawners of what runs.
#include <gtest/gtest.h>

#include <string>

#include "tests/ros2/ros2_cell.hpp"

namespace polyarm::ros2 {
namespace {

constexpr int kInfo = 20, kWarn = 30;

class Rosout : public Ros2Cell {
 protected:
  void SetUp() override {
    Ros2Cell::SetUp();
    log_ = client_->listen("/rosout", "rcl_interfaces/Log", {true, true, 1000});
  }
  /// The level of the first line that has both pieces; 0: none has come in time.
  int level_of(const std::string& piece, const std::string& other = "") {
    int level = 0;
    wait([&] {
      for (const json& line : log_->since(0)) {
        const std::string text = line["msg"];
        if (text.find(piece) != std::string::npos && text.find(other) != std::string::npos)
          level = line["level"].get<int>();
      }
      return level != 0;
    });
    return level;
  }
  std::size_t lines_with(const std::string& piece) {
    std::size_t out = 0;
    for (const json& line : log_->since(0))
      out += line["msg"].get<std::string>().find(piece) != std::string::npos;
    return out;
  }
  bool trigger(const std::string& name) {
    return call("/polyarm/" + name, "std_srvs/srv/Trigger")["success"].get<bool>();
  }
  json send(int number) {
    return call(kAction + "send_goal", kType + "_SendGoal",
                {{"goal_id", id(number)}, {"goal", goal_to(0.5, 1)}});
  }

  decltype(client_->listen("", "")) log_;
};

TEST_F(Rosout, SaysHeldAndRunningAndWhy) {
  ASSERT_TRUE(trigger("hold"));
  EXPECT_EQ(level_of("the cell is held: "), kWarn);
  ASSERT_TRUE(trigger("resume"));
  EXPECT_EQ(level_of("the cell is running"), kInfo);
}

TEST_F(Rosout, EveryGoalOnAHeldCellIsAWarningWithTheCause) {
  ASSERT_TRUE(trigger("hold"));
  ASSERT_EQ(level_of("the cell is held: "), kWarn);
  send(1);
  EXPECT_EQ(level_of("a goal for 'arm_controller' comes while the cell is held (", "control resume"), kWarn);
  send(2);
  EXPECT_TRUE(wait([&] { return lines_with("a goal for 'arm_controller' comes while") == 2; }));
}

TEST_F(Rosout, AParameterRefusesGoalsOnAHeldCell) {
  const json set = call("/arm_controller/set_parameters", kParameters + "SetParameters",
                        {{"parameters", json::array({{{"name", "reject_goals_when_held"},
                                                      {"value", {{"type", 1}, {"bool_value", true}}}}})}});
  ASSERT_EQ(set["results"][0]["successful"], true) << set;
  ASSERT_TRUE(trigger("hold"));
  ASSERT_EQ(level_of("the cell is held: "), kWarn);
  EXPECT_EQ(send(1)["accepted"], false);
  EXPECT_NE(level_of("is refused while the cell is held ("), 0);
  ASSERT_TRUE(trigger("resume"));
  ASSERT_EQ(level_of("the cell is running"), kInfo);
  EXPECT_EQ(send(2)["accepted"], true);
}

// `spawner NAME` configures and activates; launch files of users do so with what the cell has started.
TEST_F(Rosout, ASpawnerOfAControllerThatRunsSucceeds) {
  ASSERT_EQ(states()["arm_controller"], "active");
  EXPECT_EQ(call("/controller_manager/configure_controller", kManager + "ConfigureController",
                 {{"name", "arm_controller"}})["ok"],
            true);
  EXPECT_EQ(call("/controller_manager/switch_controller", kManager + "SwitchController",
                 {{"activate_controllers", {"arm_controller"}}, {"strictness", 2}})["ok"],
            true);
  EXPECT_EQ(states()["arm_controller"], "active");
  EXPECT_EQ(send(1)["accepted"], true);
  EXPECT_EQ(call("/controller_manager/configure_controller", kManager + "ConfigureController",
                 {{"name", "nobody"}})["ok"],
            false);
}

}  // namespace
}  // namespace polyarm::ros2
