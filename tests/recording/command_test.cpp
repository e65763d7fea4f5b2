/// `polyarm run --record`, as a user says it.
#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "polyarm/base/file.hpp"
#include "tests/recording/demo.hpp"

namespace polyarm::recording {
namespace {

using test::Demo;
using test::Finished;
using test::McapFile;
using test::run_command;

TEST(RecordCommand, WritesWhatTheRunDidIntoTheFileThatItNames) {
  const Demo demo;
  const std::string file = demo.folder.path() / "run.mcap";
  const Finished ran = run_command({"run", demo.folder.path(), "--fast", "--record", file, "--record-rate",
                                    "500", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  const McapFile recorded = McapFile::read(read_file(file));
  EXPECT_TRUE(recorded.whole);
  const double s = ran.result()["sim_time_s"];
  EXPECT_NEAR(static_cast<double>(recorded.of("/joint_states").size()), 500 * s, 3);
  EXPECT_GE(recorded.of("/program").size(), 4u);
  EXPECT_TRUE(recorded.attachments.contains("demo.script"));
}

TEST(RecordCommand, OnTheWallClockTheFileIsWholeToo) {
  const Demo demo;
  const std::string file = demo.folder.path() / "run.mcap";
  const Finished ran =
      run_command({"run", demo.folder.path(), "--record", file, "--seconds", "1", "--json", "--no-socket"});
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  const McapFile recorded = McapFile::read(read_file(file));
  EXPECT_TRUE(recorded.whole);
  EXPECT_GE(recorded.of("/joint_states").size(), 10u);
}

TEST(RecordCommand, AFileThatCannotBeWrittenIsToldBeforeAnythingMoves) {
  const Demo demo;
  const std::string file = demo.folder.path() / "cell.yaml" / "run.mcap";  // below a file
  const Finished ran =
      run_command({"run", demo.folder.path(), "--fast", "--record", file, "--json", "--no-socket"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_NE(ran.output.find("run.mcap"), std::string::npos) << ran.output;
  EXPECT_EQ(ran.result()["control_cycles"], 0) << ran.output;
}

TEST(RecordCommand, ARateThatIsNoneIsAWrongCommandLine) {
  const Demo demo;
  EXPECT_EQ(run_command({"run", demo.folder.path(), "--fast", "--record", "a.mcap", "--record-rate", "0"})
                .exit_code,
            2);
}

}  // namespace
}  // namespace polyarm::recording
