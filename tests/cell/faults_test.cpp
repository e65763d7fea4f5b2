/// Every fault ends in the same way: what works on it lies still, a person brings it back step by step, and
/// it goes on from where it is measured.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <thread>

#include "polyarm/io/worker.hpp"
#include "polyarm/machine/fault_record.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

const std::string kFollowAndStates = R"(
controller_manager:
  ros__parameters:
    update_rate: 1000
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
follow:
  ros__parameters:
    joints: [a, b]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
)";

std::string two_joints(const std::string& parameters) {
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child) {
    return "<joint name='" + name + "' type='revolute'><parent link='" + parent + "'/><child link='" + child +
           "'/><axis xyz='0 0 1'/><limit lower='-3' upper='3' velocity='2' effort='10'/></joint>";
  };
  const auto driven = [&](const std::string& name) {
    return "<joint name='" + name +
           "'><command_interface name='position'/><state_interface name='position'/>"
           "<state_interface name='velocity'/></joint>";
  };
  return "<robot name='arm'><link name='l0'/><link name='l1'/><link name='l2'/>" + joint("a", "l0", "l1") +
         joint("b", "l1", "l2") +
         "<ros2_control name='drives' "
         "type='system'><hardware><plugin>mock_components/GenericSystem</plugin>" +
         parameters + "</hardware>" + driven("a") + driven("b") + "</ros2_control></robot>";
}

std::string injected(const std::string& faults, const std::string& more = "") {
  return two_joints("<param name='inject'>" + faults + "</param>" + more);
}

const Json kMove = {
    {"request", "send"},
    {"to", "follow"},
    {"message",
     {{"joint_names", {"a", "b"}}, {"points", {{{"positions", {1.5, -1.5}}, {"time_from_start", 2.0}}}}}}};

struct InjectedFault {
  const char* name;
  std::string inject;
  std::string more;   ///< parameters
  std::string cause;  ///< as health tells it
  std::string told;   ///< part of why the component failed
};

class FaultTable : public testing::TestWithParam<InjectedFault> {};

TEST_P(FaultTable, EndsTheSameWay) {
  const Folder folder;
  LockStepCell cell(folder.write("arm.urdf", injected(GetParam().inject, GetParam().more)), kFollowAndStates);
  cell.give(kMove);
  cell.run(1.2);
  Json health = cell.result({{"request", "health"}});
  ASSERT_EQ(health["state"], "fault") << health;
  EXPECT_EQ(health["cause"], GetParam().cause);
  EXPECT_EQ(cell.state_of("follow"), "inactive") << "its component is gone";
  const std::string reason = cell.cell().loop().hardware().diagnostics().reason(0);
  EXPECT_NE(reason.find(GetParam().told), std::string::npos) << reason;

  // No single request moves it.
  cell.result({{"request", "control.resume"}});
  cell.run(0.02);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "fault");
  const Json back = cell.result({{"request", "hardware.recover"}, {"name", "drives"}});
  EXPECT_EQ(back["state"], "active") << back;
  cell.run(0.02);
  const double at = cell.value_of("states", "arm/a/position");
  cell.result({{"request", "control.recover"}});
  cell.run(0.02);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "held");
  cell.result({{"request", "control.switch"}, {"activate", {"follow"}}});
  EXPECT_EQ(cell.state_of("follow"), "active");
  cell.run(0.05);
  EXPECT_NEAR(cell.value_of("states", "arm/a/position"), at, 1e-9) << "held";
  cell.result({{"request", "control.resume"}});
  cell.run(0.1);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "running");
  EXPECT_NEAR(cell.value_of("states", "arm/a/position"), at, 1e-9) << "the old motion is forgotten";
}

const std::string kFailed = "a hardware component failed";
INSTANTIATE_TEST_SUITE_P(
    All, FaultTable,
    testing::Values(InjectedFault{"read", "read_error@500", "", kFailed, "injected fault: read_error"},
                    InjectedFault{"write", "write_error@500", "", kFailed, ""},
                    InjectedFault{"deactivate", "deactivate@500", "", kFailed, "deactivate at cycle 500"},
                    InjectedFault{"nan", "nan@500:b", "", "a measured joint position is NaN or infinite",
                                  "arm/b/position became NaN or infinite"},
                    InjectedFault{"jump", "jump@500:a=0.6", "", "a measured joint position jumped",
                                  "arm/a/position changed by more"},
                    InjectedFault{"freeze", "freeze@300", "<param name='following_error'>0.2</param>",
                                  "a joint does not follow its command", "arm/a/position is more than 0.2"}),
    [](const testing::TestParamInfo<InjectedFault>& row) { return row.param.name; });

TEST(Faults, AThousandWaitingRequestsDoNotDelayAStopByACycle) {
  const Folder folder;
  std::string controllers = kFollowAndStates;
  controllers.replace(controllers.find("update_rate: 1000"), 17, "update_rate: 10");
  LockStepCell cell(folder.write("arm.urdf", two_joints("")), controllers);
  cell.give(kMove);
  cell.run(0.8);
  const double at = cell.value_of("states", "arm/a/position");
  ASSERT_TRUE(at > 0.05 && at < 1.4) << "it moves";
  for (int k = 0; k < 1000; ++k) cell.give(Json{{"request", "control.switch"}, {"activate", {"states"}}});
  for (int k = 0; k < 64; ++k) cell.cell().loop().post(control::Request::discard);
  cell.cell().loop().supervisor().latch().request(realtime::StopKind::controlled);
  const controllers::Verdict verdict = cell.cell().loop().step_next();
  EXPECT_EQ(verdict.speed, 0);
  EXPECT_EQ(cell.cell().loop().supervisor().state(), control::RunState::stopping);
}

TEST(Faults, ASmallStepIsNoJump) {
  const Folder folder;
  LockStepCell cell(folder.write("arm.urdf", injected("jump@500:a=0.015")), kFollowAndStates);
  cell.give(kMove);
  cell.run(1);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "running");
}

TEST(Faults, ASlowReadIsCountedAndNothingElse) {
  const Folder folder;
  LockStepCell cell(folder.write("arm.urdf", injected("slow@500=2")), kFollowAndStates);
  cell.give(kMove);
  cell.run(1);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "running");
  EXPECT_GT(cell.result({{"request", "health"}})["cost"]["max_ns"].get<double>(), 2e6);
}

TEST(Faults, WhatCannotBeInjectedIsRefusedWithWhatCan) {
  for (const char* wrong : {"nann@500", "nan@x", "nan@5:elbow", "jump@1:a=much", "slow@-1"}) {
    const Folder folder;
    try {
      LockStepCell cell(folder.write("arm.urdf", injected(wrong)), kFollowAndStates);
      FAIL() << wrong;
    } catch (const Error& e) {
      EXPECT_EQ(e.problems().at(0).code, "bad-value") << wrong;
    }
  }
}

/// A real component is one that says so.
class RealMock : public drivers::MockComponent {
 public:
  bool real() const noexcept override { return true; }
};

std::unique_ptr<test::OpenCell> real_cell(const Folder& folder, bool real, bool full_speed,
                                          cell::Observer& observer, bool lock_step = false,
                                          const std::string& driver = "real_mock",
                                          const std::string& urdf = two_joints(""), int rate = 1000,
                                          std::string controllers = kFollowAndStates) {
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  hardware::register_driver("real_mock", [] { return std::unique_ptr<hardware::Component>(new RealMock); });
  std::string text = urdf;
  text.replace(text.find("mock_components/GenericSystem"), 29, driver);
  controllers.replace(controllers.find("1000"), 4, std::to_string(rate));
  cell::CellOptions options;
  options.real = real;
  options.full_speed = full_speed;
  options.lock_step = lock_step;
  auto out = std::make_unique<test::OpenCell>(
      cell::cell_from_description(folder.write("arm.urdf", text), {folder.write("c.yaml", controllers)}, {}),
      description::Catalogue({}), options, observer);
  out->loop().begin();
  return out;
}

void run(test::OpenCell& cell, double s) {
  for (const Nanoseconds end = cell.loop().cycle().time + nanoseconds(s); cell.loop().cycle().time < end;) {
    cell.tick(cell.loop().cycle().time);
    for (int k = 0; k < 2; ++k) cell.loop().step_next();
  }
}

Json ask(test::OpenCell& cell, const Json& request) {
  auto out = std::make_shared<Json>();
  cell.requests().handle(request.dump(), [out](const std::string& line) {
    *out = Json::parse(line);
    return true;
  });
  for (int k = 0; k < 30'000 && out->is_null(); ++k) {
    if (k > 50) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // a worker reads files
    hardware::Hardware& hardware = cell.loop().hardware();
    for (std::size_t i = 0; i < hardware.size(); ++i)  // callbacks run on threads of their own
      if (const hardware::Transition* pending = hardware.pending(i)) pending->wait(60'000'000'000);
    cell.worker().drain();  // descriptions are read beside the cell
    run(cell, 0.002);
  }
  return *out;
}

double position(test::OpenCell& cell) {
  cell.loop().outbox().fetch();
  return cell.snapshot().states[*cell.loop().table().find_state("arm/a/position")];
}

TEST(Arming, WithoutRealTheCellIsSimulatedAndSaysSo) {
  const Folder folder;
  struct Notes : cell::Observer {
    std::string all;
    void on_note(const std::string& text) override { all += text + "\n"; }
  } notes;
  const auto cell = real_cell(folder, false, false, notes);
  EXPECT_TRUE(cell->arming().armed());
  EXPECT_NE(notes.all.find("real_mock drives real hardware; it is simulated by"), std::string::npos)
      << notes.all;
  EXPECT_EQ(ask(*cell, {{"request", "control.arm"}})["error"]["code"], "not-real");
  cell->loop().end();
}

TEST(Arming, NothingMovesBeforeAPersonHasArmedIt) {
  const Folder folder;
  cell::Observer nobody;
  const auto cell = real_cell(folder, true, true, nobody);
  EXPECT_FALSE(cell->arming().armed());
  run(*cell, 0.05);
  EXPECT_EQ(ask(*cell, kMove)["ok"], false) << "its controller is not active";
  run(*cell, 0.5);
  EXPECT_EQ(position(*cell), 0);
  const Json seen = ask(*cell, {{"request", "control.arm"}});
  EXPECT_EQ(seen["result"]["armed"], false) << "asking is not confirming";
  EXPECT_EQ(seen["result"]["joints"].size(), 2u);
  const Json armed = ask(*cell, {{"request", "control.arm"}, {"confirmed", true}});
  EXPECT_EQ(armed["result"]["started"].dump(), R"(["follow"])") << armed;
  EXPECT_TRUE(cell->arming().armed());
  EXPECT_EQ(ask(*cell, kMove)["ok"], true);
  run(*cell, 2.5);
  EXPECT_NEAR(position(*cell), 1.5, 1e-6);
  cell->loop().end();
}

/// Of two that command a joint in two ways one was chosen when the cell was built; arming starts no other.
TEST(Arming, WhatStaysInactiveInASimulatedCellIsNotStartedByArming) {
  std::string urdf =
      two_joints("<param name='calculate_dynamics'>true</param>");  // it refuses both ways at once
  for (const std::string joint : {"a", "b"}) {
    const std::string driven = "<joint name='" + joint + "'><command_interface name='position'/>";
    urdf.replace(urdf.find(driven), driven.size(), driven + "<command_interface name='velocity'/>");
  }
  std::string controllers = kFollowAndStates;
  controllers.insert(controllers.find("    follow:"),
                     "    speeds: {type: forward_command_controller/ForwardCommandController}\n");
  controllers += "speeds:\n  ros__parameters: {joints: [a, b], interface_name: velocity}\n";
  for (const bool real : {false, true}) {
    const Folder folder;
    cell::Observer nobody;
    const auto cell = real_cell(folder, real, true, nobody, false, "real_mock", urdf, 1000, controllers);
    run(*cell, 0.05);
    if (real) {
      Json armed = ask(*cell, {{"request", "control.arm"}, {"confirmed", true}});
      EXPECT_EQ(armed["result"]["started"].dump(), R"(["follow"])") << armed["error"];
    }
    std::map<std::string, std::string> states;
    const Json all = ask(*cell, {{"request", "control.list"}});
    for (const Json& c : all["result"]) states[c["name"]] = c["state"];
    EXPECT_EQ(states["follow"], "active") << (real ? "armed" : "simulated");
    EXPECT_EQ(states["speeds"], "inactive") << (real ? "armed" : "simulated");
    EXPECT_TRUE(cell->arming().armed());
    cell->loop().end();
  }
}

TEST(Arming, GoesOnWithoutAControllerThatWasUnloadedBefore) {
  const Folder folder;
  cell::Observer nobody;
  const auto cell = real_cell(folder, true, true, nobody);
  run(*cell, 0.05);
  ask(*cell, {{"request", "control.unload"}, {"name", "follow"}});
  Json armed = ask(*cell, {{"request", "control.arm"}, {"confirmed", true}});
  EXPECT_EQ(armed["result"]["started"].dump(), "[]") << armed;
  EXPECT_TRUE(cell->arming().armed());
  cell->loop().end();
}

TEST(Arming, NoOtherRequestEnablesWhatIsDisarmed) {
  const Folder folder;
  cell::Observer nobody;
  const auto cell = real_cell(folder, true, true, nobody);
  run(*cell, 0.05);
  const auto state = [&] { return ask(*cell, {{"request", "hardware.list"}})["result"][0]["state"]; };
  for (const Json& request : {Json{{"request", "hardware.state"}, {"name", "drives"}, {"state", "active"}},
                              Json{{"request", "hardware.recover"}, {"name", "drives"}},
                              Json{{"request", "program.from"}, {"program", "job"}, {"confirmed", true}}}) {
    EXPECT_EQ(ask(*cell, request)["error"]["code"], "disarmed") << request;
    EXPECT_NE(state(), "active") << request;
  }
  ask(*cell, {{"request", "control.arm"}, {"confirmed", true}});
  EXPECT_EQ(state(), "active");
  ask(*cell, {{"request", "hardware.state"}, {"name", "drives"}, {"state", "inactive"}});
  ask(*cell, {{"request", "hardware.state"}, {"name", "drives"}, {"state", "active"}});
  EXPECT_EQ(state(), "active") << "armed is armed";
  cell->loop().end();
}

TEST(Arming, WhatAReloadMakesRealWaitsForAPerson) {
  const Folder folder;
  cell::Observer nobody;
  const auto cell = real_cell(folder, true, true, nobody, false, "mock_components/GenericSystem");
  run(*cell, 0.05);
  EXPECT_TRUE(cell->arming().armed()) << "nothing is real yet";
  std::string text = two_joints("");
  text.replace(text.find("mock_components/GenericSystem"), 29, "real_mock");
  folder.write("arm.urdf", text);
  const Json answer = ask(*cell, {{"request", "hardware.reload"}, {"name", "drives"}});
  EXPECT_NE(answer["result"]["next"].dump().find("control arm"), std::string::npos) << answer;
  EXPECT_EQ(ask(*cell, {{"request", "hardware.list"}})["result"][0]["state"], "inactive");
  EXPECT_FALSE(cell->arming().armed());
  ask(*cell, {{"request", "control.arm"}, {"confirmed", true}});
  EXPECT_EQ(ask(*cell, {{"request", "hardware.list"}})["result"][0]["state"], "active");
  cell->loop().end();
}

TEST(Arming, TheFirstPassIsATenthOfTheSpeed) {
  const Folder folder;
  cell::Observer nobody;
  const auto cell = real_cell(folder, true, false, nobody);
  run(*cell, 0.01);
  ask(*cell, {{"request", "control.arm"}, {"confirmed", true}});
  ask(*cell, kMove);
  double fastest = 0, before = position(*cell);
  for (int k = 0; k < 2000; ++k) {
    run(*cell, 0.002);
    const double now = position(*cell);
    fastest = std::max(fastest, std::abs(now - before) / 0.002);
    before = now;
  }
  EXPECT_GT(fastest, 0.05) << "it does move";
  EXPECT_LE(fastest, 0.2 * 1.001) << "a tenth of 2 rad/s";
  cell->loop().end();
}

/// On the wall clock a slow loop has one cycle in many ticks, and stands still in none of them.
TEST(Arming, TheFirstPassReachesATenthAtAnyRateOfTheLoop) {
  for (const int rate : {10, 30, 100, 500}) {
    const Folder folder;
    cell::Observer nobody;
    const auto cell = real_cell(folder, true, false, nobody, false, "real_mock", two_joints(""), rate);
    control::ControlLoop& loop = cell->loop();
    const auto cycle = [&] {
      for (int tick = 0; tick < 500 / rate; ++tick) cell->tick(loop.cycle().time);
      loop.step_next();
    };
    for (int k = 0; k < 3; ++k) cycle();
    ask(*cell, {{"request", "control.arm"}, {"confirmed", true}});
    ask(*cell, kMove);
    double fastest = 0, before = position(*cell);
    for (int k = 0; k < 12 * rate; ++k) {
      cycle();
      const double now = position(*cell);
      fastest = std::max(fastest, std::abs(now - before) * rate);
      before = now;
    }
    EXPECT_GT(fastest, 0.07) << rate << " Hz: a tenth of what was planned, about";
    EXPECT_LE(fastest, 0.2 * 1.001) << rate << " Hz";
    cell->loop().end();
  }
}

/// A tenth of what these joints may would be 0.6 m/s at the TCP of an arm of 3 m.
TEST(Arming, TheFirstPassKeepsTheTcpOfALongArmSlow) {
  const Folder folder;
  cell::Observer nobody;
  std::string urdf = two_joints("");
  for (const std::string end : {"<child link='l2'/>"})
    urdf.replace(urdf.find(end), end.size(), end + "<origin xyz='1.5 0 0'/>");
  urdf.replace(urdf.find("<link name='l2'/>"), 17,
               "<link name='l2'/><link name='tool0'/><joint name='end' type='fixed'><parent link='l2'/>"
               "<child link='tool0'/><origin xyz='1.5 0 0'/></joint>");
  const auto cell = real_cell(folder, true, false, nobody, false, "real_mock", urdf);
  run(*cell, 0.01);
  ask(*cell, {{"request", "control.arm"}, {"confirmed", true}});
  ASSERT_NEAR(cell->tcp(0).position.x, 3, 1e-9);
  ask(*cell, kMove);
  double fastest = 0;
  Vec3 before = cell->tcp(0).position;
  for (int k = 0; k < 5000; ++k) {
    run(*cell, 0.002);
    const Vec3 now = cell->tcp(0).position;
    fastest = std::max(fastest, norm(now - before) / 0.002);
    before = now;
  }
  EXPECT_GT(fastest, 0.1) << "it does move";
  EXPECT_LE(fastest, 0.25);
  cell->loop().end();
}

TEST(Arming, RealHardwareDoesNotRunInLockStep) {
  const Folder folder;
  cell::Observer nobody;
  try {
    real_cell(folder, true, false, nobody, true);
    FAIL() << "was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).code, "real-and-fast");
  }
}

TEST(FaultRecord, TheOldestMakeRoomAndWhatHasANameStays) {
  const Folder folder;
  const std::filesystem::path faults = folder.path() / ".state/faults";
  for (const std::string name : {"0007", "0123", "crash on monday"})
    std::filesystem::create_directories(faults / name);
  cell::FaultRecord record;
  record.cell_folder = folder.path();
  control::BlackBox box;
  box.build(1, 1, 1);
  record.stopped = &box;
  for (int k = 0; k < 60; ++k) ASSERT_FALSE(cell::write_record(record, "faults").empty());
  const auto count = std::distance(std::filesystem::directory_iterator(faults), {});
  EXPECT_EQ(count, 51);
  EXPECT_TRUE(std::filesystem::exists(faults / "0183/cycles.csv")) << "numbers go on";
  EXPECT_FALSE(std::filesystem::exists(faults / "0133"));
  EXPECT_TRUE(std::filesystem::exists(faults / "0134"));
  EXPECT_TRUE(std::filesystem::exists(faults / "crash on monday"));
}

TEST(FaultRecord, IsWrittenWithEveryFaultAndPlaysAgain) {
  const Folder folder;
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  const std::string urdf = folder.write("arm.urdf", injected("read_error@700"));
  struct Notes : cell::Observer {
    std::string all;
    void on_note(const std::string& text) override { all += text + "\n"; }
  } notes;
  cell::CellFile file = cell::cell_from_description(urdf, {folder.write("c.yaml", kFollowAndStates)}, {});
  file.folder = folder.path();
  test::OpenCell cell(file, description::Catalogue({}), {}, notes);  // on the wall clock: the run goes on
  cell.loop().begin();
  ask(cell, kMove);
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (notes.all.find("polyarm replay ") == std::string::npos &&
         std::chrono::steady_clock::now() < patience) {
    run(cell, 0.01);
    cell.worker().drain();  // what writes the record
  }
  cell.loop().end();
  const std::filesystem::path record = folder.path() / ".state/faults/0001";
  ASSERT_TRUE(std::filesystem::exists(record / "cycles.csv")) << notes.all;
  const cell::Replay replay = cell::replay_record(record, "mock");
  EXPECT_NE(replay.problem.find("a hardware component failed"), std::string::npos) << replay.problem;
  EXPECT_GT(replay.recorded.rows.size(), 700u);
  ASSERT_EQ(replay.joints.size(), 2u);
  // The recorded robot followed at once, and so does the one that is given its commands again, until the
  // fault cut the recorded one off.
  EXPECT_LT(replay.joints[0].worst, 2e-2);
  bool fault = false;
  for (const auto& row : replay.recorded.rows) fault = fault || row.state == "fault";
  EXPECT_TRUE(fault);
}

TEST(FaultRecord, WhatIsNoRecordIsRefusedByLine) {
  const Folder folder;
  const auto code = [&](const std::string& text) {
    folder.write("cycles.csv", text);
    try {
      cell::read_cycles(folder.path() / "cycles.csv");
      return std::string("none");
    } catch (const Error& e) {
      return e.problems().at(0).code;
    }
  };
  const std::string head = "cycle,state,cause,request,arm/a/position,command:arm/a/position\n";
  EXPECT_EQ(code(""), "no-record");
  EXPECT_EQ(code("a,b\n"), "no-record");
  EXPECT_EQ(code(head), "no-record") << "no cycles";
  EXPECT_EQ(code(head + "1,running,0,none,0.5\n"), "no-record");
  EXPECT_EQ(code(head + "1,running,0,none,0.5,x\n"), "no-record");
  EXPECT_EQ(code(head + "-1,running,0,none,0.5,0\n"), "no-record");
  EXPECT_EQ(code(head + "1e300,running,0,none,0.5,0\n"), "no-record");
  EXPECT_EQ(code(head + "1,running,0,none,0.5,nan\n"), "none");
  for (const char* period : {"0", "-1", "1e300", "1e-300"}) {
    folder.write("fault.txt", std::string("polyarm: fault/1\nperiod: ") + period + "\nwhat happened\n");
    EXPECT_THROW(cell::replay_record(folder.path(), "mock"), Error) << period;
  }
}

}  // namespace
}  // namespace polyarm
