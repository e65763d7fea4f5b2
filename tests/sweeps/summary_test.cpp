/// What is made of many rows: the best, why others are worse, the page.
#include "polyarm/sweeps/summary.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/file.hpp"
#include "polyarm/sweeps/page.hpp"
#include "polyarm/sweeps/slurm.hpp"

namespace polyarm::sweeps {
namespace {

Row row(const std::string& robot, double x, double cycle, std::optional<double> clearance) {
  Row out;
  out.key = robot + std::to_string(x);
  out.robot = robot;
  out.x_m = x, out.y_m = 0;
  out.ended = "completed";
  out.cycle_s = out.cycle_p95_s = cycle;
  out.clearance_m = clearance;
  out.clearance_a = "arm/forearm", out.clearance_b = "fixture table";
  return out;
}

Row failed(const std::string& robot, double x, const std::string& code) {
  Row out = row(robot, x, 0, {});
  out.cycle_s.reset();
  out.ended = "failed", out.code = code, out.cause = "<Pick> is too far";
  return out;
}

Summary some() {
  Summary out(3);
  out.add(row("a", 0, 3.0, 0.02));
  out.add(row("a", 1, 3.3, 0.05));
  out.add(row("b", 0, 2.5, 0.01));
  out.add(row("b", 1, 2.9, 0.02));
  out.add(failed("b", 2, "unreachable"));
  return out;
}

TEST(Summary, TheFastestIsFirstAndItsPlaceKept) {
  const Summary summary = some();
  ASSERT_EQ(summary.best().size(), 3u);
  EXPECT_EQ(title_of(summary.best()[0]), "b, base x 0, y 0");
  EXPECT_EQ(summary.best()[1].cycle_s, 2.9);
  EXPECT_EQ(summary.total().ran, 5u);
  EXPECT_EQ(summary.total().completed, 4u);
}

TEST(Summary, TheParetoSetHasWhatNoOtherBeatsInBoth) {
  std::vector<double> cycles;
  for (const Row& row : some().pareto()) cycles.push_back(*row.cycle_s);
  EXPECT_EQ(cycles, (std::vector<double>{2.5, 2.9, 3.3}));
}

TEST(Summary, SaysWhatMakesARowWorse) {
  EXPECT_EQ(why_worse(row("a", 0, 3.0, 0.005), row("b", 0, 2.5, 0.01)),
            "20.0 % slower, nearer to fixture table (other robot)");
  EXPECT_EQ(why_worse(row("a", 1, 2.5, {}), row("a", 0, 2.5, {})), "as fast (other base)");
}

TEST(Summary, CountsFailuresOfEachValueOfAnAxis) {
  const Summary summary = some();
  const Share& b = summary.axes().at("robot").at("b");
  EXPECT_EQ(b.ran, 3u);
  EXPECT_EQ(b.completed, 2u);
  EXPECT_EQ(b.main_code(), "unreachable");
  EXPECT_EQ(summary.examples().at("unreachable").robot, "b");
}

TEST(Page, HasMapsAndEscapesTexts) {
  const std::string page = page_of("A & B", some(), 0.05);
  EXPECT_NE(page.find("<h1>A &amp; B</h1>"), std::string::npos);
  EXPECT_NE(page.find("&lt;Pick&gt; is too far"), std::string::npos);
  EXPECT_EQ(page.find("<Pick>"), std::string::npos);
  EXPECT_NE(page.find("x of the base, m"), std::string::npos);
  EXPECT_NE(page.find("cycle time, s"), std::string::npos);
}

TEST(Shards, ShareTheVariantsWithoutOverlap) {
  for (std::uint64_t number = 0; number < 100; ++number) {
    int owners = 0;
    for (int i = 0; i < 7; ++i) owners += read_shard(std::to_string(i) + "/7").has(number);
    EXPECT_EQ(owners, 1);
  }
  for (const char* wrong : {"", "1", "7/7", "-1/3", "1.5/3", "a/b", "1/2/3", "0/0"})
    EXPECT_THROW(read_shard(wrong), Error) << wrong;
}

TEST(Shards, AScriptQuotesPathsAndNamesNoShellOfTheirs) {
  const std::string script =
      slurm_script({"/opt/polyarm", "/home/a/it's.yaml", "/out dir", "it's; rm", 8, 2});
  EXPECT_NE(script.find("#SBATCH --array=0-7\n"), std::string::npos);
  EXPECT_NE(script.find("'/home/a/it'\\''s.yaml'"), std::string::npos) << script;
  EXPECT_NE(script.find("--job-name=polyarm-it_s__rm\n"), std::string::npos) << script;
  EXPECT_NE(script.find("--out '/out dir'"), std::string::npos);
}

TEST(Columns, ThePageOfTheReferenceHasThemAll) {
  const std::string page = read_file(std::filesystem::path(POLYARM_SOURCE_DIR) / "docs" / "sweeps.md");
  EXPECT_NE(page.find(reference()), std::string::npos) << "the table of docs/sweeps.md should be:\n"
                                                       << reference();
}

}  // namespace
}  // namespace polyarm::sweeps
