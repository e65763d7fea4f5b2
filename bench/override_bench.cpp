// What a control cycle costs while a robot on a planned path changes its speed, and how near the time of a
// stop is to the shortest there is: on lines and arcs of the TCP, six and seven joints, and on random splines
// of six joints. Of each cycle the cheapest of some repetitions counts, since a machine that does other
// things interrupts some of them; so it cannot show what an interrupted cycle takes. Takes minutes with
// `ratio [STOPS] [SEED]`: the shortest stop is searched for (tests/support/slow_stop.hpp).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/timing/path_follower.hpp"
#include "polyarm/timing/timing.hpp"
#include "tests/support/arm_stop_moments.hpp"
#include "tests/support/slow_stop.hpp"
#include "tests/support/stop_moments.hpp"
#include "tests/support/test_paths.hpp"

namespace polyarm {
namespace {

using namespace paths;
using namespace timing;
using namespace trajectory;
constexpr double kPeriod = 1e-3;

struct Case {
  std::string name;
  std::vector<MotionLimits> limits;
  TimedPath path;
};

/// Five lines and arcs with corners of 2 cm; the joints' limits are those of a UR5e's size.
Case lines_and_arcs(const std::string& robot, const std::vector<double>& q) {
  const kinematics::Chain chain = test::chain_of(robot);
  Pose at = chain.forward(q);
  CartesianPathBuilder builder(at);
  for (int i = 0; i < 5; ++i) {
    Pose to = at;
    to.position = to.position + (i % 2 ? Vec3{0, -0.12, 0.03} : Vec3{i % 4 ? -0.12 : 0.12, 0, -0.03});
    if (i % 3 == 2)
      builder.arc(0.5 * (at.position + to.position) + Vec3{0, 0, 0.03}, to, ArcOrientation::interpolated,
                  {0.02, ""});
    else
      builder.line(to, {0.02, ""});
    at = to;
  }
  std::vector<MotionLimits> limits(q.size(), MotionLimits::symmetric(3.14, 12.6, 126));
  std::shared_ptr<const Path> path = moves::joints_along(chain, builder.build().sections[0], q);
  return {robot, limits, timed(path, limits)};
}

Case spline(std::uint64_t seed) {
  std::vector<MotionLimits> limits(6, MotionLimits::symmetric(2, 8, 100));
  return {"spline " + std::to_string(seed), limits, timed(test::random_spline(6, 8, seed), limits)};
}

/// Of every cycle in which the factor is not steady, µs.
std::vector<double> cycles(const Case& c, std::uint64_t seed) {
  using Clock = std::chrono::steady_clock;
  constexpr int kRepetitions = 9;
  std::vector<double> least;
  for (int repetition = 0; repetition < kRepetitions; ++repetition) {
    std::mt19937_64 engine(seed);
    std::uniform_real_distribution<double> draw(0, 1);
    PathOverride o(c.path, c.limits, kPeriod);
    o.begin(0, 1);
    double target = 1;
    std::size_t n = 0;
    for (int cycle = 0; cycle < 20'000 && !o.finished(); ++cycle) {
      if (cycle % 150 == 0) target = cycle / 150 % 2 ? 0 : draw(engine);
      const bool steady = o.factor() == target && o.rate() == 0;
      const auto before = Clock::now();
      o.advance(target);
      const double took = std::chrono::duration<double, std::micro>(Clock::now() - before).count();
      if (steady) continue;
      if (repetition == 0)
        least.push_back(took);
      else
        least[n] = std::min(least[n], took);
      ++n;
    }
  }
  return least;
}

double at(const std::vector<double>& sorted, double share) {
  return sorted[std::min(sorted.size() - 1, std::size_t(share * double(sorted.size())))];
}

void cost(const Case& c) {
  std::vector<double> all;
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    for (const double us : cycles(c, seed)) all.push_back(us);
  std::sort(all.begin(), all.end());
  std::printf("%-28s %6zu cycles  p50 %5.1f us  p99 %5.1f us  worst %5.1f us\n", c.name.c_str(), all.size(),
              at(all, 0.5), at(all, 0.99), all.back());
}

/// Stops from random moments at random factors, every other one at full speed.
void ratio(const char* name, std::size_t stops, std::uint64_t seed,
           test::StopMoment (*moment)(std::uint64_t)) {
  std::vector<double> all;
  for (; all.size() < stops; ++seed) {
    const test::StopMoment m = moment(seed);
    PathOverride o(m.path, m.limits, kPeriod);
    o.begin(m.time, m.factor);
    const StoppingWay stop = o.stopping();
    if (o.finished() || !stop.known) continue;
    all.push_back(stop.time / test::SlowStop(m.path, m.limits).search(m.time, m.factor));
    if (all.back() > 1.1) std::printf("%s, seed %llu: %.3f\n", name, (unsigned long long)seed, all.back());
  }
  std::sort(all.begin(), all.end());
  std::printf("%s: %zu stops over the shortest found: p10 %.3f  p50 %.3f  p90 %.3f  worst %.3f\n", name,
              all.size(), at(all, 0.1), at(all, 0.5), at(all, 0.9), all.back());
}

/// docs/stop.svg: the speed of the TCP along its path while it is overridden, held, stepped back and resumed;
/// in the end it is held again and the rest of the path discarded: dashed, what it would have been.
void plot(const Case& c) {
  struct Phase {
    double until;
    const char* name;
    double target;  // below zero: back, by 0.1 s of the plan
  };
  const std::vector<Phase> phases{{0.45, "100 %", 1},  {0.95, "40 %", 0.4},       {1.35, "100 %", 1},
                                  {1.85, "hold", 0},   {3.0, "back 0.1 s", -0.1}, {3.3, "held", 0},
                                  {3.75, "resume", 1}, {4.2, "hold", 0},          {4.8, "discard", 0}};
  PathFollower follower(c.path, c.limits, kPeriod);
  follower.begin(1);
  constexpr double kWidth = 150, kHeight = 220, kLeft = 50, kTop = 30;  // per s, per m/s; margins
  constexpr double kZero = kTop + kHeight;
  std::printf(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"800\" height=\"330\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"800\" height=\"330\" "
      "fill=\"white\"/>\n<path d=\"M%g %gH780M%g %gV%g\" stroke=\"#888\" fill=\"none\"/>\n",
      kLeft, kZero, kLeft, kTop - 10, kZero + 40);
  double begin = 0, time = 0;
  std::string line, rest;
  std::size_t hint = 0;
  for (const Phase& phase : phases) {
    std::printf(
        "<path d=\"M%.1f %gV%g\" stroke=\"#ccc\"/>\n<text x=\"%.1f\" y=\"20\" fill=\"#444\">%s</text>\n",
        kLeft + kWidth * begin, kTop - 5, kZero + 30, kLeft + kWidth * begin + 3, phase.name);
    if (phase.target < 0) follower.step_back(0.1, 1e9);
    if (&phase == &phases.back()) {  // the plan from where it stands, as it would be resumed
      PathOverride resumed(c.path, c.limits, kPeriod);
      resumed.begin(follower.time(), 0);
      for (double t = time; t < phase.until && !resumed.finished(); t += kPeriod) {
        resumed.advance(1);
        if (std::lround(t / kPeriod) % 5 != 0) continue;
        char point[64];
        std::snprintf(point, sizeof point, "%s%.1f %.1f", rest.empty() ? "M" : "L", kLeft + kWidth * t,
                      kZero - kHeight * c.path.profile().at(resumed.time(), hint).speed * resumed.factor());
        rest += point;
      }
    }
    for (; time < phase.until && !follower.finished(); time += kPeriod) {
      if (phase.target < 0)
        follower.advance_back(-phase.target);
      else
        follower.advance(phase.target);
      const double speed = c.path.profile().at(follower.time(), hint).speed * follower.factor();
      char point[64];
      if (std::lround(time / kPeriod) % 5 == 0) {
        std::snprintf(point, sizeof point, "%s%.1f %.1f", line.empty() ? "M" : "L", kLeft + kWidth * time,
                      kZero - kHeight * speed);
        line += point;
      }
    }
    begin = phase.until;
  }
  std::printf("<path d=\"%s\" stroke=\"#06c\" stroke-width=\"1.5\" fill=\"none\"/>\n", line.c_str());
  std::printf("<path d=\"%s\" stroke=\"#888\" stroke-dasharray=\"4 4\" fill=\"none\"/>\n", rest.c_str());
  for (int k = 0; k <= 4; ++k)
    std::printf("<text x=\"%.1f\" y=\"%g\">%d s</text>\n", kLeft + kWidth * k - 6, kZero + 55, k);
  for (const double v : {0.0, 0.5, 1.0})
    std::printf("<text x=\"10\" y=\"%.1f\">%.1f m/s</text>\n", kZero - kHeight * v + 4, v);
  std::printf("</svg>\n");
}

}  // namespace
}  // namespace polyarm

int main(int argc, char** argv) {
  using namespace polyarm;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // takes minutes
  if (argc > 1 && std::string(argv[1]) == "plot") {
    plot(lines_and_arcs("universal_robots/ur5e", {0, -1.4, 1.8, -2.0, -1.57, 0.3}));
    return 0;
  }
  if (argc > 1 && std::string(argv[1]) == "ratio") {
    const std::size_t stops = argc > 2 ? std::size_t(std::atoi(argv[2])) : 60;
    const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
    ratio("splines and blended lines of six joints", stops, seed, test::random_moment);
    ratio("lines, arcs and splines of five arms", stops, seed, test::moment_of_an_arm);
    return 0;
  }
  cost(lines_and_arcs("universal_robots/ur5e", {0, -1.4, 1.8, -2.0, -1.57, 0.3}));
  cost(lines_and_arcs("kuka/lbr_iiwa_7_r800", {0.2, 0.5, -0.1, -1.4, 0.2, 0.9, 0}));
  for (const std::uint64_t seed : {1, 2, 3}) cost(spline(seed));
}
