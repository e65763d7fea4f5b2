#pragma once
/// Parses moves from the words of a command line: movel Pick blend=20mm movej home.
#include <string>
#include <vector>

#include "polyarm/data/data_set.hpp"
#include "polyarm/moves/move_plan.hpp"

namespace polyarm::apps {

/// Speeds as text: "50%", "250mm/s", "90deg/s". Empty texts change nothing.
struct PaceWords {
  std::string speed, acceleration, blend;
};
/// A parsed speed or acceleration. The parse functions throw Error("bad-value") with `option` and the text.
struct PaceValue {
  double share = 1;    ///< share of the limits
  double tcp = 0;      ///< m/s or m/s²; 0: not given
  double angular = 0;  ///< rad/s or rad/s²
};
PaceValue parse_speed(const std::string& text, const std::string& option);
PaceValue parse_acceleration(const std::string& text, const std::string& option);

/// The named positions that moves may use.
struct NamedPlaces {
  const moves::RobotFacts& robot;
  std::vector<data::DataSet> sets;  ///< later sets take precedence
  std::vector<std::string> names() const;
};

/// Parses the moves in `words`: movej, movel, movec, spline (or joint, line, arc), each followed by its
/// targets and its own options (blend=, speed=, acceleration=, duration=, orientation=). A target is
/// joints(…), pose(x, y, z[, roll, pitch, yaw | , qx, qy, qz, qw]), by(x, y, z) relative to the TCP along the
/// world's axes or tool(x, y, z) along its own axes, a named position, or a named state of the robot such as
/// home. `from`: joint state at the start. Throws Error("bad-move" | "unknown-name" | "bad-value").
std::vector<moves::Move> parse_moves(const std::vector<std::string>& words, const NamedPlaces& places,
                                     const std::vector<double>& from, const PaceWords& all);

/// True for a word that begins a move.
bool is_move_word(const std::string& word);

/// "movel Pick", for messages.
std::string text_of(const moves::Move& move);

}  // namespace polyarm::apps
