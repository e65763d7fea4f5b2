/// How long a timing pass takes: 10 and 50 waypoints, 6 axes, jerk-limited; and a change of override in the
/// control cycle. No peer that plans with limited jerk on a given path is open and local, so none is
/// measured: TOTG, without jerk, has 2.1 / 36 ms in the reference (not measured here), and TOPP-RA, without
/// jerk and with limits kept at its grid only, 0.16 / 0.75 ms (not measured here). Counters: s of motion,
/// nodes, the solver's iterations, and by how much any limit is exceeded.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "polyarm/trajectory/path_override.hpp"
#include "polyarm/trajectory/timing.hpp"
#include "tests/support/test_paths.hpp"

namespace {

using namespace polyarm::trajectory;

constexpr std::size_t kCases = 20;

void splines(benchmark::State& state) {
  std::vector<std::shared_ptr<const Path>> paths;
  for (std::size_t i = 0; i < kCases; ++i)
    paths.push_back(polyarm::test::random_spline(6, std::size_t(state.range(0)), i + 1));
  const std::vector<MotionLimits> limits(6, MotionLimits::symmetric(2, 5, 50));
  std::size_t i = 0;
  double duration = 0, nodes = 0, iterations = 0, excess = 0;
  for (auto _ : state) {
    const Timing timing = time_path(*paths[i++ % kCases], limits);
    duration += timing.profile.duration(), nodes += double(timing.grid.size());
    iterations += timing.iterations, excess = std::max(excess, timing.excess);
  }
  const auto mean = benchmark::Counter::kAvgIterations;
  state.counters["motion_s"] = {duration, mean};
  state.counters["nodes"] = {nodes, mean};
  state.counters["iterations"] = {iterations, mean};
  state.counters["excess"] = excess;
}
BENCHMARK(splines)->Arg(10)->Arg(50)->Unit(benchmark::kMillisecond);

/// The cycle in which a stop is asked for: the dearest.
void stop_request(benchmark::State& state) {
  const std::vector<MotionLimits> limits(6, MotionLimits::symmetric(2, 8, 100));
  const TimedPath path = timed(polyarm::test::random_spline(6, 8, 1), limits);
  PathOverride override(path, limits, 1e-3);
  double part = 0;
  for (auto _ : state) {
    part += 0.0617;
    if (part > 0.9) part = 0.05;
    override.begin(part * path.duration(), 1);
    override.advance(0);
  }
}
BENCHMARK(stop_request)->Unit(benchmark::kMicrosecond);

void steady_cycle(benchmark::State& state) {
  const std::vector<MotionLimits> limits(6, MotionLimits::symmetric(2, 8, 100));
  const TimedPath path = timed(polyarm::test::random_spline(6, 8, 1), limits);
  PathOverride override(path, limits, 1e-3);
  std::vector<double> q(6), v(6), a(6);
  override.begin(0, 1);
  for (auto _ : state) {
    override.advance(1);
    if (override.finished()) override.begin(0, 1);
    override.sample(q, v, a);
    benchmark::DoNotOptimize(q.data());
  }
}
BENCHMARK(steady_cycle)->Unit(benchmark::kMicrosecond);

}  // namespace
