// What the geometry of motion costs: joint paths through waypoints, Cartesian paths with corners, and the
// joints along them. It cannot prove that a path is right: tests/trajectory and tests/motion do.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/timing/timing.hpp"

namespace polyarm {
namespace {

using kinematics::Chain;
using paths::CartesianPathBuilder;

Chain arm(const std::string& name, const std::string& tip) {
  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (model.links[i].name == tip) return Chain(model, static_cast<int>(i));
  return Chain(model, static_cast<int>(model.links.size()) - 1);
}

std::vector<paths::JointWaypoint> waypoints(std::size_t count) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> even(-2, 2);
  std::vector<paths::JointWaypoint> out(count);
  for (auto& w : out) {
    w.radius = 0.2;
    for (int j = 0; j < 6; ++j) w.q.push_back(even(engine));
  }
  return out;
}

void joint_lines(benchmark::State& state) {
  const auto points = waypoints(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(paths::joint_lines(points));
}
BENCHMARK(joint_lines)->Arg(10)->Arg(50)->Unit(benchmark::kMicrosecond);

void joint_spline(benchmark::State& state) {
  const auto points = waypoints(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(paths::joint_spline(points));
}
BENCHMARK(joint_spline)->Arg(10)->Arg(50)->Unit(benchmark::kMicrosecond);

const std::vector<double> kBent{0, -1.4, 1.8, -2.0, -1.57, 0.3};

/// Lines and arcs of about 10 cm, corners of 2 cm, the orientation changing all the way.
paths::CartesianSections twenty_segments(const Pose& start) {
  using paths::ArcOrientation;
  CartesianPathBuilder builder(start);
  Pose at = start;
  for (int i = 0; i < 20; ++i) {
    const double side = i % 4 < 2 ? 0.1 : -0.1;
    Pose to = at;
    to.position = to.position + (i % 2 ? Vec3{0, side, 0.02} : Vec3{side, 0, -0.02});
    to.rotation = start.rotation * from_axis_angle({0.6, 0.8, 0}, 0.2 * std::sin(i));
    if (i % 3 == 2)
      builder.arc(0.5 * (at.position + to.position) + Vec3{0, 0, 0.03}, to, ArcOrientation::interpolated,
                  {0.02, ""});
    else
      builder.line(to, {0.02, ""});
    at = to;
  }
  return builder.build();
}

void cartesian_20_segments(benchmark::State& state) {
  const Chain ur = arm("universal_robots/ur5e", "tool0");
  const Pose start = ur.forward(kBent);
  for (auto _ : state) benchmark::DoNotOptimize(twenty_segments(start));
}
BENCHMARK(cartesian_20_segments)->Unit(benchmark::kMicrosecond);

/// Geometry and joints: what a program of 20 moves costs before it is timed.
void joints_along_20_segments(benchmark::State& state) {
  const Chain ur = arm("universal_robots/ur5e", "tool0");
  const Pose start = ur.forward(kBent);
  std::size_t pieces = 0;
  for (auto _ : state) {
    const auto path = twenty_segments(start);
    pieces = moves::joints_along(ur, path.sections[0], kBent)->pieces();
  }
  state.counters["pieces"] = static_cast<double>(pieces);
}
BENCHMARK(joints_along_20_segments)->Unit(benchmark::kMicrosecond);

/// Geometry, joints and time.
void twenty_lines_and_arcs_timed(benchmark::State& state) {
  const Chain ur = arm("universal_robots/ur5e", "tool0");
  const Pose start = ur.forward(kBent);
  const std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(3.14, 12.6, 126));
  double duration = 0;
  for (auto _ : state) {
    const auto path = twenty_segments(start);
    duration = timing::timed(moves::joints_along(ur, path.sections[0], kBent), limits).duration();
  }
  state.counters["motion_s"] = duration;
}
BENCHMARK(twenty_lines_and_arcs_timed)->Unit(benchmark::kMillisecond);

void joints_along_line_seven_axes(benchmark::State& state) {
  const Chain seven = arm("kuka/lbr_iiwa_7_r800", "tool0");
  const std::vector<double> q{0.2, 0.5, -0.1, -1.4, 0.2, 0.9, 0};
  const Pose start = seven.forward(q);
  Pose end = start;
  end.position = end.position + Vec3{0.1, -0.3, 0.1};
  const auto path = CartesianPathBuilder(start).line(end).build();
  for (auto _ : state) benchmark::DoNotOptimize(moves::joints_along(seven, path.sections[0], q));
}
BENCHMARK(joints_along_line_seven_axes)->Unit(benchmark::kMicrosecond);

void joint_path_at(benchmark::State& state) {
  const Chain ur = arm("universal_robots/ur5e", "tool0");
  const auto path = twenty_segments(ur.forward(kBent));
  const auto joints = moves::joints_along(ur, path.sections[0], kBent);
  double q[6], d1[6], d2[6], d3[6], s = 0;
  for (auto _ : state) {
    s = s + 0.01 < joints->length() ? s + 0.01 : 0;
    joints->at(s, {q, d1, d2, d3});
    benchmark::DoNotOptimize(d3);
  }
}
BENCHMARK(joint_path_at);

}  // namespace
}  // namespace polyarm
