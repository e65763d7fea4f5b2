#pragma once
/// The task that runs a `test` block in parallel to the program of its cell.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "polyarm/tasks/task.hpp"

namespace polyarm::cell {

struct CellInside;

/// Runs a test inside a cell. The task moves nothing, reads and sets every tag, and has the functions of
/// tests. It sees the program as tags: program.running, program.state, program.line, program.passes,
/// program.error.
class TestTask {
 public:
  /// Creates those tags. The test starts the program by its function `begin`.
  TestTask(CellInside& cell, program::Program tests, std::size_t index, ProgramHost::Context context,
           Problems& problems);
  void tick();
  bool ended() const { return task_->ended(); }
  std::optional<Problem> problem() const;

 private:
  data::Value call(std::string_view function, std::span<const data::Value> arguments, const Location& where);
  void person(const std::string& words, const Location& where);
  data::Value part(const std::string& name, const Location& where) const;
  void report_of_program();

  CellInside& cell_;
  std::unique_ptr<Task> task_;
  bool asks_for_error_ = false;  ///< the test reads program.error, so a failing program is expected
};

}  // namespace polyarm::cell
