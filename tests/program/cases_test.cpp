/// Every file in tests/program/cases is a program that says on its lines what is expected:
///   # given NAME: True | 3 | 5mm | "text" | point     before it starts
///   log …          # expect: a | b                    what this line logs, in its order
///   …              # expect error: part of the text   of a finding of the parser or checker on this line
///   …              # expect warning: part
///   …              # expect failure: part             of what ends the run on this line
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "fake_host.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/program/lexer.hpp"
#include "polyarm/program/parser.hpp"

namespace polyarm::program {
namespace {

struct Expectations {
  std::map<int, std::vector<std::string>> logs;
  std::multimap<int, std::string> errors, warnings, failures;
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
    if (const auto text = after(line, "# expect error:"); !text.empty()) out.errors.emplace(i, text);
    if (const auto text = after(line, "# expect warning:"); !text.empty()) out.warnings.emplace(i, text);
    if (const auto text = after(line, "# expect failure:"); !text.empty()) out.failures.emplace(i, text);
  }
  return out;
}

data::Value given_value(const std::string& text) {
  if (text == "True" || text == "False") return text == "True";
  if (text == "point") return data::Point{};
  if (text.starts_with('"')) return text.substr(1, text.size() - 2);
  const auto tokens = read_tokens(text, {1, 1});
  return data::Number{tokens[0].number, tokens[0].dimension};
}

void give(FakeHost& host, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    if (!line.starts_with("# given ")) continue;
    const auto colon = line.find(':');
    host.store.declare_tag(std::string(trim(std::string_view(line).substr(8, colon - 8))),
                           given_value(std::string(trim(std::string_view(line).substr(colon + 1)))));
  }
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
  std::map<int, std::vector<std::string>> logs;
  for (const auto& [line, text] : host.logs) logs[line].push_back(text);
  EXPECT_EQ(logs, expected.logs);
  const TaskStatus status = interpreter.status().front();
  if (expected.failures.empty()) {
    EXPECT_NE(status.state, TaskState::failed) << status.problem->text();
    return;
  }
  ASSERT_EQ(status.state, TaskState::failed);
  EXPECT_EQ(status.problem->where.line, expected.failures.begin()->first) << status.problem->text();
  EXPECT_NE(status.problem->text().find(expected.failures.begin()->second), std::string::npos)
      << status.problem->text();
}

class Case : public testing::TestWithParam<std::string> {};

TEST_P(Case, DoesWhatItsLinesSay) {
  const std::string path = std::string(POLYARM_SOURCE_DIR) + "/tests/program/cases/" + GetParam() + ".script";
  FakeHost host;
  Problems problems;
  Program program = parse(read_file(path), path, problems);
  const Expectations expected = read_expectations(program.lines);
  give(host, program.lines);
  KnownNames known;
  known.add(host.store);
  check(program, known, problems);
  compare_findings(problems, expected);
  const bool runs = !problems.has_errors() || !expected.failures.empty();
  EXPECT_TRUE(runs || expected.logs.empty()) << "a program with errors does not run";
  if (!runs) return;
  Interpreter interpreter(std::move(program), host);
  run(interpreter, host, nanoseconds(60));
  compare_run(host, interpreter, expected);
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
