/// The command: runs, killed and continued, changed inputs, shards.
#include "tests/support/command.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/sweeps/store.hpp"

namespace polyarm::sweeps {
namespace {

namespace fs = std::filesystem;
using test::Command;
using test::Finished;
using test::run_command;

class SweepCommand : public testing::Test {
 protected:
  SweepCommand() : copy_("pick_and_place") { write("x: {from: -0.02, to: 0.02, steps: 3}"); }
  /// A sweep over base places of the mock cell.
  void write(const std::string& axes, const std::string& more = {}) {
    std::ofstream(file())
        << "polyarm: sweep/1\ncell: .\nhardware: mock\nprograms: flowing\nstop_after: {cycles: 1}\n"
        << "base: {grid: {" << axes << "}}\n"
        << more;
  }
  std::string file() const { return copy_.file("small.yaml").string(); }
  fs::path results() const { return copy_.file(".state/sweeps/small/results.sqlite"); }
  /// All rows but for what differs between runs, by key.
  std::set<std::string> rows() const {
    std::set<std::string> out;
    const Store store(results(), Store::Open::read);
    store.each([&](Row row) {
      row.wall_s.reset();
      out.insert(to_json(row));
    });
    return out;
  }

  test::ExampleCopy copy_;
};

TEST_F(SweepCommand, RunsEachVariantOnceAndShowsTheBest) {
  const Finished run = run_command({"sweep", file()});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("3 of 3 variants have a result"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("BEST FIRST"), std::string::npos);
  const std::set<std::string> first = rows();
  EXPECT_EQ(first.size(), 3u);
  const Finished again = run_command({"sweep", file()});
  EXPECT_NE(again.output.find("0 variants run"), std::string::npos) << again.output;
  EXPECT_EQ(rows(), first);
}

TEST_F(SweepCommand, NamesThatTheCellDoesNotHaveAreRefusedBeforeTheRun) {
  write("x: [0]", "values: {FeederLef: [1, 2]}\n");
  const std::string script = copy_.file(".state/sweeps/small/sweep.sbatch").string();
  for (const std::vector<std::string>& how :
       {std::vector<std::string>{}, {"--plan"}, {"--slurm", "4"}, {"--shard", "0/2"}}) {
    std::vector<std::string> words = {"sweep", file()};
    words.insert(words.end(), how.begin(), how.end());
    const Finished run = run_command(words);
    EXPECT_EQ(run.exit_code, 1) << run.output;
    EXPECT_NE(
        run.output.find("small.yaml:7:10: error: the cell has no 'FeederLef'; did you mean 'FeederLeft'?"),
        std::string::npos)
        << run.output;
  }
  EXPECT_FALSE(fs::exists(results()));
  EXPECT_FALSE(fs::exists(script));
}

TEST_F(SweepCommand, KilledAnywhereItGoesOnWithTheSameRows) {
  write("x: {from: -0.03, to: 0.03, steps: 4}, y: [0, 0.01, 0.02]");
  {
    Command whole({"sweep", file(), "-j", "2", "--out", copy_.file("whole").string()});
    EXPECT_EQ(whole.wait().exit_code, 0);
  }
  int kills = 0;
  for (bool done = false; !done && kills < 20;) {
    Command part({"sweep", file(), "-j", "2"});
    for (int tenths = 0; tenths < 300 && !done; ++tenths) {  // until it has one more row, or has ended
      done = part.ends_unread(1);
      if (fs::exists(results()) && !done) {
        std::uint64_t now = 0;
        try {
          now = Store(results(), Store::Open::read).count();
        } catch (const Error&) {  // it is being made
        }
        if (now > static_cast<std::uint64_t>(kills)) break;
      }
    }
    if (!done) part.signal(SIGKILL), ++kills;
    part.wait();
  }
  EXPECT_GT(kills, 1);
  EXPECT_EQ(run_command({"sweep", file()}).exit_code, 0);
  const std::set<std::string> pieces = rows();
  EXPECT_EQ(pieces.size(), 12u);
  std::set<std::string> whole;
  Store(copy_.file("whole") / "results.sqlite", Store::Open::read).each([&](Row row) {
    row.wall_s.reset();
    whole.insert(to_json(row));
  });
  EXPECT_EQ(pieces, whole);
}

TEST_F(SweepCommand, InterruptedItSaysWhatIsLeft) {
  write("x: {from: -0.03, to: 0.03, steps: 40}");
  Command run({"sweep", file(), "-j", "1"});
  for (int tenths = 0; tenths < 600; ++tenths) {
    if (run.ends_unread(1)) break;
    try {
      if (Store(results(), Store::Open::read).count() > 0) break;
    } catch (const Error&) {  // not there yet
    }
  }
  run.signal(SIGINT);
  const Finished end = run.wait();
  EXPECT_EQ(end.exit_code, 3) << end.output;
  EXPECT_NE(end.output.find("variants are left: the same command goes on with them"), std::string::npos)
      << end.output;
}

TEST_F(SweepCommand, AChangedCellIsNotMixedWithEarlierRows) {
  ASSERT_EQ(run_command({"sweep", file()}).exit_code, 0);
  std::ofstream(copy_.file("scene.yaml"), std::ios::app) << "# changed\n";
  const Finished refused = run_command({"sweep", file()});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.output.find("the 3 rows that are there were made before these changed: scene.yaml"),
            std::string::npos)
      << refused.output;
  EXPECT_EQ(rows().size(), 3u);
  const Finished again = run_command({"sweep", file(), "--again"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.output.find("3 variants run"), std::string::npos) << again.output;
}

TEST_F(SweepCommand, MoreVariantsInTheFileKeepTheRowsThatAreThere) {
  ASSERT_EQ(run_command({"sweep", file()}).exit_code, 0);
  write("x: [-0.02, 0, 0.02, 0.04]");
  const Finished more = run_command({"sweep", file()});
  EXPECT_NE(more.output.find("1 variants run"), std::string::npos) << more.output;
  EXPECT_NE(more.output.find("4 of 4 variants have a result"), std::string::npos) << more.output;
}

TEST_F(SweepCommand, ShardsAreMergedToTheSameRows) {
  for (const char* shard : {"0/2", "1/2"})
    ASSERT_EQ(run_command({"sweep", file(), "--shard", shard}).exit_code, 0);
  const Finished show = run_command({"sweep", file(), "--show"});
  EXPECT_EQ(show.exit_code, 0);
  EXPECT_NE(show.output.find("3 of 3 variants have a result"), std::string::npos) << show.output;
  const std::set<std::string> merged = rows();
  EXPECT_EQ(run_command({"sweep", file(), "--show"}).exit_code, 0);
  EXPECT_EQ(rows(), merged);
  ASSERT_EQ(run_command({"sweep", file(), "--again", "--out", copy_.file("whole").string()}).exit_code, 0);
  std::set<std::string> whole;
  Store(copy_.file("whole") / "results.sqlite", Store::Open::read).each([&](Row row) {
    row.wall_s.reset();
    whole.insert(to_json(row));
  });
  EXPECT_EQ(merged, whole);
}

TEST_F(SweepCommand, ASecondWriterIsRefused) {
  const Store held(results(), Store::Open::write);
  const Finished second = run_command({"sweep", file()});
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_NE(second.output.find("another polyarm sweep writes to"), std::string::npos) << second.output;
}

TEST_F(SweepCommand, WritesCsvAndAPageAndAJob) {
  ASSERT_EQ(run_command({"sweep", file(), "--csv", copy_.file("a.csv").string(), "--html",
                         copy_.file("a.html").string()})
                .exit_code,
            0);
  const std::string csv = read_file(copy_.file("a.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_NE(read_file(copy_.file("a.html")).find("<svg"), std::string::npos);
  const Finished json = run_command({"sweep", file(), "--show", "--json"});
  EXPECT_EQ(nlohmann::json::parse(json.output).size(), 3u);
  EXPECT_EQ(run_command({"sweep", file(), "--slurm", "4"}).exit_code, 0);
  EXPECT_NE(read_file(copy_.file(".state/sweeps/small/sweep.sbatch")).find("#SBATCH --array=0-3"),
            std::string::npos);
}

TEST_F(SweepCommand, WhatIsWrongOnTheCommandLineIsSaid) {
  EXPECT_EQ(run_command({"sweep", file(), "--robots", "ur3"}).exit_code, 2);
  EXPECT_EQ(run_command({"sweep", copy_.file("none.yaml").string()}).exit_code, 2);
  EXPECT_EQ(run_command({"sweep", file(), "--shard", "3/2"}).exit_code, 1);
  EXPECT_EQ(run_command({"sweep", file(), "--show"}).exit_code, 1);
}

}  // namespace
}  // namespace polyarm::sweeps
