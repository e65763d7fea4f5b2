#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::run_command;

class DataVerb : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return copy.file(name).string(); }
  test::Finished data(std::vector<std::string> words) {
    words.insert(words.begin(), "data");
    return run_command(words);
  }
  test::ExampleCopy copy{"pick_and_place"};
};

TEST_F(DataVerb, SetsGetsAndTakesBack) {
  const std::string before = read_file(file("PAPpoints.points")), points = file("PAPpoints");
  EXPECT_EQ(data({"set", points, "gap", "40mm", "--yes"}).exit_code, 0);
  EXPECT_EQ(data({"get", points, "gap"}).output, "0.04m\n");
  EXPECT_EQ(data({"set", points, "gap", "[1, \"two\"]", "--yes"}).exit_code, 0);
  EXPECT_EQ(data({"get", points, "gap"}).output, "[1, \"two\"]\n");
  EXPECT_NE(data({"history", points}).output.find("set gap"), std::string::npos);
  EXPECT_EQ(data({"undo", points, "2", "--yes"}).exit_code, 0);
  EXPECT_EQ(read_file(file("PAPpoints.points")), before);
}

TEST_F(DataVerb, AsksAboutTakingBackOnlyWhatThereIs) {
  const std::string points = file("PAPpoints");
  const test::Finished none = data({"undo", points});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.output.find("no change of this file is known"), std::string::npos) << none.output;
  EXPECT_EQ(none.output.find("[y/N]"), std::string::npos) << none.output;
  ASSERT_EQ(data({"set", points, "gap", "40mm", "--yes"}).exit_code, 0);
  EXPECT_NE(data({"undo", points}).output.find("take back the last change of "), std::string::npos);
  const test::Finished more = data({"undo", points, "2", "--yes"});
  EXPECT_EQ(more.exit_code, 1);
  EXPECT_NE(more.output.find("1 change of this file is known, 2 were to be taken back"), std::string::npos)
      << more.output;
  EXPECT_EQ(data({"get", points, "gap"}).output, "0.04m\n") << "nothing was taken back";
}

TEST_F(DataVerb, OverwritesAndDeletesNothingUnasked) {
  const std::string before = read_file(file("cycledata.data"));
  for (const auto& words :
       std::vector<std::vector<std::string>>{{"set", file("cycledata"), "Repeat", "false"},
                                             {"delete", file("cycledata"), "Repeat"},
                                             {"delete", file("cycledata")}}) {
    EXPECT_NE(data(words).exit_code, 0);
    EXPECT_EQ(read_file(file("cycledata.data")), before);
  }
  EXPECT_EQ(data({"delete", file("cycledata"), "Repeat", "-y"}).exit_code, 0);
  EXPECT_EQ(read_file(file("cycledata.data")).find("Repeat"), std::string::npos);
}

TEST_F(DataVerb, ExportsAndImportsEveryForm) {
  for (const char* form : {"csv", "json", "yaml", "text"}) {
    const std::string out = file(std::string("out.") + form),
                      back = file(std::string("back_") + form + ".points");
    ASSERT_EQ(data({"export", file("PAPpoints"), "-o", out, "--format", form}).exit_code, 0) << form;
    ASSERT_EQ(data({"import", back, out, "--format", form, "-y"}).exit_code, 0) << form;
    EXPECT_EQ(data({"list", back}).output, data({"list", file("PAPpoints")}).output) << form;
  }
}

TEST_F(DataVerb, RefusesAPickleWithASentence) {
  write_file_atomically(file("old.data"), "\x80\x04\x95 pickle");
  const test::Finished listed = data({"list", file("old.data")});
  EXPECT_EQ(listed.exit_code, 1);
  EXPECT_NE(listed.output.find("pickle"), std::string::npos);
}

TEST_F(DataVerb, MakesFramesAndToolsFromPointsThatWereTouched) {
  const std::string points = file("taught.points");
  write_file_atomically(
      points,
      "Pose: RPY\nName: o\nPoint: 0.1, 0.2, 0, 0, 0, 0\nName: x\nPoint: 0.1, 0.5, 0, 0, 0, 0\nName: y\n"
      "Point: -0.2, 0.3, 0, 0, 0, 0\nName: t1\nPoint: 0.3, 0, 0.3, 0, 0, 0\nName: t2\nPoint: 0.3, 0, 0.3, "
      "0.5, 0, 0\nName: t3\nPoint: 0.3, 0, 0.3, 0, 0.5, 0\nName: t4\nPoint: 0.35, 0, 0.3, 0, 0.2, 0.5\n");
  EXPECT_EQ(data({"frame", points, "table", "--from", "o", "x", "y"}).exit_code, 0);
  EXPECT_NE(data({"get", points, "table"}).output.find("pose(0.1, 0.2, 0"), std::string::npos);
  const test::Finished tool = data({"tool", points, "cup", "--from", "t1", "t2", "t3", "t4"});
  EXPECT_EQ(tool.exit_code, 1) << "the fourth pose is centimetres off";
  EXPECT_NE(tool.output.find("residual"), std::string::npos);
  EXPECT_EQ(data({"get", points, "cup"}).exit_code, 1);
}

}  // namespace
}  // namespace polyarm
