#pragma once
/// Output of `polyarm run`: text for people or JSON lines.
#include <memory>
#include <string>

#include "polyarm/cell/run.hpp"
#include "polyarm/setup/observer.hpp"

namespace polyarm::apps {

/// Receives a run's events for standard output.
class Output : public cell::Observer {
 public:
  /// Waits until everything is written; false if nobody reads the output.
  virtual bool settle() = 0;
};

/// Prints the events of a run as text, on a terminal or into a log.
/// @param typed a user may type commands such as resume.
/// @param whole wait for a slow reader; otherwise lines are dropped if nobody reads them.
std::unique_ptr<Output> make_text_output(bool quiet, bool whole, bool typed);
/// One JSON object per line on standard output.
std::unique_ptr<Output> make_json_output(bool whole);

void print_result(const cell::RunResult& result, const std::string& failure_folder);
std::string result_json(const cell::RunResult& result, const std::string& failure_folder);

}  // namespace polyarm::apps
