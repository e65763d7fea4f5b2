#pragma once
/// Enumerates the variants of a sweep without making a list of them: a number gives a variant.
#include <cstdint>
#include <string>
#include <vector>

#include "polyarm/sweeps/sweep.hpp"

namespace polyarm::sweeps {

class Variants {
 public:
  /// Throws Error("bad-zip" | "too-many") if axes that are zipped differ in length, or for too many variants.
  /// `sweep` must outlive it.
  explicit Variants(const Sweep& sweep);

  /// Number of variants, after a sample is drawn.
  std::uint64_t count() const { return count_; }
  /// All combinations, before a sample is drawn.
  std::uint64_t all() const { return all_; }
  /// `number` < count(). With a sample the numbers are in random order, each variant at most once.
  Variant at(std::uint64_t number) const;

 private:
  std::uint64_t shuffled(std::uint64_t number) const;

  const Sweep& sweep_;
  std::vector<std::uint64_t> lengths_;  ///< of robots, places, programs, speeds, faults, seeds, values…
  std::uint64_t all_ = 1, count_ = 0;
};

/// Identifies what a variant tries, whatever its number: 32 hexadecimal digits. `robot_hash`: of the robot's
/// description.
std::string key_of(const Variant& variant, const std::string& robot_hash);

/// "x -0.1, yaw 90°"; "as in the cell" for an empty place.
std::string text_of(const Place& place);
/// "Count=2 Kind=a"; empty without values.
std::string values_text(const Variant& variant);

/// The deviations that a seed gives: uniform in [-1, 1], the same on every machine.
class Deviations {
 public:
  explicit Deviations(std::uint64_t seed) : state_(seed) {}
  double next();

 private:
  std::uint64_t state_;
};

}  // namespace polyarm::sweeps
