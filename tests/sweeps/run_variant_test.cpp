/// Variants that run: what a row says, and that it says the same again.
#include "polyarm/sweeps/run_variant.hpp"

#include <gtest/gtest.h>

#include "drivers/mock/mock.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/sweeps/sweep_file.hpp"
#include "polyarm/sweeps/variants.hpp"
#include "tests/support/command.hpp"

namespace polyarm::sweeps {
namespace {

class RunVariant : public testing::Test {
 protected:
  RunVariant() : catalogue_({std::filesystem::path(POLYARM_SOURCE_DIR) / "robots"}), copy_("pick_and_place") {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  }
  /// The row of the only variant of a sweep.
  Row run(const std::string& more) {
    const Sweep sweep = read_sweep("polyarm: sweep/1\ncell: .\nhardware: mock\nprograms: flowing\n" + more,
                                   copy_.file("of_the_test.yaml"), catalogue_);
    const Variants variants(sweep);
    EXPECT_EQ(variants.count(), 1u);
    return run_variant(sweep, variants.at(0), "key", catalogue_,
                       copy_.file(".state") / ("data" + std::to_string(runs_++)));
  }

  description::Catalogue catalogue_;
  test::ExampleCopy copy_;
  int runs_ = 0;
};

TEST_F(RunVariant, TheSameVariantGivesTheSameRow) {
  const std::string more =
      "stop_after: {cycles: 2}\nbase: {x: 0.02}\nvary: {base: 1mm, points: {PrePick: 1mm}}\nseeds: 7\n";
  const Row row = run(more);
  EXPECT_EQ(row.ended, "completed") << row.cause;
  EXPECT_EQ(*row.cycles, 2);
  EXPECT_GT(*row.cycle_s, 1);
  EXPECT_LE(*row.cycle_s, *row.cycle_p95_s);
  EXPECT_GT(*row.path_m, 1);
  EXPECT_GT(*row.speed_share, 0.2);
  EXPECT_LT(*row.speed_share, 1.01);
  EXPECT_EQ(*row.out_of_reach, 0);
  EXPECT_TRUE(row.clearance_m);
  EXPECT_EQ(to_json(row), to_json(run(more)));
}

TEST_F(RunVariant, ASlowerOverrideTakesLonger) {
  const Row fast = run("stop_after: {cycles: 2}\n"), slow = run("stop_after: {cycles: 2}\nspeeds: 50%\n");
  EXPECT_GT(*slow.cycle_s, 1.5 * *fast.cycle_s);
  EXPECT_LT(*slow.speed_share, 0.6 * *fast.speed_share);
}

TEST_F(RunVariant, ABaseThatIsTooFarNamesThePointAndTheLine) {
  const Row row = run("base: {x: -1.5}\n");
  EXPECT_EQ(row.ended, "failed");
  EXPECT_EQ(row.code, "unreachable") << row.cause;
  EXPECT_EQ(row.place.substr(0, 15), "flowing.script:");
  EXPECT_EQ(*row.out_of_reach, 7);
}

TEST_F(RunVariant, ASeedMovesTheBaseByLittle) {
  const Row one = run("stop_after: {cycles: 1}\nvary: {base: 5mm, yaw: 2deg}\nseeds: 1\n"),
            two = run("stop_after: {cycles: 1}\nvary: {base: 5mm, yaw: 2deg}\nseeds: 2\n");
  EXPECT_NE(one.trace, two.trace);
}

TEST_F(RunVariant, AFaultThatPassesCostsTime) {
  const Row whole = run("stop_after: {cycles: 1}\n"),
            stuck =
                run("stop_after: {cycles: 1, seconds: 40}\n"
                    "faults: {sensor: {at: 0s, for: 2500ms, force: {arm/tool/part_present: 0}}}\n");
  EXPECT_EQ(stuck.ended, "completed") << stuck.cause;
  EXPECT_EQ(stuck.fault, "sensor");
  EXPECT_GT(*stuck.cycle_s, *whole.cycle_s + 0.5);
}

TEST_F(RunVariant, ACauseNamesFilesAsTheCellDoes) {
  const Row row = run("stop_after: {cycles: 1}\nfaults: {stuck: {force: {scene/feeder/feed: 0}}}\n");
  EXPECT_EQ(row.code, "deadlock");
  EXPECT_NE(row.cause.find(" flowing.script:9"), std::string::npos) << row.cause;
  EXPECT_EQ(row.cause.find(copy_.path()), std::string::npos) << row.cause;
}

TEST_F(RunVariant, AHoldThatNobodyEndsIsAFailureAndAResumeEndsIt) {
  const Row held = run("stop_after: {cycles: 1}\nfaults: {held: {at: 1s, person: hold}}\n");
  EXPECT_EQ(held.code, "held") << held.cause;
  const Row resumed =
      run("stop_after: {cycles: 1}\nfaults: {held: [{at: 1s, person: hold}, {at: 3s, person: resume}]}\n");
  EXPECT_EQ(resumed.ended, "completed") << resumed.cause;
}

TEST_F(RunVariant, AnEmergencyStopHoldsTheCell) {
  const Row row = run("stop_after: {cycles: 1}\nfaults: {e: {at: 1s, emergency_stop: true}}\n");
  EXPECT_EQ(row.ended, "failed");
  EXPECT_EQ(row.code, "held") << row.cause;
}

TEST_F(RunVariant, ValuesAreSetBeforeTheStartAndUnknownOnesNamed) {
  const Row none = run("values: {Repeat: [false]}\n");
  EXPECT_EQ(none.given, "Repeat=false");
  EXPECT_EQ(none.parts, 0);
  const Row wrong = run("values: {Repaet: [false]}\n");
  EXPECT_EQ(wrong.code, "unknown-name");
  EXPECT_NE(wrong.cause.find("did you mean 'Repeat'"), std::string::npos) << wrong.cause;
}

TEST_F(RunVariant, TheTimeIsUpWhereAProgramDoesNotEnd) {
  const Row row = run("stop_after: {seconds: 2}\n");
  EXPECT_EQ(row.ended, "time-up");
  EXPECT_EQ(row.code, "too-long");
}

TEST_F(RunVariant, ClearanceIsRequiredWhereTheFileSaysSo) {
  const Row row = run("stop_after: {cycles: 1}\nmeasure: {clearance: 200mm}\nrequire: {clearance: 200mm}\n");
  EXPECT_EQ(row.code, "clearance") << row.cause;
  EXPECT_LT(*row.clearance_m, 0.2);
}

TEST(Percentile, IsTheNearestRank) {
  EXPECT_EQ(percentile({}, 0.95), 0);
  EXPECT_EQ(percentile({3}, 0.95), 3);
  EXPECT_EQ(percentile({4, 1, 3, 2}, 0.5), 2);
  EXPECT_EQ(percentile({4, 1, 3, 2}, 0.95), 4);
}

}  // namespace
}  // namespace polyarm::sweeps
