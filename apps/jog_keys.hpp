#pragma once
/// The terminal screen for jogging with keys; shows the robot's live state.
#include <chrono>
#include <functional>
#include <string>

#include "apps/client.hpp"

namespace polyarm::apps {

/// Interval of jog messages, and timeout of an answer.
inline constexpr std::chrono::milliseconds kSendEvery{50};
inline constexpr int kTimeout = 2000;  // ms

struct JogScreen {
  std::string robot;  ///< empty: the cell's only robot
  std::string frame;  ///< the user's own frame, in addition to base, world and tool; if given, jogging starts
                      ///< with the TCP in it
  bool tcp = false;   ///< start with the TCP instead of joints
  double first = 0.7, hold = 0.3;  ///< s: first: until the first repeat of a key; hold: without a repeat
                                   ///< until the motion stops
  /// If set, Enter calls this with the state of `jog.state` to store the position; returns a sentence about
  /// what was stored. Meanwhile the robot is at rest and the terminal reads lines.
  std::function<std::string(const Json& state)> keep;
};

/// Runs until the user ends it. Throws Error("no-terminal") if standard input is no terminal, "cell-gone" or
/// "no-answer".
void jog_by_keys(Client& client, const JogScreen& screen);

/// The screen's keys, for help texts.
extern const char* const kJogKeys;

/// Joint values and TCP of `jog.state`, one line each.
std::string joints_line(const Json& state);
std::string tcp_line(const Json& state);

/// A value for the screen: 12.34° or 56.78 mm.
std::string joint_text(double value, bool slides);
/// Bar of `width` columns that shows the joint within its limits; blank for a continuous joint.
std::string range_bar(double value, const Json& limits, std::size_t width);
/// Columns of the terminal; 80 if unknown.
int terminal_columns();
/// The part of a line that fits into one row of the terminal.
std::string fitting(const std::string& line);

}  // namespace polyarm::apps
