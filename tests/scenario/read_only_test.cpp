/// Cells in folders that the user may not write to.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;

/// As somebody else than root, whom no permissions bind.
class Unprivileged {
 public:
  Unprivileged() { was_root_ = ::geteuid() == 0 && ::seteuid(65534) == 0; }
  ~Unprivileged() {
    if (was_root_ && ::seteuid(0) != 0) ::_exit(1);
  }

 private:
  bool was_root_ = false;
};

TEST(ReadOnly, ARunInAFolderThatCannotBeWrittenSaysSoAndNothingElse) {
  const test::Folder folder;
  folder.write("places.points", "Pose: RPY\nName: A\nPoint: 0.3, 0, 0.8, 0, 0, 0\n");
  folder.write("job.script", "load places\nlog(A.x)\n");
  folder.write("cell.yaml", std::string("polyarm: cell/1\nrobots: {arm: {model: ") + POLYARM_SOURCE_DIR +
                                "/examples/r6bot/r6bot.urdf}}\nprogram: job.script\n");
  for (const auto& entry : fs::directory_iterator(folder.path())) ::chmod(entry.path().c_str(), 0444);
  ::chmod(folder.path().c_str(), 0555);
  test::Finished checked, run;
  {
    const Unprivileged nobody;
    if (::faccessat(AT_FDCWD, POLYARM_COMMAND, X_OK, AT_EACCESS) != 0)
      GTEST_SKIP() << "the command is not for everybody";
    checked = test::run_command({"check", folder.path().string()});
    run = test::run_command({"run", folder.path().string(), "--fast", "--quiet"});
  }
  ::chmod(folder.path().c_str(), 0755);
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_NE(run.output.find(
                ".state/data: this folder cannot be created: Permission denied (a run stores copies of data "
                "files there: work on a copy of the cell"),
            std::string::npos)
      << run.output;
  EXPECT_EQ(run.output.find("there is nothing called"), std::string::npos) << run.output;
}

TEST(ReadOnly, ARunNeverBeginsWithTheDataOfTheRunBefore) {
  const test::Folder folder;
  folder.write("work.data", "Name: Again\nBool: True\n");
  folder.write("job.script", "load work\nwhile Again\n  set Again = false\nend\n");
  folder.write("cell.yaml", std::string("polyarm: cell/1\nrobots: {arm: {model: ") + POLYARM_SOURCE_DIR +
                                "/examples/r6bot/r6bot.urdf}}\nprogram: job.script\n");
  ASSERT_EQ(test::run_command({"run", folder.path().string(), "--fast", "--quiet"}).exit_code, 0);
  const fs::path state = folder.path() / ".state" / "data";
  ASSERT_TRUE(fs::exists(state / "work.data"));
  ::chmod(folder.path().c_str(), 0755), ::chmod((folder.path() / ".state").c_str(), 0555),
      ::chmod(state.c_str(), 0555);
  test::Finished run;
  {
    const Unprivileged nobody;
    if (::faccessat(AT_FDCWD, POLYARM_COMMAND, X_OK, AT_EACCESS) != 0)
      GTEST_SKIP() << "the command is not for everybody";
    run = test::run_command({"run", folder.path().string(), "--fast", "--quiet"});
  }
  ::chmod((folder.path() / ".state").c_str(), 0755), ::chmod(state.c_str(), 0755);
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_NE(run.output.find("the data of the run before cannot be removed"), std::string::npos) << run.output;
}

}  // namespace
}  // namespace polyarm
