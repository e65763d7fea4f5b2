/// A truck that steers, in physics.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <functional>

#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using nlohmann::json;
using test::Command;
using test::Finished;
using test::run_command;
namespace fs = std::filesystem;

TEST(Forklift, BacksIntoTheRackAndOutAgain) {
  const test::ExampleCopy copy("forklift");
  const Finished ran = run_command({"run", copy.path(), "--fast", "--seconds", "60", "--json"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed") << ran.output;
}

class SteeredForklift : public ::testing::Test {
 protected:
  SteeredForklift() {
    std::string pattern = (fs::temp_directory_path() / "polyarm_forklift_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    ::setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
  }
  ~SteeredForklift() override {
    ::unsetenv("XDG_RUNTIME_DIR");
    fs::remove_all(folder);
  }
  static double state(const std::string& name) {
    const Finished finished = run_command({"interfaces", "--json"});
    const json all = finished.exit_code == 0 ? json::parse(finished.output, nullptr, false) : json();
    if (!all.is_object()) return NAN;
    for (const json& s : all["states"])
      if (s["name"] == name) return s["value"].is_number() ? s["value"].get<double>() : NAN;
    return NAN;
  }
  /// Asks again and again, each time a process; a generous number of times.
  static bool comes_true(const std::function<bool()>& claim) {
    for (int tries = 0; tries < 5000; ++tries)
      if (claim()) return true;
    return false;
  }
  fs::path folder;
  const test::ExampleCopy copy{"forklift"};
};

TEST_F(SteeredForklift, KnowsWhereItIsAfterAHalfTurn) {
  Command cell({"run", copy.path() + "/driving.yaml", "--json"});
  ASSERT_TRUE(comes_true([] { return run_command({"health"}).exit_code == 0; }));
  if (!std::isfinite(state("truck/base/position.x"))) GTEST_SKIP() << "physics is not built";
  Command twist(
      {"send", "truck_controller/reference", "{linear: {x: 0.4}, angular: {z: 0.25}}", "--rate", "20"});
  EXPECT_TRUE(comes_true([] { return state("truck/base/position.y") > 1.5; })) << "around to the left";
  twist.signal(SIGINT);
  twist.wait();
  ASSERT_TRUE(comes_true([] { return std::abs(state("truck/left_wheel_joint/velocity")) < 0.01; }))
      << "reference_timeout";
  const json at =
      run_command({"watch", "odometry", "--count", "1", "--json"}).result()["pose"]["pose"]["position"];
  EXPECT_NEAR(at["x"].get<double>(), state("truck/base/position.x"), 0.1) << "its wheels slip a little";
  EXPECT_NEAR(at["y"].get<double>(), state("truck/base/position.y"), 0.1);
  EXPECT_GT(state("truck/steering_joint/position"), 0.4) << "the steering stays";
}

}  // namespace
}  // namespace polyarm
