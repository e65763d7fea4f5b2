/// How many of many random cases from state to state fail: a plan that is refused, ends more than 1e-9
/// (relative) beside its target, exceeds a limit by more than 1e-9 anywhere, or whose axes do not arrive
/// together. Families of tests/support/state_cases.hpp, one to seven axes, half of the targets at rest, a
/// third of the limits other downwards than upwards; "mixed" takes each axis from another family.
///
/// otg_cases [CASES] [SEED]: of each family (100000). Exit code 1 if any failed.
/// otg_cases beside [CASES] [SEED]: durations beside Ruckig's, where it is installed, three axes each, from
/// starts inside the limits and from starts outside of them; only cases that Ruckig solves and that end where
/// they should. Exit code 1 if one of ours is longer.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/state_cases.hpp"
#ifdef POLYARM_RUCKIG
#include <ruckig/ruckig.hpp>
#endif

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

#ifdef POLYARM_RUCKIG
/// Cases of one family beside Ruckig.
class Beside {
 public:
  /// `outside`: starts with up to twice the limits of velocity and acceleration.
  Beside(std::size_t kind, bool outside, std::uint64_t seed) : kind_(kind), outside_(outside), draw_(seed) {}

  void ask(std::uint64_t k) {
    for (std::size_t i = 0; i < kAxes; ++i) axis(k, i);
    const bool ours = plan_.plan(from_, to_, limits_) == MotionStatus::ok;
    const double theirs = ask_peer();
    own_failures += !ours, peer_failures += theirs < 0;
    if (!ours || theirs < 0) return;
    ++compared;
    // What the peer ends beside its targets it may have saved.
    const double off = plan_.duration() - theirs, same = 1e-9 * std::max(1.0, theirs) + peer_saves_;
    longest = std::max(longest, off / theirs);
    if (off > same) {
      if (++longer <= 3)
        for (std::size_t i = 0; i < kAxes; ++i)
          fmt::print("case {}: {:.12g} s beside {:.12g}: {}\n", k, plan_.duration(), theirs,
                     shown(from_[i], to_[i], limits_[i]));
    } else if (-off > same) {
      ++shorter, most_shorter = std::max(most_shorter, -off / theirs);
    }
  }
  std::uint64_t compared = 0, longer = 0, shorter = 0, own_failures = 0, peer_failures = 0;
  double longest = -1, most_shorter = 0;

 private:
  static constexpr std::size_t kAxes = 3;
  void axis(std::uint64_t k, std::size_t i) {
    const Kind& kind = kKinds[kind_];
    limits_[i] = limits_of(kind, draw_, k % 5 == 0);
    const double way = draw_.logarithmic(kind.distance[0], kind.distance[1]);
    from_[i] = draw_.state(limits_[i], draw_.even(-3, 3));
    if (outside_) {
      from_[i].velocity = draw_.even(2 * limits_[i].min_velocity, 2 * limits_[i].max_velocity);
      from_[i].acceleration = draw_.even(2 * limits_[i].min_acceleration, 2 * limits_[i].max_acceleration);
    }
    const double there = from_[i].position + (draw_.coin() ? way : -way);
    to_[i] = k % 2 ? draw_.state(limits_[i], there) : MotionState{there, 0, 0};
  }
  /// The duration; -1 where it fails or does not come within 1e-6 of the way.
  double ask_peer() {
    for (std::size_t i = 0; i < kAxes; ++i) {
      in_.current_position[i] = from_[i].position, in_.target_position[i] = to_[i].position;
      in_.current_velocity[i] = from_[i].velocity, in_.target_velocity[i] = to_[i].velocity;
      in_.current_acceleration[i] = from_[i].acceleration;
      in_.target_acceleration[i] = to_[i].acceleration;
      in_.max_velocity[i] = limits_[i].max_velocity, in_.max_acceleration[i] = limits_[i].max_acceleration;
      in_.max_jerk[i] = limits_[i].max_jerk;
      low_velocity_[i] = limits_[i].min_velocity, low_acceleration_[i] = limits_[i].min_acceleration;
    }
    in_.min_velocity = low_velocity_, in_.min_acceleration = low_acceleration_;
    if (peer_.calculate(in_, trajectory_) != ruckig::Result::Working) return -1;
    std::array<double, kAxes> q, v, a;
    trajectory_.at_time(trajectory_.get_duration(), q, v, a);
    peer_saves_ = 0;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const double way = std::abs(to_[i].position - from_[i].position) + 1e-9;
      const double beside = std::abs(q[i] - to_[i].position);
      if (!(beside <= 1e-6 * (1 + way))) return -1;
      peer_saves_ =
          std::max(peer_saves_, beside / std::min(limits_[i].max_velocity, -limits_[i].min_velocity));
    }
    return trajectory_.get_duration();
  }

  std::size_t kind_;
  bool outside_;
  Draw draw_;
  StateToState plan_;
  std::array<MotionState, kAxes> from_, to_;
  std::array<MotionLimits, kAxes> limits_;
  ruckig::Ruckig<kAxes> peer_;
  ruckig::InputParameter<kAxes> in_;
  ruckig::Trajectory<kAxes> trajectory_;
  std::array<double, kAxes> low_velocity_, low_acceleration_;
  double peer_saves_ = 0;  // s
};

int beside(std::uint64_t cases, std::uint64_t seed) {
  std::uint64_t longer = 0;
  for (const bool outside : {false, true})
    for (std::size_t kind = 0; kind < std::size(kKinds); ++kind) {
      Beside family(kind, outside, seed * 1000 + kind);
      for (std::uint64_t k = 0; k < cases; ++k) family.ask(k);
      fmt::print(
          "{:<12} {}{} compared, {} longer (by {:.1e} at most), {} shorter (by {:.0f} % at most); failed: "
          "{}, Ruckig {}\n",
          kKinds[kind].name, outside ? "from outside: " : "", family.compared, family.longer, family.longest,
          family.shorter, 100 * family.most_shorter, family.own_failures, family.peer_failures);
      longer += family.longer + family.own_failures;
    }
  return longer > 0;
}
#else
int beside(std::uint64_t, std::uint64_t) {
  fmt::print("Ruckig is not installed\n");
  return 1;
}
#endif

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "beside")
    return beside(argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 100'000,
                  argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
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
