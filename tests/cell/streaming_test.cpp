/// Targets that are streamed to a whole cell, in lock-step: how closely they are followed, and what happens
/// when they come late, jump, or stop.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

class StreamingTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + std::string(POLYARM_SOURCE_DIR) +
                                  "/examples/r6bot/r6bot.urdf, hardware: mock}\n" + more);
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
    cell->run(0.05);
    const Json bent = cell->result({{"request", "jog"},
                                    {"joints", {{"joint_2", 0.5}, {"joint_3", 1.0}, {"joint_5", 0.8}}},
                                    {"by", true}});
    ASSERT_TRUE(bent.value("done", false)) << bent;
    cell->run(0.5);
    begin = cell->cell().tcp(0).position;
    const CellRobot& robot = *cell->cell().robots()[0];
    before.assign(robot.joints.size(), NAN);
  }
  double now() { return seconds(cell->cell().loop().cycle().time); }
  void send(Json request) {
    request["request"] = "target";
    request["hold"] = 0.1;
    if (session > 0) request["session"] = session;
    const auto answers = cell->give(request);
    for (int i = 0; session == 0 && answers->empty() && i < 100; ++i) tick();
    if (session == 0 && !answers->empty() && answers->back().value("ok", false))
      session = answers->back()["result"]["session"].get<int>();
  }
  void send(const Vec3& p) { send(Json{{"pose", {{"position", {p.x, p.y, p.z}}}}}); }
  /// A tick; looks at the joints' speeds.
  void tick() {
    cell->tick();
    const CellRobot& robot = *cell->cell().robots()[0];
    for (std::size_t j = 0; j < before.size(); ++j) {
      const auto index = cell->cell().loop().table().find_command(robot.joints[j].name + "/position");
      const double q = cell->cell().snapshot().commands[*index];
      if (std::isfinite(before[j]))
        fastest =
            std::max(fastest, std::abs(q - before[j]) / seconds(Cell::kTick) / robot.joints[j].velocity);
      before[j] = q;
    }
  }
  /// Streams `at(t)`, t from now, every `period()` ticks for so many seconds; the greatest distance from
  /// where the target is at that very time, after `settle` s.
  double stream(const std::function<Vec3(double)>& at, double duration, double settle,
                const std::function<int()>& period) {
    const double t0 = now();
    double most = 0;
    for (int left = 0; now() - t0 < duration; --left) {
      if (left <= 0) {
        send(at(now() - t0));
        left = period();
      }
      tick();
      if (now() - t0 > settle)  // what the snapshot shows is of a tick ago
        most = std::max(most, norm(cell->cell().tcp(0).position - at(now() - t0 - seconds(Cell::kTick))));
    }
    return most;
  }
  Vec3 circle(double t) const {
    return begin + Vec3{0, 0.05 * std::sin(2 * t), 0.05 * (std::cos(2 * t) - 1)};
  }

  std::string more;
  Folder folder;
  std::unique_ptr<LockStepCell> cell;
  Vec3 begin;
  int session = 0;
  std::vector<double> before;
  double fastest = 0;  ///< share of a joint's limit
};

TEST_F(StreamingTest, ATargetBeyondTheLimitsIsRefusedWithJointAndValue) {
  const auto refusal = [&](Json request) {
    const auto answers = cell->give(request);
    for (int i = 0; answers->empty() && i < 100; ++i) tick();
    return answers->empty() ? std::string() : answers->back().dump();
  };
  const Vec3 there = cell->cell().tcp(0).position;
  for (const double wrong : {100.0, -1e308}) {
    const std::string why = refusal({{"request", "target"}, {"joints", {{"joint_2", wrong}}}});
    EXPECT_NE(why.find("beyond-limits"), std::string::npos) << why;
    EXPECT_NE(why.find("joint_2"), std::string::npos) << why;
  }
  for (const Json& request : {Json{{"request", "target"}, {"pose", {{"position", {1e308, 0, 0}}}}},
                              Json{{"request", "jog"}, {"joints", {{"joint_2", 1e308}}}},
                              Json{{"request", "jog"}, {"tcp", {{"z", 1e308}}}, {"by", true}},
                              Json{{"request", "move"}, {"points", {{{"joints", {{"joint_2", 100}}}}}}}})
    EXPECT_NE(refusal(request).find("\"ok\":false"), std::string::npos) << request;
  cell->run(0.2);
  EXPECT_LT(norm(cell->cell().tcp(0).position - there), 1e-9);
}

TEST_F(StreamingTest, AMovingTargetIsFollowedToMillimetres) {
  const auto line = [&](double t) { return begin + Vec3{0, 0, -0.1 * t}; };
  EXPECT_LT(stream(line, 2, 1, [] { return 5; }), 0.001);
}

TEST_F(StreamingTest, ACircleIsFollowedToMillimetres) {
  EXPECT_LT(stream([this](double t) { return circle(t); }, 6, 2, [] { return 5; }), 0.002);
  EXPECT_LE(fastest, 1 + 1e-6);
}

TEST_F(StreamingTest, TargetsMayComeEarlyAndLate) {
  std::mt19937_64 engine(3);
  const auto period = [&] { return static_cast<int>(3 + engine() % 5); };  // 6 to 14 ms
  EXPECT_LT(stream([this](double t) { return circle(t); }, 6, 2, period), 0.004);
  EXPECT_TRUE(cell->cell().loop().limits().report().empty());
}

TEST_F(StreamingTest, AStreamThatStopsComesToRest) {
  stream([this](double t) { return circle(t); }, 1, 1, [] { return 5; });
  const Vec3 last = cell->cell().tcp(0).position;
  for (int i = 0; i < 400; ++i) tick();
  const Vec3 rest = cell->cell().tcp(0).position;
  EXPECT_LT(norm(rest - last), 0.03);
  for (int i = 0; i < 100; ++i) tick();
  EXPECT_EQ(norm(cell->cell().tcp(0).position - rest), 0);
  const Json answer = cell->ask(
      {{"request", "target"}, {"pose", {{"position", {begin.x, begin.y, begin.z}}}}, {"session", session}});
  EXPECT_FALSE(answer.value("ok", true)) << "a stream that has ended begins anew";
}

TEST_F(StreamingTest, AShortGapIsBridged) {
  int sent = 0;
  const auto period = [&] { return ++sent % 40 == 0 ? 20 : 5; };  // now and then three targets are lost
  EXPECT_LT(stream([this](double t) { return circle(t); }, 5, 2, period), 0.008);
}

TEST_F(StreamingTest, AJumpIsWalkedWithinTheLimits) {
  stream([this](double) { return begin; }, 0.3, 1, [] { return 5; });
  const Vec3 there = begin + Vec3{0, 0.15, -0.1};
  fastest = 0;
  stream([&](double) { return there; }, 3, 3, [] { return 5; });
  EXPECT_LT(norm(cell->cell().tcp(0).position - there), 1e-4);
  EXPECT_GT(fastest, 0.01);
  EXPECT_LE(fastest, 1 + 1e-6);
  EXPECT_TRUE(cell->cell().loop().limits().report().empty());
}

TEST_F(StreamingTest, AJumpSaysNothingAboutASpeed) {
  stream([this](double) { return begin; }, 0.3, 1, [] { return 5; });
  const Vec3 there = begin - Vec3{0, 0, 0.06};
  double lowest = 9;
  stream([&](double) { return lowest = std::min(lowest, cell->cell().tcp(0).position.z), there; }, 1.5, 3,
         [] { return 5; });
  EXPECT_LT(norm(cell->cell().tcp(0).position - there), 1e-4);
  EXPECT_GT(lowest, there.z - 2e-4) << "not beyond it";
}

TEST_F(StreamingTest, JointsAreFollowedToo) {
  const double q0 = cell->value_of("states", "arm/joint_1/position");
  const double t0 = now();
  const auto at = [&](double t) { return q0 + 0.2 * (1 - std::cos(2 * t)); };
  double most = 0;
  for (int left = 0; now() - t0 < 4; --left) {
    if (left <= 0) send(Json{{"joints", {{"joint_1", at(now() - t0)}}}}), left = 5;
    tick();
    const auto index = cell->cell().loop().table().find_command("arm/joint_1/position");
    if (now() - t0 > 1)
      most = std::max(
          most, std::abs(cell->cell().snapshot().commands[*index] - at(now() - t0 - seconds(Cell::kTick))));
  }
  EXPECT_LT(most, 0.01);
}

}  // namespace
}  // namespace polyarm::cell
