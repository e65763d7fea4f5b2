#pragma once
/// What the simulated controllers of `polyarm far-side` share: words, and the lines that a person types.
#include <array>
#include <functional>
#include <string>
#include <utility>

namespace polyarm::apps {

/// One line of what happens; it also goes to a pipe at once. Any thread.
void tell(const std::string& text);
/// "0=3": an output and the input that follows it. Throws WrongUse.
std::pair<int, int> wire_of(const std::string& text, int lowest, int highest);
/// Takes lines from the standard input until a signal: `state` calls show(), any other order(line).
void serve_far_side(const std::function<void()>& show, const std::function<void(const std::string&)>& order);

/// Six angles in degrees, such as "0 0 0 0 -90 0"; `otherwise` for an empty text. Throws WrongUse.
std::array<double, 6> start_of(const std::string& text, std::array<double, 6> otherwise);

int run_far_side_ur(int argc, char** argv);
int run_far_side_fanuc(int argc, char** argv);
int run_far_side_abb(int argc, char** argv);
int run_far_side_kuka(int argc, char** argv);
int run_far_side_yaskawa(int argc, char** argv);
int run_far_side_xarm(int argc, char** argv);
int run_far_side_franka(int argc, char** argv);
int run_far_side_cia402(int argc, char** argv);

}  // namespace polyarm::apps
