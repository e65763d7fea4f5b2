#pragma once
/// What a sweep tries: one program or several on many robots, base places, speeds and faults. Data only. SI
/// units.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::sweeps {

/// Bounds of a sweep file; more is refused with the place in the file.
inline constexpr std::size_t kMostValues = 100'000;  ///< of one axis
inline constexpr std::size_t kMostAxes = 32;         ///< `values` and varied points
inline constexpr std::size_t kMostSteps = 100;       ///< of one fault
inline constexpr double kMostVariants = 1e12;

/// Where the robot's base stands in the world. A coordinate without a value is that of the cell file. m, rad.
struct Place {
  std::optional<double> x, y, z, yaw;
  friend bool operator==(const Place&, const Place&) = default;
};

/// One action of a fault, at a time of the cell.
struct FaultStep {
  double at_s = 0;
  std::optional<double> for_s;          ///< the forced values end after this time; empty: they stay
  std::map<std::string, double> force;  ///< interface → value
  std::string person;                   ///< typed words: hold, resume, stop; empty: none
  bool emergency_stop = false;          ///< every joint brakes at its maximum
};

struct Fault {
  std::string name;
  std::vector<FaultStep> steps;  ///< empty: nothing fails
  std::string text;              ///< all of it in one line, for the key of a variant
};

/// Values of one name of the cell (tag or variable), as written.
struct ValueAxis {
  std::string name;
  std::vector<std::string> values;
  Location where;
};

/// Random deviations; the seed of a variant decides them. Uniform between minus and plus this.
struct Vary {
  double base = 0;                       ///< x and y of the base, m
  double yaw = 0;                        ///< of the base, rad
  std::map<std::string, double> points;  ///< x, y and z of points of the cell, m
  bool any() const { return base > 0 || yaw > 0 || !points.empty(); }
};

enum class Combine { product, zip };

/// A sweep file, with its names resolved. Each axis has at least one value; the empty text and the empty
/// place are those of the cell file.
struct Sweep {
  std::filesystem::path file;  ///< of the sweep
  std::string name;
  std::filesystem::path cell;  ///< folder or file of the cell, absolute
  std::string robot;           ///< the robot of the cell that is exchanged and moved; empty: its only one
  std::vector<std::string> robots;  ///< models
  std::vector<Place> places;
  std::vector<std::string> programs;
  std::vector<double> speeds;  ///< override, share of the programmed speed
  std::vector<Fault> faults;
  std::vector<std::uint64_t> seeds;
  std::vector<ValueAxis> values;
  Combine combine = Combine::product;
  std::optional<std::uint64_t> sample;  ///< so many random variants
  std::uint64_t sample_seed = 1;
  std::string hardware;  ///< for every robot; empty: as in the cell file
  std::uint64_t cycles = 3;
  double seconds = 600;        ///< of cell time, at most
  double patience = 600;       ///< wall time of one variant, at most, s
  double clearance = 0.1;      ///< distances up to this are measured, m; 0: none are
  double least_clearance = 0;  ///< variants with less are no candidates, m
  Vary vary;
  /// Places in the file of what it names: programs, values, points, interfaces, "robot".
  std::map<std::string, Location> where;
};

/// One variant: a value of each axis.
struct Variant {
  std::uint64_t number = 0;  ///< in the order of the sweep; changes with the file
  std::string robot;
  Place place;
  std::string program;
  double speed = 1;
  const Fault* fault = nullptr;  ///< of the sweep
  std::uint64_t seed = 1;
  std::vector<std::pair<std::string, std::string>> values;
};

}  // namespace polyarm::sweeps
