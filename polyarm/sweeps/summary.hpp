#pragma once
/// Sums up the rows of a sweep one by one, so that its memory depends on the values of the axes and not on
/// the number of variants: the best, what each value of each axis led to, a map over base places, the Pareto
/// set of robots.
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/sweeps/row.hpp"

namespace polyarm::sweeps {

/// True if `a` is the better candidate: both completed, a shorter cycle; for equal cycles the larger
/// clearance.
bool is_better(const Row& a, const Row& b);
/// The clearance for comparisons: nothing near counts as infinitely far.
double clearance_of(const Row& row);

/// What variants with one value of an axis led to.
struct Share {
  std::uint64_t ran = 0, completed = 0;
  double cycle_sum = 0, cycle_best = 0,
         clearance_least = 0;                  ///< of the completed; clearance: infinity if nothing
  std::map<std::string, std::uint64_t> codes;  ///< of those that did not complete
  void add(const Row& row);
  double cycle_mean() const { return completed ? cycle_sum / static_cast<double>(completed) : 0; }
  /// The most frequent code; empty if all completed.
  std::string main_code() const;
};

class Summary {
 public:
  explicit Summary(std::size_t best = 10) : most_(best) {}
  void add(const Row& row);

  std::uint64_t rows() const { return total_.ran; }
  const Share& total() const { return total_; }
  /// Best first.
  const std::vector<Row>& best() const { return best_; }
  /// Axis → value as text → share. Axes: robot, base, program, speed, fault, seed, values.
  const std::map<std::string, std::map<std::string, Share>>& axes() const { return axes_; }
  /// One row for each code, as an example.
  const std::map<std::string, Row>& examples() const { return examples_; }
  /// Best of each robot; among them no robot is both slower and nearer to something than another.
  std::vector<Row> pareto() const;
  const std::map<std::string, Row>& best_of_robot() const { return best_of_robot_; }
  /// Robot → (x, y) of the base → the best row there, or a failed one if none completed.
  using Map = std::map<std::pair<double, double>, Row>;
  const std::map<std::string, Map>& maps() const { return maps_; }
  double wall_s() const { return wall_s_; }
  std::uint64_t crashed() const { return crashed_; }

 private:
  std::size_t most_;
  Share total_;
  std::vector<Row> best_;
  std::map<std::string, std::map<std::string, Share>> axes_;
  std::map<std::string, Row> examples_, best_of_robot_;
  std::map<std::string, std::vector<Row>> fronts_;
  std::map<std::string, Map> maps_;
  double wall_s_ = 0;
  std::uint64_t crashed_ = 0;
};

/// The base place of a row, as text.
std::string place_of(const Row& row);
/// The values of a row by axis, as text, in the order of the axes.
std::vector<std::pair<std::string, std::string>> axis_values(const Row& row);
/// What makes `row` worse than `best`, in one phrase: "12 % slower; robot abb/irb_120".
std::string why_worse(const Row& row, const Row& best);
/// A title for a row: robot, place, program, speed, as far as they are given.
std::string title_of(const Row& row);

}  // namespace polyarm::sweeps
