/// The page of bounds is made from the lists that the code takes its constants from.
#include "polyarm/base/bounds.hpp"

#include <gtest/gtest.h>

#include <set>

#include "polyarm/base/file.hpp"

namespace polyarm {
namespace {

TEST(Bounds, ThePageHasEveryOne) {
  const std::string page = read_file(std::string(POLYARM_SOURCE_DIR) + "/docs/bounds.md");
  EXPECT_NE(page.find(bounds::reference()), std::string::npos)
      << "docs/bounds.md should have these tables:\n"
      << bounds::reference();
}

TEST(Bounds, EachIsAPositiveNumberWithWordsOfItsOwn) {
  std::set<std::string> names;
  for (const bounds::Room& room : bounds::all())
    for (const bounds::Bound& bound : room.bounds) {
      EXPECT_TRUE(names.insert(bound.name).second) << bound.name;
      EXPECT_GT(bound.value, 0u) << bound.name;
      EXPECT_STRNE(bound.what, "") << bound.name;
      EXPECT_STRNE(bound.beyond, "") << bound.name;
    }
}

}  // namespace
}  // namespace polyarm
