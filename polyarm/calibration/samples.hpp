#pragma once
/// Files of samples, as YAML or CSV. Any thread; nothing here reads files.
///
/// YAML: `polyarm: samples/1` and a list `samples`, each a map:
///   flange, marker, measured, along_z, along_x   poses: a list of x y z roll pitch yaw or x y z qx qy qz qw,
///   or a map of `xyz` and `rpy` or
///                              `quaternion`
///   point, known, force, torque, angular_velocity, angular_acceleration, acceleration   lists of three
///   q, v, a, tau               maps from joints to numbers
/// CSV: a line of names, then a line of numbers for each sample: flange.x, flange.y, flange.z and
/// flange.roll, flange.pitch, flange.yaw or flange.qx … flange.qw; point.x …; q.JOINT …. Lines that begin
/// with # are comments.
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::calibration {

/// The largest number of samples of a file, and of joints of a sample.
inline constexpr std::size_t kMostSamples = 10'000, kMostJoints = 128;

/// One sample with its place in the file. SI units.
struct Sample {
  Location where;
  std::map<std::string, Pose> poses;
  std::map<std::string, Vec3> vectors;
  std::map<std::string, std::map<std::string, double>> joints;

  // Throw Error("missing-key") with the place of the sample.
  const Pose& pose(const std::string& name) const;
  const Vec3& vector(const std::string& name) const;
  Vec3 vector_or_zero(const std::string& name) const;
  /// The values of these joints, in this order; also throws if a name is unknown.
  std::vector<double> values(const std::string& name, const std::vector<std::string>& joints) const;
};

/// Reads YAML, or CSV if the name ends in .csv. Throws Error with all problems, each with its line.
std::vector<Sample> read_samples(std::string_view text, const std::string& file);
/// As YAML; reads back to the same samples.
std::string samples_text(const std::vector<Sample>& samples);

}  // namespace polyarm::calibration
