#pragma once
/// Limits as rows at places of a path, and how close a profile comes to them. Part of timing.hpp; not for the
/// control cycle.
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "polyarm/timing/timed_path.hpp"
#include "polyarm/timing/timing.hpp"

namespace polyarm::timing {

/// Joints and norms at some places of a path. All lists are [row][place]: joints in order, then the
/// components of the norms.
class PathRows {
 public:
  PathRows(const paths::Path& path, std::span<const trajectory::MotionLimits> limits,
           std::span<const NormLimit> norms);

  /// Evaluates the path at `s`, and drops the previous places. Throws Error "bad-path".
  void look(const std::vector<double>& s);

  std::size_t places() const { return s_.size(); }
  double s(std::size_t place) const { return s_[place]; }
  std::size_t joints() const { return limits_.size(); }
  std::size_t rows() const { return limits_.size() + norms_.size(); }
  std::size_t components() const { return components_; }
  /// The first component of norm `n`; joints come first.
  std::size_t first_component(std::size_t norm) const { return component_begin_[norm]; }
  const double* first(std::size_t component) const { return &first_[component * places()]; }
  const double* second(std::size_t component) const { return &second_[component * places()]; }
  const double* third(std::size_t component) const { return &third_[component * places()]; }
  const trajectory::MotionLimits& limits(std::size_t joint) const { return limits_[joint]; }
  const NormLimit& norm(std::size_t n) const { return norms_[n]; }
  const paths::Path& path() const { return path_; }
  std::string name(std::size_t row) const;

 private:
  const paths::Path& path_;
  std::span<const trajectory::MotionLimits> limits_;
  std::span<const NormLimit> norms_;
  std::vector<std::size_t> component_begin_;
  std::size_t components_ = 0;
  std::vector<double> s_, first_, second_, third_, one_;
};

/// Highest use of limits in a piece of a motion, for joints and for norms, by kind.
struct PieceUse {
  std::array<std::array<double, 3>, 2> most{};
  /// The same at the rows of the problem only.
  std::array<std::array<double, 3>, 2> rows{};
  /// For both together, with an estimate for the peaks between places; and the one with the higher `most`.
  std::array<double, 3> above{};
  std::array<std::size_t, 3> row{};

  double highest(std::size_t kind) const {
    return most[0][kind] > most[1][kind] ? most[0][kind] : most[1][kind];
  }
  double all() const {
    double out = 0;
    for (std::size_t kind = 0; kind < 3; ++kind) out = highest(kind) > out ? highest(kind) : out;
    return out;
  }
};

/// For each kind: the highest value of any row, relative to its limit, and that row.
struct Ratios {
  double value[3] = {0, 0, 0};
  std::size_t row[3] = {0, 0, 0};
};

/// Computes the ratios at every place of `rows`, for the motion there (one per place).
void ratios(const PathRows& rows, std::span<const PathMotion> motion, std::vector<Ratios>& out);

}  // namespace polyarm::timing
