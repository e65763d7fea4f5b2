#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/apart.hpp"
#include "apps/options.hpp"
#include "apps/scratch.hpp"
#include "apps/terminal.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/program_tests.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct TestArguments {
  std::string path = ".", only, junit;
  cell::TestOptions options;
  std::vector<std::string> plugins;
  unsigned jobs = 0;
  double patience = 300;
  bool json = false, list = false, verbose = false;
};

struct Verdict {
  bool ran = false;
  std::vector<Problem> problems;
  std::vector<std::string> log;
  double cell_time_s = 0, wall_time_s = 0;
};

std::string packed(const cell::TestResult& result) {
  Json problems = Json::array();
  for (const Problem& p : result.problems)
    problems.push_back({p.code, p.where.file, p.where.line, p.where.column, p.what, p.advice});
  return Json{{"problems", problems}, {"log", result.log}, {"time", result.cell_time_s}}.dump(
      -1, ' ', false, Json::error_handler_t::replace);
}

Verdict unpacked(const ApartResult& result, const cell::ProgramTest& test) {
  Verdict out;
  out.ran = true;
  out.wall_time_s = result.seconds;
  const Json said = result.said ? Json::parse(*result.said, nullptr, false) : Json();
  if (!said.is_object()) {
    out.problems.push_back({"crashed",
                            {test.file.string(), test.line, 0},
                            result.why.empty() ? "the test gave no reason" : result.why,
                            {}});
    return out;
  }
  for (const Json& p : said["problems"]) out.problems.push_back({p[0], {p[1], p[2], p[3]}, p[4], p[5]});
  out.log = said["log"].get<std::vector<std::string>>();
  out.cell_time_s = said["time"];
  return out;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 32 || c == '\n' || c == '\t')
      out += c;
  }
  return out;
}

std::string all_problems(const Verdict& verdict) {
  std::string out;
  for (const Problem& problem : verdict.problems) out += problem.text() + "\n";
  return out;
}

/// The results as JUnit XML for continuous integration: one suite per file.
std::string junit(const std::vector<cell::ProgramTest>& tests, const std::vector<Verdict>& verdicts) {
  std::map<std::string, std::vector<std::size_t>> files;
  for (std::size_t i = 0; i < tests.size(); ++i) files[tests[i].file.string()].push_back(i);
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n";
  for (const auto& [file, members] : files) {
    double time = 0;
    std::size_t failed = 0;
    for (const std::size_t i : members)
      time += verdicts[i].wall_time_s, failed += verdicts[i].problems.empty() ? 0 : 1;
    out += fmt::format("  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" time=\"{:.3f}\">\n",
                       escaped(file), members.size(), failed, time);
    for (const std::size_t i : members) {
      out +=
          fmt::format("    <testcase classname=\"{}\" name=\"{}\" file=\"{}\" line=\"{}\" time=\"{:.3f}\">\n",
                      escaped(tests[i].file.stem().string()), escaped(tests[i].name), escaped(file),
                      tests[i].line, verdicts[i].wall_time_s);
      if (!verdicts[i].problems.empty())
        out += fmt::format("      <failure message=\"{}\">{}</failure>\n",
                           escaped(verdicts[i].problems.front().what), escaped(all_problems(verdicts[i])));
      if (!verdicts[i].log.empty())
        out += "      <system-out>" + escaped(join(verdicts[i].log, "\n")) + "</system-out>\n";
      out += "    </testcase>\n";
    }
    out += "  </testsuite>\n";
  }
  return out + "</testsuites>\n";
}

void tell(const cell::ProgramTest& test, const Verdict& verdict, const TestArguments& a) {
  const bool passed = verdict.problems.empty();
  if (a.json) {
    Json problems = Json::array();
    for (const Problem& p : verdict.problems)
      problems.push_back(
          {{"code", p.code}, {"where", p.where.text()}, {"what", p.what}, {"advice", p.advice}});
    fmt::print("{}\n", Json{{"test", test.name},
                            {"file", test.file.string()},
                            {"line", test.line},
                            {"passed", passed},
                            {"cell_time_s", verdict.cell_time_s},
                            {"wall_time_s", verdict.wall_time_s},
                            {"problems", problems},
                            {"log", verdict.log}}
                           .dump(-1, ' ', false, Json::error_handler_t::replace));
    return;
  }
  fmt::print("{} {}:{} {} ({:.1f} s of the cell in {:.2f} s)\n", passed ? "passed" : "FAILED",
             test.file.string(), test.line, test.name, verdict.cell_time_s, verdict.wall_time_s);
  for (const Problem& problem : verdict.problems) fmt::print("  {}\n", problem.text());
  constexpr std::size_t kReported = 10;
  const std::size_t first = a.verbose || verdict.log.size() < kReported ? 0 : verdict.log.size() - kReported;
  if (!passed || a.verbose)
    for (std::size_t i = first; i < verdict.log.size(); ++i) fmt::print("    {}\n", verdict.log[i]);
}

/// Prints a progress line that is overwritten, on a terminal only.
void tell_progress(std::size_t ended, std::size_t failed, std::size_t count, const TestArguments& a) {
  if (a.json || ::isatty(STDERR_FILENO) == 0) return;
  fmt::print(stderr, "{}{} of {} tests, {} failed{}{}", own_return(), ended, count, failed, own_escape("[K"),
             ended == count ? "\n" : own_return());
  std::fflush(stderr);
}

int run_all(const std::vector<cell::ProgramTest>& tests, const TestArguments& a) {
  const description::Catalogue catalogue = open_catalogue();
  const Scratch scratch("test");
  std::vector<Verdict> verdicts(tests.size());
  std::size_t ended = 0, failed = 0;
  run_apart(
      tests.size(), a.jobs > 0 ? a.jobs : processors(), a.patience,
      [&](std::size_t i) {
        cell::TestOptions options = a.options;
        options.state_folder = scratch.of(i);
        return packed(cell::run_test(tests[i], catalogue, options));
      },
      [&](std::size_t i, const ApartResult& result) {
        verdicts[i] = unpacked(result, tests[i]);
        ++ended, failed += verdicts[i].problems.empty() ? 0 : 1;
        tell(tests[i], verdicts[i], a);
        tell_progress(ended, failed, tests.size(), a);
      });
  if (!a.junit.empty()) write_file_atomically(a.junit, junit(tests, verdicts));
  if (!a.json)
    fmt::print("{} {}, {} passed, {} failed\n", tests.size(), tests.size() == 1 ? "test" : "tests",
               tests.size() - failed, failed);
  return failed > 0 ? kFailed : kOk;
}

}  // namespace

int run_test(int argc, char** argv) {
  CommandLine app("Runs the tests of programs: each in a simulated cell of its own, in lock-step",
                  "polyarm test");
  TestArguments a;
  app.add_option("path", a.path,
                 "a file of tests (*.script), or a folder with such files beside their cells");
  app.add_option("--only", a.only, "only tests whose name contains this");
  app.add_option("-j,--jobs", a.jobs, "how many run at the same time (default: the number of processors)");
  app.add_option("--junit", a.junit,
                 "also write the results to this file, as continuous integration reads them");
  app.add_option("--robot", a.options.overrides.robot, "with another robot");
  app.add_option("--hardware", a.options.overrides.hardware, "declared, mock or mujoco")
      ->check(wrong_hardware, "NAME");
  app.add_option("--seconds", a.options.seconds, "of cell time that a test may take (600)");
  app.add_option("--patience", a.patience, "seconds of wall time after which a test is killed (300)");
  app.add_flag("--json", a.json, "one JSON object a line, for each test");
  app.add_flag("--list", a.list, "only list the tests");
  app.add_flag("-v,--verbose", a.verbose, "print the logs of programs, also of tests that pass");
  add_plugin_option(app, a.plugins);
  app.footer(
      examples({"polyarm test examples", "polyarm test my_cell --only \"blue parts\" --junit results.xml",
                "polyarm test examples/sorting --robot abb/irb_120"}) +
      "\nExit codes: 0 all passed, 1 some failed or could not be read, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  load_plugins(a.plugins);
  Problems problems;
  std::vector<cell::ProgramTest> tests = cell::find_tests(a.path, problems);
  std::erase_if(tests, [&](const cell::ProgramTest& t) { return t.name.find(a.only) == std::string::npos; });
  for (const Problem& problem : problems.list()) fmt::print(stderr, "{}\n", problem.text());
  if (a.list) {
    for (const cell::ProgramTest& t : tests) fmt::print("{}:{} {}\n", t.file.string(), t.line, t.name);
    return problems.has_errors() ? kFailed : kOk;
  }
  if (tests.empty() && !problems.has_errors())
    throw Error("no-tests", "there are no tests in '" + a.path + "'",
                "a file of tests is a .script with test \"…\" … end");
  const int code = run_all(tests, a);
  return problems.has_errors() ? kFailed : code;
}

}  // namespace polyarm::apps
