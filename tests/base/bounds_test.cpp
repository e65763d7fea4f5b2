/// The page of bounds is made from the lists that the code takes its constants from.
#include "polyarm/base/bounds.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "polyarm/base/file.hpp"

namespace polyarm {
namespace {

TEST(Bounds, ThePageHasEveryOne) {
  const std::string page = read_file(std::string(POLYARM_SOURCE_DIR) + "/docs/bounds.md");
  EXPECT_NE(page.find(bounds::reference()), std::string::npos) << "docs/bounds.md should have these tables:\n"
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

/// Rooms that take what comes from outside name their limits on the page, not in their own files.
TEST(Bounds, RoomsHaveNoLimitsOfTheirOwn) {
  const std::regex own(
      "\\bk(Most|Longest|Largest|Deepest)\\w* *= *(std::size_t\\{)?[0-9][0-9'.u<>+* ]*[};,]");
  // Of their own working, not of what comes in.
  const std::set<std::string> exempt{"kMostNeighbours",  "kMostRounds",      "kMostTime",
                                     "kMostBrakeCycles", "kMostCycles",      "kMost",
                                     "kMostField",       "kMostNotes",       "kMostVariables",
                                     "kMostKept",        "kMostHeaderLines", "kMostAssets",
                                     "kMostLater",       "kLongestName",     "kLargestAsset",
                                     "kMostAnnounced",   "kMostCauses",      "kMostFrame",
                                     "kMostCounted",     "kLongestNote",     "kMostBehind"};
  const std::filesystem::path source(POLYARM_SOURCE_DIR);
  for (const char* room :
       {"polyarm/users", "polyarm/access", "polyarm/clouds", "polyarm/meshes", "polyarm/fleet",
        "polyarm/server", "polyarm/recording", "drivers/yaskawa", "drivers/wire", "drivers/kuka",
        "links/mqtt", "links/modbus", "importers/mesh", "importers/step"})
    for (const auto& each : std::filesystem::directory_iterator(source / room)) {
      if (each.path().extension() != ".hpp" && each.path().extension() != ".cpp") continue;
      const std::string text = read_file(each.path());
      for (std::sregex_iterator found(text.begin(), text.end(), own), end; found != end; ++found) {
        const std::string name = found->str().substr(0, found->str().find_first_of(" ="));
        EXPECT_TRUE(exempt.contains(name))
            << each.path() << " has a limit " << name << ": list it in polyarm/base/bounds.hpp";
      }
    }
}

}  // namespace
}  // namespace polyarm
