#pragma once
/// Signals of a controller that have numbers, most of them from 1. Throws Error("bad-value") for texts that
/// are not understood.
#include <string>
#include <utility>

namespace polyarm::wire {

struct SignalRange {
  int first = 1, count = 0;
};

/// "1-16", "3", "": a range within `least` and `most`. `parameter` is named in the error.
SignalRange signal_range(const std::string& parameter, const std::string& text, int most, int least = 1);
/// "1=2": the output 1 of a simulated controller is wired to its input 2; both within `least` and `most`.
std::pair<int, int> signal_wire(const std::string& text, int most, int least = 1);

}  // namespace polyarm::wire
