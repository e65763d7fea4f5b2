/// How far from the shortest the durations are that are planned: each against a slow optimiser of its own
/// (tests/support/slow_timing.hpp, slow_state_to_state.hpp), over random cases with fixed seeds. A ratio
/// above one is time that was not found. What it cannot prove: that the slow ones find the optimum; on a
/// line, whose optimum is known, that of paths ends half a per cent above it, with as many intervals as here.
///
/// shortest_bench [CASES] [SEED]: of each kind (20); UR5e paths and 50 waypoints are a quarter of that.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/paths/cartesian_path.hpp"
#include "polyarm/timing/timing.hpp"
#include "tests/support/slow_state_to_state.hpp"
#include "tests/support/slow_timing.hpp"
#include "tests/support/test_paths.hpp"

namespace {

using namespace polyarm;
using namespace polyarm::paths;
using namespace polyarm::timing;
using namespace polyarm::trajectory;
using Engine = std::mt19937_64;

double even(Engine& engine, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(engine);
}

/// Velocities of 1.5 to 4.5 rad/s, reached within 1/8 to 1/2 s, accelerations within 1/30 to 1/5 s.
std::vector<MotionLimits> arm_limits(Engine& engine, std::size_t joints) {
  std::vector<MotionLimits> out;
  for (std::size_t j = 0; j < joints; ++j) {
    const double v = even(engine, 1.5, 4.5), a = v * even(engine, 2, 8);
    out.push_back(MotionLimits::symmetric(v, a, a * even(engine, 5, 30)));
  }
  return out;
}

void report(const std::string& what, std::vector<double> ratios, double ours, double slow) {
  std::sort(ratios.begin(), ratios.end());
  double sum = 0;
  for (const double r : ratios) sum += r;
  const auto at = [&](double share) { return ratios[std::size_t(share * double(ratios.size() - 1))]; };
  fmt::print("{:<34} {:>6} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>11.4f} {:>11.2f}\n", what,
             ratios.size(), sum / double(ratios.size()), at(0), at(0.5), at(0.9), ratios.back(),
             1e3 * ours / double(ratios.size()), 1e3 * slow / double(ratios.size()));
  std::fflush(stdout);
}

double cpu() {
  return double(std::clock()) / CLOCKS_PER_SEC;
}

struct PathCase {
  std::shared_ptr<const Path> path;
  std::vector<MotionLimits> limits;
};

void path_family(const std::string& what, int cases, std::size_t intervals,
           const std::function<PathCase(int)>& make) {
  std::vector<double> ratios;
  double ours = 0, slow = 0;
  for (int k = 0; k < cases; ++k) {
    const PathCase c = make(k);
    if (!c.path) continue;
    const double begin = cpu();
    const double duration = time_path(*c.path, c.limits).profile.duration();
    const double middle = cpu();
    test::SlowOptions options;
    options.intervals = intervals;
    ratios.push_back(duration / test::SlowTiming(*c.path, c.limits, options).duration());
    ours += middle - begin, slow += cpu() - middle;
  }
  if (!ratios.empty()) report(what, ratios, ours, slow);
}

/// Lines and arcs about a point before the robot, blended by 5 to 40 mm; nothing where it cannot be followed.
std::shared_ptr<const Path> arm_path(const kinematics::Chain& chain, Engine& engine) {
  const std::vector<double> seed{0.2, -1.3, 1.6, -1.9, -1.6, 0.1};
  const Pose home = chain.forward(seed);
  const auto near = [&] {
    Pose p = home;
    p.position = p.position + Vec3{even(engine, -0.2, 0.2), even(engine, -0.2, 0.2), even(engine, -0.2, 0.1)};
    p.rotation =
        p.rotation * from_rpy(even(engine, -0.3, 0.3), even(engine, -0.3, 0.3), even(engine, -0.5, 0.5));
    return p;
  };
  try {
    CartesianPathBuilder builder(home);
    for (int k = 0; k < 6; ++k) {
      const Corner corner{k < 5 ? even(engine, 0.005, 0.04) : 0, {}};
      if (k % 3 == 2)
        builder.arc(near().position, near(), ArcOrientation::interpolated, corner);
      else
        builder.line(near(), corner);
    }
    PathSections joints = moves::joints_along(chain, builder.build(), seed);
    return std::move(joints.sections.front());
  } catch (const Error&) {
    return nullptr;
  }
}

struct AxisCase {
  MotionState from, to;
  MotionLimits limits;
};
AxisCase axis_case(Engine& engine) {
  const auto size = [&] { return std::pow(10, even(engine, -1, 1)); };
  for (;;) {
    AxisCase c;
    c.limits = {size(), size(), 3 * size(), -size(), -size()};
    const auto state = [&](double at) {
      const double v = even(engine, -1, 1), a = even(engine, -1, 1);
      return MotionState{at, v < 0 ? -v * c.limits.min_velocity : v * c.limits.max_velocity,
                         a < 0 ? -a * c.limits.min_acceleration : a * c.limits.max_acceleration};
    };
    c.from = state(0), c.to = state(3 * size() * even(engine, -1, 1));
    const auto stays = [&](double v, double a) {
      const double later = v + a * std::abs(a) / (2 * c.limits.max_jerk);
      return later < c.limits.max_velocity && later > c.limits.min_velocity;
    };
    if (stays(c.from.velocity, c.from.acceleration) && stays(c.to.velocity, -c.to.acceleration)) return c;
  }
}

void states(const std::string& what, int cases, std::size_t axes, Engine& engine) {
  std::vector<double> ratios;
  double ours = 0, slow = 0;
  int unknown = 0;
  StateToState plan;
  for (int k = 0; k < cases; ++k) {
    std::vector<MotionState> from, to;
    std::vector<MotionLimits> limits;
    for (std::size_t i = 0; i < axes; ++i) {
      const AxisCase c = axis_case(engine);
      from.push_back(c.from), to.push_back(c.to), limits.push_back(c.limits);
    }
    const double begin = cpu();
    if (plan.plan(from, to, limits) != MotionStatus::ok) continue;
    const double middle = cpu();
    const double reference = axes == 1 ? test::SlowAxis(from[0], to[0], limits[0]).shortest()
                                       : test::slow_synchronised(from, to, limits);
    ours += middle - begin, slow += cpu() - middle;
    if (std::isfinite(reference))
      ratios.push_back(plan.duration() / reference);
    else
      ++unknown;
  }
  if (!ratios.empty()) report(what, ratios, ours, slow);
  if (unknown > 0) fmt::print("  {} cases where the slow optimiser found nothing are left out\n", unknown);
}

}  // namespace

int main(int argc, char** argv) {
  const int cases = argc > 1 ? std::max(4, std::atoi(argv[1])) : 20;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  Engine engine(seed);
  fmt::print("{:<34} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8} {:>11} {:>11}\n",
             "duration over the slow optimiser's", "cases", "mean", "least", "p50", "p90", "worst",
             "ours, ms", "slow, ms");
  const auto spline = [&](std::size_t points) {
    return [&, points](int k) {
      return PathCase{test::random_spline(6, points, 1000 * seed + std::uint64_t(k)), arm_limits(engine, 6)};
    };
  };
  path_family("10 waypoints, 6 axes", cases, 600, spline(10));
  path_family("50 waypoints, 6 axes", cases / 4, 2400, spline(50));
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  const description::RobotModel model = catalogue.load("universal_robots/ur5e");
  const kinematics::Chain chain(model, model.tool_link());
  path_family("UR5e, lines, arcs, blends", cases / 4, 1200, [&](int) {
    std::shared_ptr<const Path> path;
    for (int tries = 0; !path && tries < 20; ++tries) path = arm_path(chain, engine);
    return PathCase{path, arm_limits(engine, 6)};
  });
  states("state to state, 1 axis", 100 * cases, 1, engine);
  states("state to state, 3 axes together", 5 * cases, 3, engine);
  states("state to state, 6 axes together", 2 * cases, 6, engine);
}
