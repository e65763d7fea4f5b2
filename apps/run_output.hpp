#pragma once
#include <memory>
#include <string>

#include "polyarm/cell/observer.hpp"
#include "polyarm/cell/run.hpp"

namespace polyarm::apps {

/// Tells a person, on a terminal or in a log, what happens in a run.
std::unique_ptr<cell::Observer> make_text_observer(bool quiet);
/// One JSON object per line on standard output.
std::unique_ptr<cell::Observer> make_json_observer();

void print_result(const cell::RunResult& result, const std::string& failure_folder);
std::string result_json(const cell::RunResult& result, const std::string& failure_folder);

}  // namespace polyarm::apps
