#pragma once
/// Checks every move of a simulated run for contacts, whatever the hardware: swept, with proven edges.
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/surroundings/sweep.hpp"

namespace polyarm::cell {

struct CellInside;
struct ContactBodies;

/// Looks at the commanded joints of a cell in lock-step after each tick. Cell thread.
class SweptCheck {
 public:
  /// Throws Error for a robot whose bodies are too many or not finite. `clearance`, m: approaches nearer than
  /// this are found; the default is that of the cell file.
  explicit SweptCheck(const CellInside& cell, std::optional<double> clearance = {});
  ~SweptCheck();

  void look(Nanoseconds now);
  /// At the end: one error for each contact of a pair in a line, "contact" {a, b, depth_m, at_s}, and one
  /// warning for each pair in a line that came nearer than the clearance, "clearance" {a, b, distance_m,
  /// at_s}.
  std::vector<Problem> finish();
  /// The nearest that anything came while it was below the clearance.
  const std::optional<surroundings::Approach>& nearest() const { return nearest_; }

 private:
  std::uint64_t mark_of(std::size_t robot);

  const CellInside& cell_;
  double clearance_;
  std::shared_ptr<const ContactBodies> bodies_;
  std::unique_ptr<surroundings::Sweep> sweep_;
  bool is_meant(const surroundings::Approach& approach) const;
  std::vector<Location> marks_;
  std::set<std::pair<std::size_t, std::uint64_t>> meant_;  ///< robot and mark of moves that are meant to touch
  std::optional<surroundings::Approach> nearest_;
};

/// What the robots of a cell that has not begun are inside of, at their start and at home: one error each.
std::vector<Problem> contacts_at_rest(const CellInside& cell);

}  // namespace polyarm::cell
