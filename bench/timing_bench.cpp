/// How long a timing pass takes: 10, 50 and 200 waypoints, 6 axes, jerk-limited; and a change of override in
/// the control cycle. No peer that plans with limited jerk on a given path is open and local. TOPP-RA,
/// without jerk and with limits kept at its grid only, is measured on the same paths and limits where it is
/// installed; what is not installed stands in the head of the output with the figure of the reference, marked
/// as not measured here. Counters: s of motion, nodes, the solver's iterations, and by how much any limit is
/// exceeded. That durations are short is the question of shortest_bench.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "polyarm/timing/path_override.hpp"
#include "polyarm/timing/timing.hpp"
#include "tests/support/test_paths.hpp"
#ifdef POLYARM_TOPPRA
#include <toppra/algorithm/toppra.hpp>
#include <toppra/constraint/linear_joint_acceleration.hpp>
#include <toppra/constraint/linear_joint_velocity.hpp>
#include <toppra/geometric_path.hpp>
#include <toppra/solver/seidel.hpp>
#endif

namespace {

using namespace polyarm::paths;
using namespace polyarm::timing;
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
BENCHMARK(splines)->Arg(10)->Arg(50)->Arg(200)->Unit(benchmark::kMillisecond);

#ifdef POLYARM_TOPPRA
/// A path of ours for the peer.
class PeerPath final : public toppra::GeometricPath {
 public:
  explicit PeerPath(std::shared_ptr<const Path> path)
      : toppra::GeometricPath(static_cast<int>(path->joints())), path_(std::move(path)) {}
  toppra::Vector eval_single(toppra::value_type s, int order) const override {
    std::vector<double> q(path_->joints()), first(q), second(q);
    path_->at(s, {q, first, second, {}});
    const std::vector<double>& wanted = order == 0 ? q : order == 1 ? first : second;
    return Eigen::Map<const toppra::Vector>(wanted.data(), static_cast<Eigen::Index>(wanted.size()));
  }
  toppra::Bound pathInterval() const override { return {0, path_->length()}; }

 private:
  std::shared_ptr<const Path> path_;
};

/// With as many grid points as the second argument says.
void peer_without_jerk(benchmark::State& state) {
  std::vector<toppra::GeometricPathPtr> paths;
  for (std::size_t i = 0; i < kCases; ++i)
    paths.push_back(
        std::make_shared<PeerPath>(polyarm::test::random_spline(6, std::size_t(state.range(0)), i + 1)));
  const toppra::Vector v = toppra::Vector::Constant(6, 2), a = toppra::Vector::Constant(6, 5);
  const toppra::LinearConstraintPtrs limits{
      std::make_shared<toppra::constraint::LinearJointVelocity>(-v, v),
      std::make_shared<toppra::constraint::LinearJointAcceleration>(-a, a)};
  std::size_t i = 0;
  double duration = 0, failed = 0;
  for (auto _ : state) {
    toppra::algorithm::TOPPRA peer(limits, paths[i++ % kCases]);
    peer.solver(std::make_shared<toppra::solver::Seidel>());
    peer.setN(static_cast<int>(state.range(1)));
    failed += peer.computePathParametrization() != toppra::ReturnCode::OK;
    const toppra::ParametrizationData& data = peer.getParameterizationData();
    for (Eigen::Index k = 1; k < data.gridpoints.size(); ++k)
      duration += 2 * (data.gridpoints[k] - data.gridpoints[k - 1]) /
                  (std::sqrt(data.parametrization[k]) + std::sqrt(data.parametrization[k - 1]));
  }
  state.counters["motion_s"] = {duration, benchmark::Counter::kAvgIterations};
  state.counters["failed"] = failed;
}
BENCHMARK(peer_without_jerk)->Args({10, 500})->Args({50, 500})->Unit(benchmark::kMicrosecond);
#endif

/// Figures of the reference for what is not here.
const int kNotMeasured = [] {
#ifndef POLYARM_TOPPRA
  benchmark::AddCustomContext("TOPP-RA, 500 grid points, no jerk, 10 / 50 waypoints",
                              "0.60 / 0.75 ms (reference, not measured here)");
#endif
  benchmark::AddCustomContext("TOTG, no jerk, 10 / 50 waypoints",
                              "2.1 / 36 ms (reference, not measured here)");
  return 0;
}();

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
