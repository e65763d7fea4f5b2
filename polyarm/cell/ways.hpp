#pragma once
/// Why a request about stopped motion cannot be now, and what can. Cell thread.
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/protocol/motion.hpp"

namespace polyarm::cell {

class Cell;

/// Each: empty where it can be now; else why not, with the request that leads on.
std::optional<Problem> why_no_resume(const Cell& cell);
std::optional<Problem> why_no_discard(const Cell& cell);
std::optional<Problem> why_no_back(const Cell& cell);
std::optional<Problem> why_no_recover(const Cell& cell);
/// Statements of a program go on only while the cell runs.
std::optional<Problem> why_no_statement(const Cell& cell);

/// All of them, and for each robot why it cannot be jogged.
protocol::PossibleNow possible_now(Cell& cell);

}  // namespace polyarm::cell
