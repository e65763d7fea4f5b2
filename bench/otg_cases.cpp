/// How many of many random cases from state to state fail: a plan that is refused, ends more than 1e-9
/// (relative) beside its target, exceeds a limit by more than 1e-9 anywhere, or whose axes do not arrive
/// together. Families of tests/support/state_cases.hpp, one to seven axes, half of the targets at rest, a
/// third of the limits other downwards than upwards; "mixed" takes each axis from another family.
///
/// otg_cases [CASES] [SEED]: of each family (100000). Exit code 1 if any failed.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <vector>

#include "tests/support/state_cases.hpp"

namespace {

using namespace polyarm::trajectory;
using namespace polyarm::test::states;

class Family {
 public:
  /// `kind`: beyond the families, each axis another.
  Family(std::size_t kind, std::uint64_t seed) : kind_(kind), draw_(seed) {}

  bool works(std::uint64_t k) {
    from_.clear(), to_.clear(), limits_.clear();
    for (std::uint64_t i = 0; i <= k % 7; ++i) axis(k, i);
    if (plan_.plan(from_, to_, limits_) != MotionStatus::ok) return tell(k, "refused", 0);
    for (std::size_t i = 0; i < from_.size(); ++i) {
      const AxisMotion& m = plan_.axis(i);
      const double beside = miss(m, from_[i], to_[i], limits_[i]), beyond = excess(m, limits_[i]);
      worst_miss = std::max(worst_miss, beside), worst_excess = std::max(worst_excess, beyond);
      if (!(beside <= 1e-9)) return tell(k, "misses", i);
      if (!(beyond <= 1e-9)) return tell(k, "exceeds", i);
      if (m.duration() != plan_.duration()) return tell(k, "is not together", i);
    }
    return true;
  }
  double worst_miss = 0, worst_excess = 0;

 private:
  void axis(std::uint64_t k, std::uint64_t i) {
    const Kind& kind = kKinds[kind_ < std::size(kKinds) ? kind_ : (k + i) % std::size(kKinds)];
    limits_.push_back(limits_of(kind, draw_, k % 3 == 0));
    const double way = draw_.logarithmic(kind.distance[0], kind.distance[1]);
    from_.push_back(draw_.state(limits_.back(), draw_.even(-3, 3)));
    const double there = from_.back().position + (draw_.coin() ? way : -way);
    to_.push_back(k % 2 ? draw_.state(limits_.back(), there) : MotionState{there, 0, 0});
    if (k % 5 == 0) from_.back().velocity = from_.back().acceleration = 0;
  }
  bool tell(std::uint64_t k, const char* what, std::size_t i) const {
    fmt::print("case {} {}, axis {}: {}\n", k, what, i, shown(from_[i], to_[i], limits_[i]));
    return false;
  }

  std::size_t kind_;
  Draw draw_;
  StateToState plan_;
  std::vector<MotionState> from_, to_;
  std::vector<MotionLimits> limits_;
};

}  // namespace

int main(int argc, char** argv) {
  const std::uint64_t cases = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 100'000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  std::uint64_t failed = 0;
  for (std::size_t kind = 0; kind <= std::size(kKinds); ++kind) {
    Family family(kind, seed * 1000 + kind);
    std::uint64_t own = 0;
    for (std::uint64_t k = 0; k < cases; ++k) own += !family.works(k);
    fmt::print("{:<12} {} cases, {} failed, worst end error {:.1e}, worst excess {:.1e}\n",
               kind < std::size(kKinds) ? kKinds[kind].name : "mixed", cases, own, family.worst_miss,
               family.worst_excess);
    failed += own;
  }
  return failed > 0;
}
