/// Every file in tests/program/cases is a program that says on its lines what is expected:
///   # given NAME: True | 3 | 5mm | "text" | point | point 1 2 3 | joints     before it starts
///   # after 150ms NAME: True                          what somebody else sets then
///   # answer 4                                        what a person answers, one line for each question
///   # expect arrivals: 2                              how often it waits for queued motion
///   movel A           # expect move: line A exact     what the cell is asked for by this line, in its order
///   log …          # expect: a | b                    what this line logs, in its order
///   …              # expect error: part of the text   of a finding of the parser or checker on this line
///   …              # expect warning: part
///   …              # expect failure: part             of what ends the run on this line
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>

#include "fake_host.hpp"
#include "given.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/language/functions.hpp"
#include "polyarm/language/lexer.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/language/words.hpp"
#include "polyarm/program/checker.hpp"

namespace polyarm::program {
namespace {

struct Expectations {
  std::map<int, std::vector<std::string>> logs, moves;
  std::multimap<int, std::string> errors, warnings, failures;
  std::optional<int> arrivals;
};

std::string after(const std::string& line, const std::string& mark) {
  const auto at = line.find(mark);
  return at == std::string::npos ? "" : std::string(trim(std::string_view(line).substr(at + mark.size())));
}

Expectations read_expectations(const std::vector<std::string>& lines) {
  Expectations out;
  for (int i = 1; i <= static_cast<int>(lines.size()); ++i) {
    const std::string& line = lines[static_cast<std::size_t>(i) - 1];
    if (const auto text = after(line, "# expect:"); !text.empty()) out.logs[i] = split_fields(text, '|');
    if (const auto text = after(line, "# expect move:"); !text.empty())
      out.moves[i] = split_fields(text, '|');
    if (const auto text = after(line, "# expect arrivals:"); !text.empty()) out.arrivals = std::stoi(text);
    if (const auto text = after(line, "# expect error:"); !text.empty()) out.errors.emplace(i, text);
    if (const auto text = after(line, "# expect warning:"); !text.empty()) out.warnings.emplace(i, text);
    if (const auto text = after(line, "# expect failure:"); !text.empty()) out.failures.emplace(i, text);
  }
  return out;
}

/// What others set while the program runs.
struct Later {
  Nanoseconds at = 0;
  std::string name;
  data::Value value;
};

std::vector<Later> read_later(const std::vector<std::string>& lines) {
  std::vector<Later> out;
  for (const std::string& line : lines) {
    if (!line.starts_with("# after ")) continue;
    const auto words = split_words(line);
    const auto colon = line.find(':');
    const double seconds = given_value(words.at(2)).as_number()->value;
    const auto name_at = line.find(words.at(2)) + words.at(2).size();
    out.push_back({nanoseconds(seconds),
                   std::string(trim(std::string_view(line).substr(name_at, colon - name_at))),
                   given_value(std::string(trim(std::string_view(line).substr(colon + 1))))});
  }
  return out;
}

void compare_findings(const Problems& problems, Expectations expected) {
  for (const Problem& problem : problems.list()) {
    auto& list = problem.severity == Severity::error ? expected.errors : expected.warnings;
    const auto [first, last] = list.equal_range(problem.where.line);
    const auto at = std::find_if(
        first, last, [&](const auto& e) { return problem.text().find(e.second) != std::string::npos; });
    EXPECT_NE(at, last) << "not expected: " << problem.text();
    if (at != last) list.erase(at);
  }
  for (const auto& [line, text] : expected.errors)
    ADD_FAILURE() << "no error in line " << line << ": " << text;
  for (const auto& [line, text] : expected.warnings)
    ADD_FAILURE() << "no warning in line " << line << ": " << text;
}

void compare_run(const FakeHost& host, const Interpreter& interpreter, const Expectations& expected) {
  std::map<int, std::vector<std::string>> logs, moves;
  for (const auto& [line, text] : host.logs) logs[line].push_back(text);
  EXPECT_EQ(logs, expected.logs);
  for (const auto& [line, text] : host.asked)
    if (expected.moves.contains(line)) moves[line].push_back(text);
  EXPECT_EQ(moves, expected.moves);
  EXPECT_EQ(host.arrivals_requested, expected.arrivals.value_or(host.arrivals_requested));
  const TaskStatus status = interpreter.overview();
  if (expected.failures.empty()) {
    EXPECT_NE(status.state, TaskState::failed) << status.problem->text();
    return;
  }
  ASSERT_EQ(status.state, TaskState::failed);
  EXPECT_EQ(status.problem->where.line, expected.failures.begin()->first) << status.problem->text();
  EXPECT_NE(status.problem->text().find(expected.failures.begin()->second), std::string::npos)
      << status.problem->text();
}

void run_case(const std::string& text, const std::string& path) {
  FakeHost host;
  Problems problems;
  Program program = parse(text, path, problems);
  const Expectations expected = read_expectations(program.lines);
  give(host, program.lines);
  KnownNames known;
  known.add(host.store);
  check(program, known, problems);
  compare_findings(problems, expected);
  const bool runs = !problems.has_errors() || !expected.failures.empty();
  EXPECT_TRUE(runs || (expected.logs.empty() && expected.moves.empty()))
      << "a program with errors does not run";
  if (!runs) return;
  host.folder = std::string(POLYARM_SOURCE_DIR) + "/examples/pick_and_place";
  for (const std::string& line : program.lines)
    if (line.starts_with("# answer")) host.given_answers.emplace_back(trim(std::string_view(line).substr(8)));
  const auto test = tests(program).empty() ? std::nullopt : std::optional<std::size_t>(0);
  Interpreter interpreter(std::move(program), host, test);
  const std::vector<Later> later = read_later(interpreter.program().lines);
  run(interpreter, host, nanoseconds(60), [&] {
    for (const Later& each : later)
      if (host.time >= each.at && host.time < each.at + 2'000'000)
        host.store.set(each.name, each.value, "others");
  });
  compare_run(host, interpreter, expected);
}

class Case : public testing::TestWithParam<std::string> {};

TEST_P(Case, DoesWhatItsLinesSay) {
  const std::string path = std::string(POLYARM_SOURCE_DIR) + "/tests/program/cases/" + GetParam() + ".script";
  run_case(read_file(path), path);
}

/// Runs the programs between ``` on a page; returns how many there are.
int run_page(const std::string& name) {
  const std::string path = std::string(POLYARM_SOURCE_DIR) + "/docs/" + name;
  std::string text;
  bool inside = false, is_program = false;
  int programs = 0;
  for (const std::string& line : split_lines(read_file(path))) {
    if (!line.starts_with("```")) {
      if (inside) text += line + "\n";
      continue;
    }
    if (!inside) is_program = line == "```";
    if (inside && is_program) {
      SCOPED_TRACE(text);
      run_case(text, path);
      ++programs;
    }
    inside = !inside;
    text.clear();
  }
  return programs;
}

TEST(Manual, EveryProgramInItDoesWhatItsLinesSay) {
  EXPECT_GT(run_page("language.md"), 8);
  EXPECT_EQ(run_page("searches.md"), 3);
  EXPECT_EQ(run_page("moves.md"), 3);
}

TEST(Reference, EveryProgramInItDoesWhatItsLinesSay) {
  EXPECT_GT(run_page("language-reference.md"), 70);
}

TEST(Reference, IsWhatTheLanguageIs) {
  EXPECT_EQ(read_file(std::string(POLYARM_SOURCE_DIR) + "/docs/language-reference.md"), language_reference())
      << "write it anew: polyarm language page > docs/language-reference.md";
}

TEST(Reference, ShowsEveryWordAndFunction) {
  const auto& all = words();
  for (const Word& word : all) {
    const auto shown =
        std::find_if(all.begin(), all.end(), [&](const Word& w) { return w.name == word.shown_by; });
    EXPECT_TRUE(!word.example.empty() || (shown != all.end() && !shown->example.empty())) << word.name;
  }
  const std::string page = language_reference();
  for (const Function& function : functions())
    EXPECT_NE(page.find("`" + std::string(function.signature) + "`  \n" + std::string(function.meaning) +
                        "\n\n```"),
              std::string::npos)
        << function.name;
}

/// Every word of the language may be the name of a variable, a point and a function's parameter.
TEST(Words, NoneButTheReservedOnesAreTakenFromNames) {
  for (const Word& word : words()) {
    if (word.role == WordRole::reserved) continue;
    const std::string name(word.name);
    SCOPED_TRACE(name);
    run_case("let " + name + " = 1\nset " + name + " = " + name + " + 1\nlog(" + name +
                 ")  # expect: 2\nif " + name + " > 1\n  log(\"{" + name + "}\")  # expect: 2\nend\n",
             "words.script");
    run_case("# given " + name + ": point\nmovej " + name + "  # expect move: joint " + name +
                 " exact\nmovel offset(" + name + ", z = 1mm), frame " + name +
                 ", speed 50%  # expect move: line offset(" + name + ", …) speed 0.5 frame " + name +
                 " exact\n",
             "words.script");
    run_case("# given " + name + ": True\nwait " + name + "\nset " + name + " False\nwhile " + name +
                 "\n  wait 1s\nend\nlog(" + name + ")  # expect: False\n",
             "words.script");
    run_case("func twice(" + name + ")\n  return " + name + " * 2\nend\nlog(twice(" + name +
                 " = 2))  # expect: 4\n",
             "words.script");
  }
}

std::vector<std::string> case_names() {
  std::vector<std::string> out;
  for (const auto& file :
       std::filesystem::directory_iterator(std::string(POLYARM_SOURCE_DIR) + "/tests/program/cases"))
    if (file.path().extension() == ".script") out.push_back(file.path().stem().string());
  std::sort(out.begin(), out.end());
  return out;
}

INSTANTIATE_TEST_SUITE_P(Programs, Case, testing::ValuesIn(case_names()),
                         [](const auto& each) { return each.param; });

}  // namespace
}  // namespace polyarm::program
