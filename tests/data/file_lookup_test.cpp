#include "polyarm/data/file_lookup.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>

namespace polyarm::data {
namespace {

const std::filesystem::path kThesis = POLYARM_SOURCE_DIR "/tests/program/thesis/sorting";

TEST(FileLookup, TriesTheEndingsBesideTheFileThatNamesIt) {
  EXPECT_EQ(find_file("cycledata", kThesis), kThesis / "cycledata.data");
  EXPECT_EQ(find_file("SORpoints", kThesis), kThesis / "SORpoints.points");
  EXPECT_EQ(find_file("SORscript.script", kThesis), kThesis / "SORscript.script");
}

TEST(FileLookup, SaysWhatWasTriedAndWhatIsNear) {
  try {
    find_file("cycldata", kThesis, {"x.script", 3, 6});
    FAIL();
  } catch (const Error& error) {
    const Problem& problem = error.problems().at(0);
    EXPECT_EQ(problem.where.text(), "x.script:3:6");
    EXPECT_NE(problem.what.find("did you mean 'cycledata'?"), std::string::npos);
    EXPECT_NE(problem.advice.find("cycldata.points, cycldata.data, cycldata.script, cycldata.txt"),
              std::string::npos);
  }
}

TEST(FileLookup, FollowsPointFileAndScriptFile) {
  const LoadedFiles loaded = load_files("cycledata", kThesis);
  ASSERT_EQ(loaded.points.size(), 1u);
  EXPECT_TRUE(loaded.points[0].values().value("Place3"));
  EXPECT_EQ(loaded.script, kThesis / "SORscript.script");
}

TEST(FileLookup, AScriptIsFoundBesideDataOfTheSameName) {
  std::string pattern = (std::filesystem::temp_directory_path() / "polyarm_XXXXXX").string();
  const std::filesystem::path folder = ::mkdtemp(pattern.data());
  std::ofstream(folder / "job.data") << "Name: ScriptFile\nText: job\n";
  std::ofstream(folder / "job.script") << "log(1)\n";
  EXPECT_EQ(load_files("job", folder).script, folder / "job.script");
  std::filesystem::remove_all(folder);
}

TEST(FileLookup, OddNamesAreErrorsNotCrashes) {
  for (const std::string& name : {std::string(), std::string(5000, 'x'), std::string("a\0b", 3),
                                  std::string("../sorting"), std::string("/")})
    EXPECT_THROW(find_file(name, kThesis), Error);
}

}  // namespace
}  // namespace polyarm::data
