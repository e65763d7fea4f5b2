/// Files that recordings go into.
#include "polyarm/recording/file_sink.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::recording {
namespace {

TEST(FileSink, OverwritesRecordingsAndNothingElse) {
  test::Folder folder;
  folder.write("places.points", "Name: A\n");
  try {
    FileSink(folder.path() / "places.points");
    FAIL() << "a file of points is not a recording";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "not-a-recording");
  }
  EXPECT_EQ(read_file(folder.path() / "places.points"), "Name: A\n");

  const std::string earlier = std::string("\x89MCAP0\r\n", 8) + "what was recorded";
  folder.write("run.mcap", earlier);
  std::filesystem::create_hard_link(folder.path() / "run.mcap", folder.path() / "kept.mcap");
  {
    FileSink sink(folder.path() / "run.mcap");
    const std::byte one[] = {std::byte{'a'}};
    EXPECT_TRUE(sink.write(one));
  }
  EXPECT_EQ(read_file(folder.path() / "run.mcap"), "a");
  EXPECT_EQ(read_file(folder.path() / "kept.mcap"), earlier) << "another name of the earlier recording";
  struct stat facts {};
  ASSERT_EQ(::stat((folder.path() / "run.mcap").c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777, 0600u);
}

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

/// A reader may look at any moment, and the recorder may be killed at any moment.
TEST(FileSink, TheFileIsThereWithItsFirstRecordAndNotBefore) {
  test::Folder folder;
  const std::byte begin[] = {std::byte{'a'}, std::byte{'b'}};
  const std::size_t before = files_in(folder.path());
  { FileSink unused(folder.path() / "run.mcap"); }
  EXPECT_EQ(files_in(folder.path()), before) << "nothing was recorded";
  FileSink sink(folder.path() / "run.mcap");
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "run.mcap"));
  ASSERT_TRUE(sink.write(begin));
  EXPECT_EQ(read_file(folder.path() / "run.mcap"), "ab");
  ASSERT_TRUE(sink.write(begin));
  EXPECT_EQ(read_file(folder.path() / "run.mcap"), "abab");
  EXPECT_EQ(files_in(folder.path()), before + 1);
}

TEST(FileSink, AFileThatCameMeanwhileIsKept) {
  test::Folder folder;
  FileSink sink(folder.path() / "run.mcap");
  folder.write("run.mcap", "somebody's");
  const std::byte one[] = {std::byte{'a'}};
  EXPECT_FALSE(sink.write(one));
  EXPECT_NE(sink.problem().find("run.mcap"), std::string::npos) << sink.problem();
  EXPECT_EQ(read_file(folder.path() / "run.mcap"), "somebody's");
}

}  // namespace
}  // namespace polyarm::recording
