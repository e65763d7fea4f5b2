/// Variants by number: all of them, each once, in any order the same.
#include "polyarm/sweeps/variants.hpp"

#include <gtest/gtest.h>

#include <set>

namespace polyarm::sweeps {
namespace {

Sweep small() {
  Sweep out;
  out.robots = {"a", "b", "c"};
  out.places = {Place{0.1, {}, {}, {}}, Place{0.2, {}, {}, {}}};
  out.programs = {""};
  out.speeds = {0.5, 1};
  out.faults = {Fault{}};
  out.seeds = {1, 2, 3};
  out.values = {{"Count", {"1", "2"}, {}}};
  return out;
}

std::set<std::string> keys(const Variants& variants) {
  std::set<std::string> out;
  for (std::uint64_t i = 0; i < variants.count(); ++i) out.insert(key_of(variants.at(i), "hash"));
  return out;
}

TEST(Variants, AProductHasEachCombinationOnce) {
  const Sweep sweep = small();
  const Variants variants(sweep);
  EXPECT_EQ(variants.count(), 3u * 2 * 2 * 3 * 2);
  EXPECT_EQ(keys(variants).size(), variants.count());
}

TEST(Variants, ASampleHasDifferentVariantsOfTheProduct) {
  const Sweep whole = small();
  const std::set<std::string> all = keys(Variants(whole));
  for (const std::uint64_t size : {1, 7, 71, 72, 500}) {
    Sweep sweep = small();
    sweep.sample = size;
    const Variants variants(sweep);
    const std::set<std::string> drawn = keys(variants);
    EXPECT_EQ(drawn.size(), std::min<std::uint64_t>(size, 72));
    for (const std::string& key : drawn) EXPECT_TRUE(all.contains(key));
  }
}

TEST(Variants, ALargerSampleContainsTheSmallerOne) {
  Sweep few = small(), many = small();
  few.sample = 10, many.sample = 40;
  const std::set<std::string> larger = keys(Variants(many));
  for (const std::string& key : keys(Variants(few))) EXPECT_TRUE(larger.contains(key));
}

TEST(Variants, ZippedAxesGoSideBySide) {
  Sweep sweep = small();
  sweep.combine = Combine::zip;
  sweep.places = {Place{}};
  sweep.speeds = {0.25, 0.5, 1};
  sweep.values.clear();
  const Variants variants(sweep);
  ASSERT_EQ(variants.count(), 3u);
  EXPECT_EQ(variants.at(2).robot, "c");
  EXPECT_EQ(variants.at(2).speed, 1);
  sweep.speeds.pop_back();
  EXPECT_THROW(Variants{sweep}, Error);
}

TEST(Variants, AKeyDoesNotDependOnTheNumberAndChangesWithTheRobotsDescription) {
  const Sweep sweep = small();
  Sweep longer = small();
  longer.robots.insert(longer.robots.begin(), "z");
  const Variants before(sweep), after(longer);
  EXPECT_EQ(key_of(before.at(0), "h"), key_of(after.at(before.count() / 3), "h"));
  EXPECT_NE(key_of(before.at(0), "h"), key_of(before.at(0), "other"));
}

TEST(Deviations, AreTheSameForASeedAndFillTheRange) {
  Deviations one(7), same(7);
  double least = 1, most = -1, sum = 0;
  for (int i = 0; i < 10000; ++i) {
    const double value = one.next();
    EXPECT_EQ(value, same.next());
    least = std::min(least, value), most = std::max(most, value), sum += value;
  }
  EXPECT_GE(least, -1);
  EXPECT_LT(most, 1);
  EXPECT_LT(least, -0.99);
  EXPECT_GT(most, 0.99);
  EXPECT_NEAR(sum / 10000, 0, 0.03);
}

}  // namespace
}  // namespace polyarm::sweeps
