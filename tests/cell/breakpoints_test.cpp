/// Breakpoints go with their lines while a text is changed.
#include "polyarm/io/breakpoints.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace polyarm::cell {
namespace {

const TextLines kText = {"a", "wait 1", "b", "wait 1", "c"};

TEST(WhereLinesAre, GoDownWithLinesThatComeAboveThem) {
  EXPECT_EQ(where_lines_are(kText, {"x", "a", "wait 1", "y", "b", "wait 1", "c"}),
            (std::vector<int>{2, 3, 5, 6, 7}));
}

TEST(WhereLinesAre, AreGoneWhenTheyAreTakenOut) {
  EXPECT_EQ(where_lines_are(kText, {"a", "wait 1", "c"}), (std::vector<int>{1, 2, 0, 0, 3}));
  EXPECT_EQ(where_lines_are(kText, {}), (std::vector<int>{0, 0, 0, 0, 0}));
}

TEST(WhereLinesAre, StayWhereTheyAreWrittenAnewOrIndented) {
  EXPECT_EQ(where_lines_are(kText, {"a", "wait 2", "  b", "wait 1", "c"}), (std::vector<int>{1, 2, 3, 4, 5}));
  EXPECT_EQ(where_lines_are(kText, {"0", "a", "wait 2", "b", "wait 1", "new", "c"}),
            (std::vector<int>{2, 3, 4, 5, 7}));
}

TEST(WhereLinesAre, AreFoundAgainWhereTheyWereMoved) {
  EXPECT_EQ(where_lines_are({"a", "b", "c"}, {"b", "a", "c"}), (std::vector<int>{2, 1, 3}));
  EXPECT_EQ(where_lines_are({"b", "a", "c"}, {"a", "b", "c"}), (std::vector<int>{2, 1, 3}));
  EXPECT_EQ(where_lines_are({"a", "b", "c", "d"}, {"d", "a", "b", "c"}), (std::vector<int>{2, 3, 4, 1}));
}

/// Lines that are put in or taken out at random: of those left each is where it went to, for all differ.
TEST(WhereLinesAre, FollowAnyEdits) {
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    TextLines before;
    for (int i = 0; i < 30; ++i) before.push_back("line " + std::to_string(i));
    TextLines after = before;
    for (int edit = 0; edit < 8; ++edit) {
      const auto at = static_cast<std::ptrdiff_t>(random() % after.size());
      if (random() % 2 == 0)
        after.erase(after.begin() + at);
      else
        after.insert(after.begin() + at, "new " + std::to_string(edit));
    }
    const std::vector<int> where = where_lines_are(before, after);
    for (std::size_t i = 0; i < before.size(); ++i) {
      const auto found = std::find(after.begin(), after.end(), before[i]);
      if (found != after.end()) {
        EXPECT_EQ(where[i], found - after.begin() + 1) << "round " << round;
      }
    }
    EXPECT_TRUE(std::all_of(where.begin(), where.end(),
                            [&](int line) { return line >= 0 && line <= static_cast<int>(after.size()); }));
  }
}

TEST(FileBreakpoints, FollowTheTextThatIsKnown) {
  FileBreakpoints file{"job.script", {}, {}};
  file.add(4);
  file.add(3);
  file.add(4);
  EXPECT_EQ(file.lines, (std::vector<int>{3, 4}));
  file.follow(kText);
  EXPECT_EQ(file.lines, (std::vector<int>{3, 4})) << "of what they were lines is not known yet";
  file.follow({"x", "a", "wait 1", "wait 1", "c"});
  EXPECT_EQ(file.lines, (std::vector<int>{4}));
}

}  // namespace
}  // namespace polyarm::cell
