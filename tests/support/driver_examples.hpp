#pragma once
/// What the examples of drivers owe their users, the same for each maker: they run as the command, on the
/// driver's simulated controller.
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"

namespace polyarm::test {

/// Replaces the first `from` of a pair with its `to`, in a file of the copy.
inline void edit(const ExampleCopy& copy, const std::string& file,
                 std::initializer_list<std::pair<std::string, std::string>> changes) {
  std::string text = read_file(copy.file(file));
  for (const auto& [from, to] : changes) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  }
  write_file_atomically(copy.file(file), text);
}

inline Finished run_fast(const ExampleCopy& copy, std::vector<std::string> more = {}) {
  std::vector<std::string> line{"run", copy.path(), "--fast", "--json", "--no-socket"};
  line.insert(line.end(), more.begin(), more.end());
  return run_command(line);
}

inline void expect_words(const std::string& output, std::initializer_list<const char*> words) {
  for (const char* one : words) EXPECT_NE(output.find(one), std::string::npos) << one << " in " << output;
}

inline void expect_same_run_twice(const ExampleCopy& copy, const char* words) {
  const Finished first = run_fast(copy);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.result()["result"], "completed");
  expect_words(first.output, {words});
  EXPECT_EQ(run_fast(copy).result()["trace_hash"], first.result()["trace_hash"]);
}

/// `change`: of cell.yaml, for the fault. `words`: the cause, and what to do.
inline void expect_fault_ends_the_run(const char* example, const std::pair<std::string, std::string>& change,
                                      std::initializer_list<const char*> words) {
  const ExampleCopy copy(example);
  edit(copy, "cell.yaml", {change});
  const Finished ran = run_fast(copy);
  EXPECT_EQ(ran.exit_code, 1);
  expect_words(ran.output, words);
}

/// A person at the terminal arms the cell, whose controller is in another process.
inline void expect_armed_run_completes(const ExampleCopy& copy, std::vector<std::string> more = {}) {
  std::vector<std::string> line{"run", copy.path(), "--real", "--json", "--no-socket"};
  line.insert(line.end(), more.begin(), more.end());
  Command cell(line, Input::terminal);
  if (cell.wait_for("nothing moves before a person types")) cell.type("arm\n");
  const Finished ran = cell.wait();
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed");
}

// --- forward mode ---

inline void expect_until_ends_a_line(const char* example) {
  const ExampleCopy copy(example);
  write_file_atomically(copy.file("placing.script"),
                        "load job\nmovej AbovePick\nset Vacuum = true\n"
                        "movel AbovePlace speed 5% until Holds\nmovel Place\n");
  const Finished ran = run_fast(copy);
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_EQ(ran.result()["result"], "completed");
  // The whole line takes more than 5 s at this speed.
  EXPECT_LT(ran.result()["sim_time_s"].get<double>(), 5) << ran.output;
}

inline void expect_same_program_streams(const char* example) {
  const ExampleCopy copy(example);
  edit(copy, "cell.yaml", {{"motion: forward", "motion: stream"}});
  const Finished ran = run_fast(copy);
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

inline void expect_check_names_moves(const char* example) {
  const ExampleCopy copy(example);
  write_file_atomically(copy.file("placing.script"),
                        "load job\nmovej AbovePick\nmovel [Over, AbovePlace, Place], smooth\n");
  const Finished ran = run_command({"check", copy.path()});
  EXPECT_EQ(ran.exit_code, 1) << ran.output;
  expect_words(ran.output, {"`motion: forward`", "placing.script:3"});
}

/// A program of the thesis, and how many parts it places.
struct ThesisCell {
  const char* example;
  std::size_t parts;
};
inline std::string thesis_name(const testing::TestParamInfo<ThesisCell>& named) {
  return named.param.example;
}

/// Every part is in its place.
inline void expect_all_placed(const Finished& ran, std::size_t parts) {
  ASSERT_EQ(ran.exit_code, 0) << ran.output.substr(ran.output.size() > 3000 ? ran.output.size() - 3000 : 0);
  const nlohmann::json result = ran.result();
  EXPECT_EQ(result["result"], "completed");
  ASSERT_EQ(result["parts"].size(), parts);
  for (const auto& part : result["parts"]) {
    EXPECT_EQ(part["state"], "placed") << part;
    EXPECT_LE(part["error_m"].get<double>(), 0.005) << part;
  }
}

}  // namespace polyarm::test
