/// The fault table of docs/real-hardware.md, row by row: what is told, what state follows, how many cycles
/// pass until all stand, that nothing moves then before a person says so, and that it begins again from where
/// it is measured. What drivers do at their ends is tested with them: docs/drivers.md names those tests.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "polyarm/plugins/types.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using control::RunState;
using test::Folder;
using test::Json;
using test::LockStepCell;

/// Moves its joints on and on, and fails when it is told to.
class Runaway : public controllers::Controller {
 public:
  static inline bool fails = false;
  controllers::CallbackReturn on_configure(controllers::ControllerContext& context) override {
    for (const std::string& joint : context.parameters.list("joints")) {
      claim_command(context.whole_joint(joint) + "/position");
      claim_state(context.whole_joint(joint) + "/position");
    }
    return controllers::CallbackReturn::success;
  }
  controllers::ReturnType update(const hardware::Cycle&,
                                 const controllers::Verdict& verdict) noexcept override {
    for (std::size_t i = 0; i < command_interfaces().size(); ++i)
      set_command(i, state(i) + (verdict.speed > 0 ? 5e-4 : 0));
    return fails ? controllers::ReturnType::error : controllers::ReturnType::ok;
  }
};

/// A cell of two joints of 2 rad/s in the middle of a move, stepped cycle by cycle.
class Rows {
 public:
  Rows(const std::string& inject, const std::string& more, const std::string& loop, bool runaway) {
    Runaway::fails = false;
    if (!controllers::find_controller_type("test/Runaway"))
      controllers::register_controller_type(
          {"test/Runaway", [] { return std::make_unique<Runaway>(); }, "moves until it fails"});
    folder_.write("arm.urdf", description());
    folder_.write("controllers.yaml",
                  std::string("controller_manager:\n  ros__parameters:\n    update_rate: 1000\n"
                              "    states: {type: joint_state_broadcaster/JointStateBroadcaster}\n") +
                      "    follow: {type: " +
                      (runaway ? "test/Runaway" : "joint_trajectory_controller/JointTrajectoryController") +
                      "}\nfollow:\n  ros__parameters: {joints: [a, b]}\n");
    const std::string file = folder_.write(
        "cell.yaml",
        "polyarm: cell/1\nrate: 1000\n" + loop + "controllers: controllers.yaml\nrobots:\n  arm: {" +
            "model: arm.urdf, hardware: declared, parameters: {inject: \"" + inject + "\"" + more + "}}\n");
    cell_ = std::make_unique<LockStepCell>(cell::read_cell_file(file));
    seen_ = measured();
  }
  void move(double to, double duration) {
    cell_->give(Json{{"request", "send"},
                     {"to", "follow"},
                     {"message",
                      {{"joint_names", {"a", "b"}},
                       {"points", {{{"positions", {to, -to}}, {"time_from_start", duration}}}}}}});
  }
  /// One cycle, and before every other one a tick of the cell, unless it is silent.
  void cycle() {
    control::ControlLoop& loop = this->loop();
    if (!silent && loop.cycle().time % cell::Cell::kTick == 0) cell_->cell().tick(loop.cycle().time);
    if (wakes_late) loop.woke(loop.options().period, 0);
    loop.step_next(gap);
    gap = false;
    ++cycles_;
    const std::vector<double> now = measured();
    for (std::size_t j = 0; j < now.size(); ++j)
      if (!(std::abs(now[j] - seen_[j]) <= 1e-9) && !(std::isnan(now[j]) && std::isnan(seen_[j])))
        moved_ = cycles_;
    speed_ = std::abs(now[0] - seen_[0]) * 1e3;
    seen_ = now;
  }
  void run(int cycles) {
    for (int k = 0; k < cycles; ++k) cycle();
  }
  /// Cycles so far, and the last of them in which a joint moved.
  int cycles() const { return cycles_; }
  int moved() const { return moved_; }
  /// Of the first joint, in the last cycle, rad/s.
  double speed() const { return speed_; }
  control::ControlLoop& loop() { return cell_->cell().loop(); }
  LockStepCell& cell() { return *cell_; }
  Json health() { return cell_->result({{"request", "health"}}); }

  bool silent = false, wakes_late = false, gap = false;

 private:
  static std::string description() {
    const auto joint = [](const std::string& name, const std::string& parent, const std::string& child) {
      return "<joint name='" + name + "' type='revolute'><parent link='" + parent + "'/><child link='" +
             child + "'/><axis xyz='0 0 1'/><limit lower='-3' upper='3' velocity='2' effort='10'/></joint>";
    };
    const auto driven = [](const std::string& name) {
      return "<joint name='" + name +
             "'><command_interface name='position'/><state_interface name='position'/></joint>";
    };
    return "<robot name='arm'><link name='l0'/><link name='l1'/><link name='l2'/>" + joint("a", "l0", "l1") +
           joint("b", "l1", "l2") +
           "<ros2_control name='drives' type='system'><hardware>"
           "<plugin>mock_components/GenericSystem</plugin></hardware>" +
           driven("a") + driven("b") + "</ros2_control></robot>";
  }
  std::vector<double> measured() {
    const auto states = loop().table().states().first(2);
    return {states.begin(), states.end()};
  }

  const Folder folder_;
  std::unique_ptr<LockStepCell> cell_;
  std::vector<double> seen_;
  int cycles_ = 0, moved_ = 0;
  double speed_ = 0;
};

struct Row {
  const char* name;
  const char* state;  ///< that follows
  const char* cause;  ///< as health tells it
  int standing;       ///< most cycles from where it happens to standstill
  std::string inject = "", more = "", loop = "";
  std::function<void(Rows&)> happens = [](Rows&) {};
  bool runaway = false;
  double to = 1.5, duration = 2;
};

void PrintTo(const Row& row, std::ostream* out) {
  *out << row.name;
}

class FaultRows : public testing::TestWithParam<Row> {};

constexpr int kHappens = 1000;  // a cycle in which both joints move

TEST_P(FaultRows, StandsInTimeAndMovesOnlyWhenAPersonSaysSo) {
  const Row& row = GetParam();
  const int at = row.to > 2 ? 4500 : kHappens;
  Rows rows(row.inject, row.more, row.loop, row.runaway);
  if (!row.runaway) rows.move(row.to, row.duration);
  rows.run(kHappens);
  ASSERT_EQ(rows.moved(), kHappens) << "it moves";
  rows.run(at - kHappens);
  RecordProperty("speed_mrad_s", static_cast<int>(std::lround(1000 * rows.speed())));
  row.happens(rows);
  rows.run(1500);
  rows.silent = rows.wakes_late = false;
  rows.run(20);  // the cell sees what has become of it

  const int standing = rows.moved() - at;
  RecordProperty("cycles_to_standstill", standing);
  EXPECT_LE(standing, row.standing);
  const Json health = rows.health();
  EXPECT_EQ(health["state"], row.state) << health;
  EXPECT_EQ(health["cause"].get<std::string>().rfind(row.cause, 0), 0u) << health["cause"];
  const int stood = rows.moved();
  rows.run(2000);
  EXPECT_EQ(rows.moved(), stood) << "nothing moves by itself";

  const bool fault = row.state == std::string("fault");
  bool begun_again = false;
  if (fault) {
    rows.cell().result({{"request", "control.resume"}});
    rows.run(20);
    EXPECT_EQ(rows.health()["state"], "fault") << "resume alone does not end a fault";
    const Json hardware = rows.cell().result({{"request", "hardware.list"}});
    if (hardware[0]["state"] != "active") {
      begun_again = true;
      EXPECT_EQ(rows.cell().result({{"request", "hardware.recover"}, {"name", "drives"}})["state"], "active");
    }
    Runaway::fails = false;
    rows.cell().result({{"request", "control.recover"}});
    rows.run(20);
    EXPECT_EQ(rows.health()["state"], "held");
    if (rows.cell().state_of("follow") != "active") {
      begun_again = true;
      rows.cell().result({{"request", "control.switch"}, {"activate", {"follow"}}});
    }
    EXPECT_EQ(rows.cell().state_of("follow"), "active");
    rows.run(1);  // sees what happened between requests: a controller begins at its last command
  }
  const int back = rows.cycles();
  rows.run(200);
  EXPECT_LE(rows.moved(), back) << "held is held";
  rows.loop().supervisor().latch().clear();
  rows.cell().result({{"request", "control.resume"}});
  rows.run(100);
  EXPECT_EQ(rows.health()["state"], "running") << rows.health();
  if (row.runaway) return;  // it moves again, as it is told to
  if (begun_again) {
    rows.run(400);  // faults on purpose count from the activation, and come again
    EXPECT_LE(rows.moved(), back) << "the old motion is forgotten";
    return;
  }
  rows.run(2500);
  if (row.to > 2) return;  // its move was over, and it stands where it is off
  EXPECT_NEAR(rows.cell().value_of("states", "arm/a/position"), row.to, 1e-6) << "goes on to its end";
}

void stop(Rows& rows) {
  rows.loop().supervisor().latch().request(realtime::StopKind::controlled);
}

const std::string kOverrun = "loop: {overrun_after: 10, overrun: ";
INSTANTIATE_TEST_SUITE_P(
    All, FaultRows,
    testing::Values(
        Row{"ComponentCannotBeRead", "fault", "a hardware component failed", 1, "read_error@1000"},
        Row{"ComponentCannotBeWritten", "fault", "a hardware component failed", 1, "write_error@1000"},
        Row{"ComponentAsksToBeDeactivated", "fault", "a hardware component failed", 2, "deactivate@1000"},
        Row{"MeasuredPositionIsNoNumber", "fault", "a measured joint position is NaN or infinite", 2,
            "nan@1000:b"},
        Row{"MeasuredPositionJumps", "fault", "a measured joint position jumped", 2, "jump@1000:a=0.6"},
        Row{"JointDoesNotFollow", "fault", "a joint does not follow its command", 1, "freeze@1000",
            ", following_error: 0.1"},
        Row{"JointFarOutsideItsLimits", "fault", "a joint is far outside its limits", 1, "jump@4500=0.025",
            "", "", [](Rows&) {}, false, 2.995, 4},
        Row{"ControllerFails", "fault", "a controller failed", 1, "", "", "",
            [](Rows&) { Runaway::fails = true; }, true},
        Row{"LateCyclesHold", "held", "cycles were late", 210, "", "", kOverrun + "hold}\n",
            [](Rows& rows) { rows.wakes_late = true; }},
        Row{"LateCyclesFault", "fault", "cycles were late", 80, "", "", kOverrun + "fault}\n",
            [](Rows& rows) { rows.wakes_late = true; }},
        Row{"WallTimeWentMissing", "held", "wall time was lost", 200, "", "", "",
            [](Rows& rows) { rows.gap = true; }},
        Row{"CellThreadIsSilent", "held", "the cell thread was silent", 700, "", "", "",
            [](Rows& rows) { rows.silent = rows.loop().supervisor().watch_cell = true; }},
        Row{"StopIsAskedFor", "held", "a stop was requested", 200, "", "", "", stop},
        Row{"StopIsAskedForTwice", "held", "a stop was requested", 70, "", "", "",
            [](Rows& rows) {
              stop(rows);
              rows.loop().supervisor().latch().request(realtime::StopKind::immediate);
            }}),
    [](const testing::TestParamInfo<Row>& row) { return std::string(row.param.name); });

TEST(FaultRow, LateCyclesThatAreOnlyReportedStopNothing) {
  Rows rows("", "", kOverrun + "report}\n", false);
  rows.move(1.5, 2);
  rows.run(kHappens);
  rows.wakes_late = true;
  rows.run(1500);
  EXPECT_EQ(rows.health()["state"], "running");
  EXPECT_NEAR(rows.cell().value_of("states", "arm/a/position"), 1.5, 1e-6);
  EXPECT_GE(rows.health()["late"].get<int>(), 1500) << rows.health();
}

}  // namespace
}  // namespace polyarm
