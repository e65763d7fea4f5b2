#pragma once
/// Tests of programs: `test` blocks in files beside the program of a cell, run in lock-step.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::cell {

/// One test and its cell.
struct ProgramTest {
  std::filesystem::path file;
  std::size_t index = 0;  ///< index among the tests of the file
  std::string name;
  int line = 0;
  std::filesystem::path cell;  ///< folder of the cell.yaml: the file's folder or one above
};

/// Finds the tests in all test files (*.script) at `path`, a file or a folder, ordered by file name. Errors
/// of a test file are added to `problems`, and its tests are left out.
std::vector<ProgramTest> find_tests(const std::filesystem::path& path, Problems& problems);

struct TestOptions {
  Overrides overrides;
  double seconds = 600;                ///< limit of cell time for one test, s
  std::filesystem::path state_folder;  ///< folder for the test's data files
};

struct TestResult {
  std::vector<Problem> problems;  ///< why it failed; empty if it passed
  std::vector<std::string> log;   ///< log of program, PLC and test
  double cell_time_s = 0;
};

/// Runs one test in a cell of its own. The program starts at the test's `run`; the cell and its PLC start at
/// the beginning. Do not call from two threads at the same time.
TestResult run_test(const ProgramTest& test, const description::Catalogue& catalogue,
                    const TestOptions& options);

}  // namespace polyarm::cell
