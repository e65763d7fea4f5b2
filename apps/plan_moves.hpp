#pragma once
/// Moves as words of a command line: movel Pick blend=20mm movej home.
#include <string>
#include <vector>

#include "polyarm/data/data_set.hpp"
#include "polyarm/moves/move_plan.hpp"

namespace polyarm::apps {

/// How fast, as people write it: "50%", "250mm/s", "90deg/s". Empty texts change nothing.
struct PaceWords {
  std::string speed, acceleration, blend;
};
/// Throws Error("bad-value") that names `option` and the text.
struct PaceValue {
  double share = 1;    ///< of the limits
  double tcp = 0;      ///< m/s or m/s²; 0: says nothing
  double angular = 0;  ///< rad/s or rad/s²
};
PaceValue parse_speed(const std::string& text, const std::string& option);
PaceValue parse_acceleration(const std::string& text, const std::string& option);

/// What names in moves may mean.
struct NamedPlaces {
  const moves::RobotFacts& robot;
  std::vector<data::DataSet> sets;  ///< a later one has the last word
  std::vector<std::string> names() const;
};

/// The moves of `words`: movej, movel, movec, spline (or joint, line, arc), each with its targets and then
/// what holds for it alone (blend=, speed=, acceleration=, duration=, orientation=). A target is joints(…),
/// pose(x, y, z[, roll, pitch, yaw | , qx, qy, qz, qw]), by(x, y, z) from where the TCP is in the world's
/// axes or tool(x, y, z) in its own, a name of a place, or a named state of the robot such as home. `from`:
/// the joint state at the start. Throws Error("bad-move" | "unknown-name" | "bad-value").
std::vector<moves::Move> parse_moves(const std::vector<std::string>& words, const NamedPlaces& places,
                                     const std::vector<double>& from, const PaceWords& all);

/// A word that begins a move.
bool is_move_word(const std::string& word);

/// "movel Pick", for messages.
std::string text_of(const moves::Move& move);

}  // namespace polyarm::apps
