/// State to state: six and seven axes, arbitrary targets and targets at rest, and a target that moves in
/// every cycle. Ruckig beside it where it is installed, else the reference's figures stand in the head of the
/// output, marked as not measured here.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <random>
#include <vector>

#include "polyarm/trajectory/state_to_state.hpp"
#ifdef POLYARM_RUCKIG
#include <ruckig/ruckig.hpp>
#endif

namespace {

using namespace polyarm::trajectory;

constexpr std::size_t kCases = 2048;

struct Case {
  std::vector<MotionState> from, to;
  std::vector<MotionLimits> limits;
};

/// Positions N(0, 4), velocities and accelerations N(0, 0.8), limits U(0.1, 12) beyond those of the states.
template <std::size_t Axes>
std::vector<Case> cases(bool at_rest) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> position(0, 4), rate(0, 0.8);
  std::uniform_real_distribution<double> limit(0.1, 12);
  const auto viable = [](const MotionState& s, const MotionLimits& l, double direction) {
    return std::abs(s.velocity + direction * s.acceleration * std::abs(s.acceleration) / (2 * l.max_jerk)) <
           l.max_velocity;
  };
  std::vector<Case> out;
  while (out.size() < kCases) {
    Case c;
    while (c.from.size() < Axes) {
      const MotionState from{position(engine), rate(engine), rate(engine)};
      const MotionState to{position(engine), at_rest ? 0 : rate(engine), at_rest ? 0 : rate(engine)};
      const MotionLimits l = MotionLimits::symmetric(
          limit(engine) + std::abs(from.velocity) + std::abs(to.velocity),
          limit(engine) + std::abs(from.acceleration) + std::abs(to.acceleration), limit(engine));
      if (!viable(from, l, 1) || !viable(to, l, -1)) continue;
      c.from.push_back(from);
      c.to.push_back(to);
      c.limits.push_back(l);
    }
    out.push_back(std::move(c));
  }
  return out;
}

/// p50, p99 and the longest of single calls on the clock, ns; some 20 ns of each are the clock's own.
template <typename Call>
void tell_quantiles(benchmark::State& state, Call call) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times;
  for (std::size_t i = 0; i < 4 * kCases; ++i) {
    const auto begin = Clock::now();
    call(i);
    times.push_back(std::chrono::duration<double, std::nano>(Clock::now() - begin).count());
  }
  std::sort(times.begin(), times.end());
  state.counters["p50_ns"] = times[times.size() / 2];
  state.counters["p99_ns"] = times[times.size() * 99 / 100];
  state.counters["max_ns"] = times.back();
}

template <std::size_t Axes, bool AtRest>
void ours(benchmark::State& state) {
  const std::vector<Case> all = cases<Axes>(AtRest);
  StateToState plan;
  std::size_t i = 0;
  for (auto _ : state) {
    const Case& c = all[i++ % kCases];
    benchmark::DoNotOptimize(plan.plan(c.from, c.to, c.limits));
  }
  tell_quantiles(state, [&](std::size_t k) {
    const Case& c = all[k % kCases];
    benchmark::DoNotOptimize(plan.plan(c.from, c.to, c.limits));
  });
}

/// One cycle of a controller whose target moves.
void ours_moving(benchmark::State& state) {
  const Case c = cases<6>(true)[0];
  std::vector<MotionState> at = c.from, to = c.to;
  StateToState plan;
  double t = 0;
  const auto cycle = [&](std::size_t) {
    t += 0.001;
    for (std::size_t i = 0; i < 6; ++i) to[i].position = std::sin(t + static_cast<double>(i));
    plan.plan(at, to, c.limits);
    plan.sample(0.001, at);
  };
  for (auto _ : state) cycle(0);
  tell_quantiles(state, cycle);
}

BENCHMARK(ours<6, false>)->Name("ours/six_axes_any_target");
BENCHMARK(ours<6, true>)->Name("ours/six_axes_to_rest");
BENCHMARK(ours<7, false>)->Name("ours/seven_axes_any_target");
BENCHMARK(ours_moving)->Name("ours/six_axes_moving_target");

#ifndef POLYARM_RUCKIG
const int kNotMeasured = [] {
  benchmark::AddCustomContext("Ruckig, six / seven axes, any target",
                              "5.7-6.3 / 6.8-7.5 us (reference, not measured here)");
  benchmark::AddCustomContext("Ruckig, six axes, moving target", "4.7-5.6 us (reference, not measured here)");
  return 0;
}();
#endif

#ifdef POLYARM_RUCKIG
template <std::size_t Axes>
ruckig::InputParameter<Axes> input_of(const Case& c) {
  ruckig::InputParameter<Axes> in;
  for (std::size_t i = 0; i < Axes; ++i) {
    in.current_position[i] = c.from[i].position;
    in.current_velocity[i] = c.from[i].velocity;
    in.current_acceleration[i] = c.from[i].acceleration;
    in.target_position[i] = c.to[i].position;
    in.target_velocity[i] = c.to[i].velocity;
    in.target_acceleration[i] = c.to[i].acceleration;
    in.max_velocity[i] = c.limits[i].max_velocity;
    in.max_acceleration[i] = c.limits[i].max_acceleration;
    in.max_jerk[i] = c.limits[i].max_jerk;
  }
  return in;
}

template <std::size_t Axes, bool AtRest>
void peer(benchmark::State& state) {
  std::vector<ruckig::InputParameter<Axes>> all;
  for (const Case& c : cases<Axes>(AtRest)) all.push_back(input_of<Axes>(c));
  ruckig::Ruckig<Axes> otg;
  ruckig::Trajectory<Axes> trajectory;
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(otg.calculate(all[i++ % kCases], trajectory));
  tell_quantiles(
      state, [&](std::size_t k) { benchmark::DoNotOptimize(otg.calculate(all[k % kCases], trajectory)); });
}

void peer_moving(benchmark::State& state) {
  ruckig::InputParameter<6> in = input_of<6>(cases<6>(true)[0]);
  ruckig::Ruckig<6> otg(0.001);
  ruckig::OutputParameter<6> out;
  double t = 0;
  for (auto _ : state) {
    t += 0.001;
    for (std::size_t i = 0; i < 6; ++i) in.target_position[i] = std::sin(t + static_cast<double>(i));
    benchmark::DoNotOptimize(otg.update(in, out));
    out.pass_to_input(in);
  }
}

BENCHMARK(peer<6, false>)->Name("peer/six_axes_any_target");
BENCHMARK(peer<6, true>)->Name("peer/six_axes_to_rest");
BENCHMARK(peer<7, false>)->Name("peer/seven_axes_any_target");
BENCHMARK(peer_moving)->Name("peer/six_axes_moving_target");
#endif

}  // namespace
