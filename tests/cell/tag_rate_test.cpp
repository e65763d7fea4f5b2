#include "polyarm/setup/tag_rate.hpp"

#include <gtest/gtest.h>

namespace polyarm::cell {
namespace {

TEST(TagRate, PrintsSoManyChangesOfATagASecondAndCountsTheOthers) {
  TagRate rate;
  std::size_t shown = 0, left_out = 0;
  constexpr Nanoseconds kTick = 2'000'000;
  for (Nanoseconds t = 0; t < 3'000'000'000; t += kTick) {  // 500 a second
    const TagRate::Verdict verdict = rate.look(t, "Chatty");
    shown += verdict.shown ? 1 : 0;
    left_out += verdict.left_out;
    EXPECT_TRUE(t % 100'000'000 != 0 || rate.look(t, "Quiet").shown) << "each tag is counted apart";
  }
  EXPECT_EQ(shown, 3 * TagRate::kMostASecond);
  EXPECT_EQ(left_out, 2 * (500 - TagRate::kMostASecond)) << "reported when the next second begins";
  EXPECT_EQ(rate.look(4'000'000'000, "Chatty").left_out, 500 - TagRate::kMostASecond);
}

}  // namespace
}  // namespace polyarm::cell
