#include "polyarm/base/installation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;
using Folders = std::vector<fs::path>;

bool contains(const Folders& all, const fs::path& one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

struct Installation : ::testing::Test {
  ~Installation() override { installation::use({}); }
  test::Folder folder;
};

TEST_F(Installation, TheNamedOneComesFirst) {
  folder.write("share/polyarm/robots/universal_robots/ur3.yaml", "");
  installation::use(folder.path());
  const Folders programs = installation::program_folders(),
                robots = installation::data_folders("robots", "universal_robots");
  EXPECT_EQ(programs[0], folder.path() / "drivers");
  EXPECT_EQ(programs[1], folder.path() / "lib/polyarm");
  ASSERT_FALSE(robots.empty());
  EXPECT_EQ(robots[0], folder.path() / "share/polyarm/robots");
}

TEST_F(Installation, AFolderWithoutTheProofIsNotData) {
  folder.write("share/polyarm/robots/nothing", "");
  installation::use(folder.path());
  EXPECT_FALSE(contains(installation::data_folders("robots", "universal_robots"),
                        folder.path() / "share/polyarm/robots"));
}

TEST_F(Installation, FoldersOfProgramsAreThoseAroundThisProgram) {
  const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
  const Folders all = installation::program_folders();
  EXPECT_EQ(all.front(), here);
  EXPECT_TRUE(contains(all, here.parent_path() / "lib" / "polyarm"));
  for (const fs::path& one : all) EXPECT_EQ(std::count(all.begin(), all.end(), one), 1) << one;
}

TEST_F(Installation, TheFolderOfACallersModuleComesBeforeThatOfTheProgram) {
  const Folders all =
      installation::program_folders(reinterpret_cast<const void*>(&std::fputs));  // in the C library
  EXPECT_NE(all.front(), fs::read_symlink("/proc/self/exe").parent_path());
  EXPECT_TRUE(contains(all, fs::read_symlink("/proc/self/exe").parent_path()));
}

}  // namespace
}  // namespace polyarm
