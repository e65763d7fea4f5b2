#include "polyarm/signals/mailbox_merge.hpp"

#include <gtest/gtest.h>

#include <random>

namespace polyarm::signals {
namespace {

using data::Value;

TEST(MailboxMerge, TakesOnlyWhatTheOtherSideChanged) {
  MailboxMerge merge({{"A", false}, {"B", 1}});
  merge.set("A", true);
  const auto result = merge.outside({{"A", false}, {"B", 2}});  // had read the start
  EXPECT_EQ(result.changes, (std::vector<std::pair<std::string, Value>>{{"B", 2}}));
  EXPECT_EQ(merge.present(), (Values{{"A", true}, {"B", 2}}));
  EXPECT_TRUE(result.write_back);
}

TEST(MailboxMerge, AReadBeforeOurWriteAndARewriteAfterItLoseNothing) {
  MailboxMerge merge({{"mine", 0}, {"theirs", 0}});
  for (int i = 1; i <= 5; ++i) {
    merge.set("mine", i);
    merge.wrote();
  }
  const auto result = merge.outside({{"mine", 2}, {"theirs", 7}});
  EXPECT_EQ(result.base, 2u);
  EXPECT_EQ(merge.present(), (Values{{"mine", 5}, {"theirs", 7}}));
  EXPECT_TRUE(result.write_back);
}

TEST(MailboxMerge, ARewriteOfTheNewestVersionIsNotWrittenBack) {
  MailboxMerge merge({{"A", false}});
  merge.set("A", true);
  merge.wrote();
  EXPECT_FALSE(merge.outside({{"A", true}}).write_back);
  EXPECT_FALSE(merge.outside({{"A", true}, {"New", 3}}).write_back);
  EXPECT_EQ(merge.present().at("New"), Value(3));
}

TEST(MailboxMerge, OfEquallyNearVersionsTheLatestCounts) {
  MailboxMerge merge({{"A", false}, {"n", 0}});
  merge.set("A", true);
  merge.wrote();
  merge.set("A", false);
  EXPECT_EQ(merge.wrote(), 2u);
  EXPECT_EQ(merge.outside({{"A", false}, {"n", 1}}).base, 2u);
}

TEST(MailboxMerge, AKnownReadTellsAResetFromARewriteThatNeverSawTheSet) {
  const Values start = {{"Ask", false}, {"Done", false}};
  const Values rewrite = {{"Ask", false}, {"Done", true}};
  MailboxMerge saw(start), missed(start);
  for (MailboxMerge* merge : {&saw, &missed}) {
    merge->set("Ask", true);
    merge->wrote();
  }
  const std::uint64_t first = 0, second = 1;
  saw.outside(rewrite, {&second, 1});
  EXPECT_EQ(saw.present().at("Ask"), Value(false));
  missed.outside(rewrite, {&first, 1});
  EXPECT_EQ(missed.present().at("Ask"), Value(true));
}

TEST(MailboxMerge, ANameThatIsMissingIsWrittenBack) {
  MailboxMerge merge({{"A", 1}, {"B", 2}});
  const auto result = merge.outside({{"A", 1}});
  EXPECT_TRUE(result.write_back);
  EXPECT_TRUE(result.changes.empty());
  EXPECT_EQ(merge.present().size(), 2u);
}

TEST(MailboxMerge, AForgottenReadFallsBackToTheNearestVersion) {
  MailboxMerge merge({{"mine", 0}, {"theirs", 0}}, 4);
  for (int i = 1; i <= 20; ++i) {
    merge.set("mine", i);
    merge.wrote();
  }
  const std::uint64_t forgotten = 3;
  EXPECT_EQ(merge.outside({{"mine", 19}, {"theirs", 1}}, {&forgotten, 1}).base, 19u);
  EXPECT_EQ(merge.present(), (Values{{"mine", 20}, {"theirs", 1}}));
}

/// Both sides count up names of their own; the other side reads, thinks for some writes, and rewrites all.
TEST(MailboxMerge, NoHistoryLosesASet) {
  std::mt19937 random(4);
  const auto draw = [&](int below) { return std::uniform_int_distribution(0, below - 1)(random); };
  for (int history = 0; history < 200; ++history) {
    Values start;
    for (const char* side : {"mine", "theirs"})
      for (int i = 0; i < 4; ++i) start[side + std::to_string(i)] = 0;
    MailboxMerge merge(start);
    Values file = start, read = start, mine, theirs;
    bool thinking = false;
    for (int step = 1; step <= 300; ++step) {
      switch (draw(4)) {
        case 0: {
          const std::string name = "mine" + std::to_string(draw(4));
          merge.set(name, step);
          mine[name] = step;
          break;
        }
        case 1:
          if (merge.differs_from_file()) merge.wrote(), file = merge.present();
          break;
        case 2:
          if (!thinking) read = file, thinking = true;
          break;
        default:
          if (!thinking) break;
          thinking = false;
          for (int change = draw(3); change >= 0; --change) {
            const std::string name = "theirs" + std::to_string(draw(4));
            read[name] = theirs[name] = Value(step);
          }
          file = read;
          if (merge.outside(file).write_back) merge.wrote(), file = merge.present();
      }
      for (const auto& [name, value] : mine)
        ASSERT_EQ(merge.present().at(name), value) << "history " << history;
      for (const auto& [name, value] : theirs)
        ASSERT_EQ(merge.present().at(name), value) << "history " << history;
    }
  }
}

}  // namespace
}  // namespace polyarm::signals
