#pragma once
/// Tests of programs: `test` blocks that stand beside the program of a cell and run in lock-step.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::cell {

/// One test and the cell that it belongs to.
struct ProgramTest {
  std::filesystem::path file;
  std::size_t index = 0;  ///< among the tests of the file
  std::string name;
  int line = 0;
  std::filesystem::path cell;  ///< folder with the cell.yaml: that of the file, or one above
};

/// The tests of every file of tests (*.script) at `path`, a file or a folder, in the order of the names of
/// the files. What is wrong with a file of tests joins the problems, and its tests are left out.
std::vector<ProgramTest> find_tests(const std::filesystem::path& path, Problems& problems);

struct TestOptions {
  Overrides overrides;
  double seconds = 600;                ///< of cell time that a test may take
  std::filesystem::path state_folder;  ///< where it keeps its data files
};

struct TestResult {
  std::vector<Problem> problems;  ///< why it failed; none: it passed
  std::vector<std::string> log;   ///< what program, PLC and test told
  double cell_time_s = 0;
};

/// Runs one test in a cell of its own. The program starts where the test says `run`; the cell and its PLC run
/// from the beginning. Not for two threads at the same time.
TestResult run_test(const ProgramTest& test, const description::Catalogue& catalogue,
                    const TestOptions& options);

}  // namespace polyarm::cell
