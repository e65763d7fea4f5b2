#pragma once
/// Takes samples for `polyarm calibrate` from a running cell, one at each Enter.
#include <string>
#include <vector>

#include "polyarm/calibration/samples.hpp"

namespace polyarm::apps {

struct RecordOptions {
  std::string kind, cell, robot;
  std::string
      marker;  ///< a pose of the cell's data: what the camera sees, or what a measuring device measures
};

/// Reads Enter until the end of the input or an empty answer to a question. Nothing moves. Sets
/// `options.robot` to the name of the robot that the samples are of.
std::vector<calibration::Sample> record_samples(RecordOptions& options);

}  // namespace polyarm::apps
