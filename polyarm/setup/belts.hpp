#pragma once
/// The belts and turntables of a cell file: frames that move with an encoder.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/moves/frame_ride.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::cell {

/// Places on a belt are m along its x axis, on a turntable rad about its z axis.
struct BeltEntry {
  std::string name;
  moves::MovingFrame frame;  ///< where the encoder reads zero
  std::string encoder;       ///< a state of the hardware, or a tag
  double scale = 1;          ///< m or rad per count
  double wraps = 0;          ///< counts after which the encoder begins again at zero; 0: it does not
  std::string sensor;        ///< counts the parts that come, or is true while it sees one; empty: none
  std::string latch;         ///< the encoder at the newest part; empty: the encoder in the cell's cycle
  double sensor_at = 0;      ///< place of the sensor
  double from = 0, start_by = 0, to = 0;  ///< the places in which robots may follow
  double lead = 0;                        ///< s from a command to its effect
  Location where;
};

/// `belts: {line: {at: …, encoder: …}}`.
std::vector<BeltEntry> read_belts(const Yaml& yaml, Problems& problems);

}  // namespace polyarm::cell
