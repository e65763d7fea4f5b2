/// How long a plan from state to state takes, ours beside Ruckig's on the same cases in the same run.
///
/// otg_bench [PASSES] [FILTER]: one line for each family of cases and number of axes; FILTER is a part of a
/// family's name. Both plan blocks of 64 cases in turns. "mean" is processor time of whole blocks; p50 and
/// p99 are single calls on the clock, of which some 20 ns are the clock's own. "longer" counts our motions
/// that take more than 1e-9 (relative) longer than the peer's, and gives the worst. Without Ruckig only our
/// figures are printed. What it cannot show: whether limits are kept (otg_cases does).
///
/// Cases are drawn as Ruckig's own benchmark draws them: positions N(0, 4), velocities and accelerations
/// N(0, 0.8), limits of each axis U(0.1, 12) above those of its states. "arm" has the limits of a UR5e's
/// size, the same for all axes.
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/trajectory/state_to_state.hpp"
#ifdef POLYARM_RUCKIG
#include <ruckig/ruckig.hpp>
#endif

namespace {

using namespace polyarm::trajectory;

constexpr std::size_t kCases = 2048, kBlock = 64;

struct Family {
  const char* name;
  bool from_rest = false, to_rest = false;
  bool lopsided = false;  ///< lower limits differ from upper ones
  bool arm = false;       ///< the same limits of an arm for all axes
  double outside = 1;     ///< start states may be so many times above the limits
  Synchronization synchronization = Synchronization::time;
};

constexpr Family kFamilies[] = {
    {.name = "rest_to_rest", .from_rest = true, .to_rest = true},
    {.name = "rest_to_rest_arm", .from_rest = true, .to_rest = true, .arm = true},
    {.name = "rest_to_rest_lopsided", .from_rest = true, .to_rest = true, .lopsided = true},
    {.name = "rest_to_rest_phase",
     .from_rest = true,
     .to_rest = true,
     .synchronization = Synchronization::phase},
    {.name = "rest_to_rest_alone",
     .from_rest = true,
     .to_rest = true,
     .synchronization = Synchronization::none},
    {.name = "moving_start", .to_rest = true},
    {.name = "moving_target", .from_rest = true},
    {.name = "any_target"},
    {.name = "any_target_arm", .arm = true},
    {.name = "any_target_lopsided", .lopsided = true},
    {.name = "any_target_alone", .synchronization = Synchronization::none},
    {.name = "outside_to_rest", .to_rest = true, .outside = 2},
};

struct Case {
  std::vector<MotionState> from, to;
  std::vector<MotionLimits> limits;
};

class Draw {
 public:
  explicit Draw(const Family& family) : family_(family) {}

  Case one(std::size_t axes) {
    Case c;
    while (c.from.size() < axes) {
      MotionState from = state(family_.from_rest), to = state(family_.to_rest);
      MotionLimits l = limits(from, to);
      if (family_.outside > 1) {
        from.velocity = even(-family_.outside, family_.outside) * l.max_velocity;
        from.acceleration = even(-family_.outside, family_.outside) * l.max_acceleration;
      } else if (!viable(from, l, 1)) {
        continue;
      }
      if (!viable(to, l, -1)) continue;
      c.from.push_back(from), c.to.push_back(to), c.limits.push_back(l);
    }
    return c;
  }

 private:
  double even(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  MotionState state(bool rests) {
    std::normal_distribution<double> rate(0, 0.8);
    const double position = std::normal_distribution<double>(0, family_.arm ? 1.5 : 4)(engine_);
    const double velocity = rate(engine_), acceleration = rate(engine_);
    return rests ? MotionState{position, 0, 0} : MotionState{position, velocity, acceleration};
  }
  MotionLimits limits(const MotionState& from, const MotionState& to) {
    if (family_.arm) return MotionLimits::symmetric(3.14, 12, 120);
    const double v = std::abs(from.velocity) + std::abs(to.velocity);
    const double a = std::abs(from.acceleration) + std::abs(to.acceleration);
    MotionLimits l = MotionLimits::symmetric(even(0.1, 12) + v, even(0.1, 12) + a, even(0.1, 12));
    if (family_.lopsided) l.min_velocity = -v - even(0.1, 12), l.min_acceleration = -a - even(0.1, 12);
    return l;
  }
  static bool viable(const MotionState& s, const MotionLimits& l, double direction) {
    const double v = s.velocity + direction * s.acceleration * std::abs(s.acceleration) / (2 * l.max_jerk);
    return v < l.max_velocity && v > l.min_velocity && std::abs(s.velocity) < l.max_velocity &&
           std::abs(s.acceleration) < l.max_acceleration;
  }

  const Family& family_;
  std::mt19937_64 engine_{1};
};

double processor_ns() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) * 1e9 + double(t.tv_nsec);
}

/// Times of one of both.
struct Times {
  std::vector<double> calls;
  double total = 0;
  std::uint64_t count = 0;

  /// Every second time call by call, else the block as a whole.
  template <typename Call>
  void block(bool call_by_call, std::size_t begin, Call call) {
    using Clock = std::chrono::steady_clock;
    if (!call_by_call) {
      const double before = processor_ns();
      for (std::size_t i = 0; i < kBlock; ++i) call(begin + i);
      total += processor_ns() - before, count += kBlock;
      return;
    }
    for (std::size_t i = 0; i < kBlock; ++i) {
      const auto before = Clock::now();
      call(begin + i);
      calls.push_back(std::chrono::duration<double, std::nano>(Clock::now() - before).count());
    }
  }
  double mean() const { return total / double(count); }
  double at(double share) {
    if (calls.empty()) return 0;
    const auto place = calls.begin() + std::ptrdiff_t(share * double(calls.size() - 1));
    std::nth_element(calls.begin(), place, calls.end());
    return *place;
  }
};

struct Result {
  Times ours, peer;
  std::uint64_t longer = 0, compared = 0;
  double worst = 0;
};

void report(const char* name, std::size_t axes, Result& r) {
  fmt::print("{:<22} {:>3}  {:>7.0f} {:>7.0f} {:>7.0f}", name, axes, r.ours.mean(), r.ours.at(0.5),
             r.ours.at(0.99));
  if (r.peer.count > 0)
    fmt::print("  {:>7.0f} {:>7.0f} {:>7.0f}  {:>5.2f} {:>5.2f} {:>5.2f}  {}/{} {:.1e}", r.peer.mean(),
               r.peer.at(0.5), r.peer.at(0.99), r.ours.mean() / r.peer.mean(),
               r.ours.at(0.5) / r.peer.at(0.5), r.ours.at(0.99) / r.peer.at(0.99), r.longer, r.compared,
               r.worst);
  fmt::print("\n");
  std::fflush(stdout);
}

#ifdef POLYARM_RUCKIG
template <std::size_t Axes>
class Peer {
 public:
  Peer(const std::vector<Case>& cases, Synchronization synchronization) {
    for (const Case& c : cases) in_.push_back(input_of(c, synchronization));
  }
  double plan(std::size_t i) {
    return otg_.calculate(in_[i], trajectory_) >= ruckig::Result::Working ? trajectory_.get_duration() : -1;
  }
  static ruckig::InputParameter<Axes> input_of(const Case& c, Synchronization synchronization) {
    ruckig::InputParameter<Axes> in;
    std::array<double, Axes> low_velocity, low_acceleration;
    bool lopsided = false;
    for (std::size_t i = 0; i < Axes; ++i) {
      const MotionLimits& l = c.limits[i];
      in.current_position[i] = c.from[i].position, in.target_position[i] = c.to[i].position;
      in.current_velocity[i] = c.from[i].velocity, in.target_velocity[i] = c.to[i].velocity;
      in.current_acceleration[i] = c.from[i].acceleration, in.target_acceleration[i] = c.to[i].acceleration;
      in.max_velocity[i] = l.max_velocity, in.max_acceleration[i] = l.max_acceleration;
      in.max_jerk[i] = l.max_jerk, low_velocity[i] = l.min_velocity;
      low_acceleration[i] = l.min_acceleration;
      lopsided |= l.min_velocity != -l.max_velocity || l.min_acceleration != -l.max_acceleration;
    }
    if (lopsided) in.min_velocity = low_velocity, in.min_acceleration = low_acceleration;
    in.synchronization = synchronization == Synchronization::none    ? ruckig::Synchronization::None
                         : synchronization == Synchronization::phase ? ruckig::Synchronization::Phase
                                                                     : ruckig::Synchronization::Time;
    return in;
  }

 private:
  std::vector<ruckig::InputParameter<Axes>> in_;
  ruckig::Ruckig<Axes> otg_;
  ruckig::Trajectory<Axes> trajectory_;
};
#endif

template <std::size_t Axes>
void run(const Family& family, int passes) {
  Draw draw(family);
  std::vector<Case> cases;
  while (cases.size() < kCases) cases.push_back(draw.one(Axes));
  const MotionOptions options{.synchronization = family.synchronization};
  StateToState plan;
  Result r;
  const auto ours = [&](std::size_t i) {
    plan.plan(cases[i].from, cases[i].to, cases[i].limits, options);
    return plan.duration();
  };
#ifdef POLYARM_RUCKIG
  Peer<Axes> peer(cases, family.synchronization);
  for (std::size_t i = 0; i < kCases; ++i) {
    const double own = ours(i), theirs = peer.plan(i);
    if (theirs < 0) continue;
    ++r.compared, r.longer += own > theirs * (1 + 1e-9) + 1e-12;
    r.worst = std::max(r.worst, own / theirs - 1);
  }
#endif
  for (int pass = 0; pass < passes; ++pass)
    for (std::size_t begin = 0; begin < kCases; begin += kBlock) {
      r.ours.block(pass % 2 != 0, begin, ours);
#ifdef POLYARM_RUCKIG
      r.peer.block(pass % 2 != 0, begin, [&](std::size_t i) { return peer.plan(i); });
#endif
    }
  report(family.name, Axes, r);
}

/// One cycle of a controller whose target moves: a plan, and the state a millisecond later.
template <std::size_t Axes>
void run_moving(int passes) {
  Draw draw(kFamilies[0]);
  const Case c = draw.one(Axes);
  std::vector<MotionState> at = c.from, to = c.to;
  StateToState plan;
  Result r;
  double t = 0;
  const auto ours = [&](std::size_t) {
    t += 0.001;
    for (std::size_t i = 0; i < Axes; ++i) to[i].position = std::sin(t + double(i));
    plan.plan(at, to, c.limits);
    plan.sample(0.001, at);
  };
#ifdef POLYARM_RUCKIG
  ruckig::InputParameter<Axes> in = Peer<Axes>::input_of(c, Synchronization::time);
  ruckig::Ruckig<Axes> otg(0.001);
  ruckig::OutputParameter<Axes> out;
  double peer_t = 0;
  const auto peer = [&](std::size_t) {
    peer_t += 0.001;
    for (std::size_t i = 0; i < Axes; ++i) in.target_position[i] = std::sin(peer_t + double(i));
    otg.update(in, out);
    out.pass_to_input(in);
  };
#endif
  for (int pass = 0; pass < passes; ++pass)
    for (std::size_t begin = 0; begin < kCases; begin += kBlock) {
      r.ours.block(pass % 2 != 0, begin, ours);
#ifdef POLYARM_RUCKIG
      r.peer.block(pass % 2 != 0, begin, peer);
#endif
    }
  report("target_moves_in_cycle", Axes, r);
}

}  // namespace

int main(int argc, char** argv) {
  const int passes = argc > 1 ? std::atoi(argv[1]) : 20;
  const std::string_view filter = argc > 2 ? argv[2] : "";
#ifdef POLYARM_RUCKIG
  fmt::print("{:<22} {:>3}  {:>23}  {:>23}  {:>17}  longer/compared, worst\n", "ns", "", "ours",
             "Ruckig " POLYARM_RUCKIG, "ratio");
#else
  fmt::print("Ruckig is not installed: our figures only\n");
#endif
  fmt::print("{:<22} {:>3}  {:>7} {:>7} {:>7}  {:>7} {:>7} {:>7}  {:>5} {:>5} {:>5}\n", "family", "axes",
             "mean", "p50", "p99", "mean", "p50", "p99", "mean", "p50", "p99");
  for (const Family& family : kFamilies) {
    if (std::string_view(family.name).find(filter) == std::string_view::npos) continue;
    run<1>(family, passes), run<2>(family, passes), run<3>(family, passes), run<6>(family, passes);
    run<7>(family, passes), run<14>(family, passes);
  }
  if (std::string_view("target_moves_in_cycle").find(filter) == std::string_view::npos) return 0;
  run_moving<1>(passes), run_moving<6>(passes), run_moving<7>(passes);
}
