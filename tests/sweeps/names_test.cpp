/// Names of a sweep that the cell does not have: refused before anything runs, with the nearest one.
#include "polyarm/sweeps/names.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "drivers/mock/mock.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/sweeps/sweep_file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::sweeps {
namespace {

class NamesOfACell : public testing::Test {
 protected:
  NamesOfACell()
      : catalogue_({std::filesystem::path(POLYARM_SOURCE_DIR) / "robots"}), copy_("pick_and_place") {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  }
  /// "LINE what" of each finding; the text begins in line 4.
  std::vector<std::string> found(const std::string& more) {
    const Sweep sweep = read_sweep("polyarm: sweep/1\ncell: .\nhardware: mock\n" + more,
                                   copy_.file("of_the_test.yaml"), catalogue_);
    std::vector<std::string> out;
    for (const Problem& problem :
         unknown_names(sweep, catalogue_, copy_.file(".state") / ("data" + std::to_string(runs_++))))
      out.push_back(std::to_string(problem.where.line) + " " + problem.what);
    return out;
  }
  using Findings = std::vector<std::string>;

  description::Catalogue catalogue_;
  test::ExampleCopy copy_;
  int runs_ = 0;
};

TEST_F(NamesOfACell, OfTheCellAreKnown) {
  EXPECT_EQ(found("programs: [flowing, cycledata]\n"
                  "vary: {points: {PrePick: 1mm}}\nseeds: [1, 2]\n"
                  "values: {FeederLeft: [1, 2]}\n"
                  "faults:\n  none: {}\n  weak: {force: {arm/tool/vacuum: 0}}\n"),
            Findings{});
}

TEST_F(NamesOfACell, AProgramThatIsNotThereIsNamedWithTheNearest) {
  EXPECT_EQ(found("programs: [flowing,\n  flowin]\n"),
            Findings{"5 there is no file 'flowin'; did you mean 'flowing'?"});
}

TEST_F(NamesOfACell, AProgramMayBeAPathInTheWorkingFolder) {
  const test::Folder elsewhere;
  elsewhere.write("apart.script", "log(1)\n");
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(elsewhere.path());
  const Findings findings = found("programs: [apart.script, apart.scrip]\n");
  std::filesystem::current_path(before);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].find("4 there is no file 'apart.scrip'"), 0u) << findings[0];
}

TEST_F(NamesOfACell, TagsPointsAndInterfacesToo) {
  EXPECT_EQ(found("programs: flowing\nvalues: {FeederLef: [1, 2]}\n"),
            Findings{"5 the cell has no 'FeederLef'; did you mean 'FeederLeft'?"});
  EXPECT_EQ(found("programs: flowing\nvary:\n  points: {PrePik: 1mm}\nseeds: [1, 2]\n"),
            Findings{"6 the cell has no 'PrePik'; did you mean 'PrePick'?"});
  EXPECT_EQ(found("programs: flowing\nfaults:\n  weak: {force: {arm/tool/vacum: 0}}\n"),
            Findings{"6 there is no interface 'arm/tool/vacum'; did you mean 'arm/tool/vacuum'?"});
}

TEST_F(NamesOfACell, AValueThatDoesNotFitIsRefused) {
  const Findings findings = found("programs: flowing\nvalues: {FeederLeft: [1, many]}\n");
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].find("5 'many' is no value for FeederLeft, which is "), 0u) << findings[0];
  const Findings points = found("programs: flowing\nvary:\n  points: {FeederLeft: 1mm}\nseeds: [1, 2]\n");
  EXPECT_EQ(points, Findings{"6 'FeederLeft' is no point and cannot vary"});
}

TEST_F(NamesOfACell, TheRobotThatIsExchangedIsOneOfTheCell) {
  const Findings findings = found("robot: arn\nprograms: flowing\n");
  EXPECT_EQ(findings, Findings{"4 the cell has no robot 'arn'; did you mean 'arm'?"});
}

TEST_F(NamesOfACell, ANameOfOneProgramIsKnown) {
  std::ofstream(copy_.file("rounds.data")) << "Name: Rounds\nNum: 3\n";
  std::ofstream(copy_.file("counted.script")) << "load cycledata\nload rounds\nlog(Rounds)\n";
  EXPECT_EQ(found("programs: [flowing, counted]\nvalues: {Rounds: [1, 2]}\n"), Findings{});
  EXPECT_EQ(found("programs: [flowing]\nvalues: {Rounds: [1, 2]}\n").size(), 1u);
}

TEST_F(NamesOfACell, ACellThatCannotBeBuiltSaysNothing) {
  std::ofstream(copy_.file("broken.script")) << "while\n";
  EXPECT_EQ(found("programs: broken\nvalues: {NotThere: [1, 2]}\n"), Findings{});
}

}  // namespace
}  // namespace polyarm::sweeps
