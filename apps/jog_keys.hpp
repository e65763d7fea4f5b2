#pragma once
/// The screen on which a robot is moved by keys, with its live state.
#include <chrono>
#include <functional>
#include <string>

#include "apps/client.hpp"

namespace polyarm::apps {

/// How often a jog that goes on is sent, and how long an answer is waited for.
inline constexpr std::chrono::milliseconds kSendEvery{50};
inline constexpr int kPatience = 2000;  // ms

struct JogScreen {
  std::string robot;  ///< empty: the only one of the cell
  std::string frame;  ///< the user's own, beside base, world and tool; it begins with the TCP along it
  bool tcp = false;   ///< begins with the TCP, not with joints
  double first = 0.7, hold = 0.3;  ///< s until the first repeat of a key, and without one until it stops
  /// Where given, Enter keeps the place: it is told the state of `jog.state` and returns what it kept, a
  /// sentence. The robot stands and the terminal reads lines meanwhile.
  std::function<std::string(const Json& state)> keep;
};

/// Until the person ends it. Throws Error("no-terminal") where standard input is none, "cell-gone",
/// "no-answer".
void jog_by_keys(Client& client, const JogScreen& screen);

/// The keys of the screen, for help.
extern const char* const kJogKeys;

/// Joint values and the TCP of `jog.state`, a line each.
std::string joints_line(const Json& state);
std::string tcp_line(const Json& state);

/// A value as a screen has it: 12.34° or 56.78 mm.
std::string joint_text(double value, bool slides);
/// Where between its limits a joint is, `width` columns; blank where it turns without end.
std::string range_bar(double value, const Json& limits, std::size_t width);
/// Columns of the terminal; 80 where nobody knows.
int terminal_columns();
/// What of a line fits into one row of the terminal.
std::string fitting(const std::string& line);

}  // namespace polyarm::apps
