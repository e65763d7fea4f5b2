#pragma once
#include <memory>
#include <string>

#include "polyarm/cell/run.hpp"
#include "polyarm/setup/observer.hpp"

namespace polyarm::apps {

/// What standard output is told of a run.
class Output : public cell::Observer {
 public:
  /// Waits until what was told is written; false where nobody reads it.
  virtual bool settle() = 0;
};

/// Tells a person, on a terminal or in a log, what happens in a run.
/// @param typed somebody may type words such as resume.
/// @param whole waits for a slow reader; without it lines are left out where nobody reads them.
std::unique_ptr<Output> make_text_output(bool quiet, bool whole, bool typed);
/// One JSON object per line on standard output.
std::unique_ptr<Output> make_json_output(bool whole);

void print_result(const cell::RunResult& result, const std::string& failure_folder);
std::string result_json(const cell::RunResult& result, const std::string& failure_folder);

}  // namespace polyarm::apps
