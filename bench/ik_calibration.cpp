// Inverse kinematics of calibrated arms: the closed-form arms of the catalogue with every axis moved as a
// maker's calibration moves it, and the UR5 with its elbow tilted.
//
//   build/release/bench/ik_calibration [POSES] [PART OF A NAME | =CASE]
//
// Cases: `ur5 elbow 0.6 mrad`, `ur5 elbow 3.6 mrad` (the elbow's axis turned about the upper arm), and for
// each robot a spread: every axis tilted by up to 1 mrad and moved by up to 0.4 mm, or by up to 5 mrad and
// 2 mm, drawn once for each robot from its name. Poses are those of random joint states within limits, each
// with a random seed.
//
// Printed for each case: how the solver sees the arm; mean, p50 and p99 of solve() and the mean of
// solve_all(), us (means are processor time; quantiles are of single calls on the clock, each the least of
// three, so that work of others on the machine does not count); `missed`: drawn joint
// states that solve_all() did not return; `lost`: states that 200 descents from random states find for
// one pose in twenty and solve_all() does not; `further`: poses for which solve() is more than 1e-3 rad
// farther from the seed than the nearest of solve_all(), and by how much on average; `unsolved` and
// `inexact`: of solve(), by the chain's own forward kinematics (2e-9 m and rad).
//
// It cannot show: how real calibrations are distributed. Uniform draws put as much weight on 5 mrad as on 0.
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/random.hpp"
#include "polyarm/kinematics/singularity.hpp"

namespace {

using namespace polyarm;
using namespace polyarm::ik;

struct Question {
  std::vector<double> q, seed;
  Pose target;
};

struct Figures {
  std::string how;
  long asked = 0, missed = 0, known = 0, lost = 0, further = 0, unsolved = 0, inexact = 0;
  double further_by = 0, mean = 0, p50 = 0, p99 = 0, worst = 0, all_mean = 0;
};

double processor_time_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

Vec3 direction(Random& random) {
  for (;;) {
    const Vec3 v{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    if (norm(v) > 0.1 && norm(v) < 1) return normalized(v);
  }
}

/// Tilts the axis of joint `j` by `angle` about `about` (of the joint's parent link) and moves it by `step`.
void move_axis(description::RobotModel& model, std::size_t j, const Vec3& about, double angle,
               const Vec3& step) {
  Pose& origin = model.joints[j].origin;
  origin.rotation = from_axis_angle(about, angle) * origin.rotation;
  origin.position = origin.position + step;
}

void calibrate(description::RobotModel& model, const std::string& robot, double mrad, double mm) {
  Random random(std::hash<std::string>{}(robot));
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (!model.joints[j].moves()) continue;
    const Vec3 about = direction(random), way = direction(random);
    const double angle = 1e-3 * random.between(0, mrad), far = 1e-3 * random.between(0, mm);
    move_axis(model, j, about, angle, far * way);
  }
}

void tilt_elbow(description::RobotModel& model, double mrad) {
  for (std::size_t j = 0; j < model.joints.size(); ++j)
    if (model.joints[j].name.find("elbow") != std::string::npos && model.joints[j].moves())
      move_axis(model, j, normalized(model.joints[j].origin.position), 1e-3 * mrad, {});
}

double difference(const Chain& chain, const double* a, const double* b) {
  double most = 0;
  for (std::size_t j = 0; j < chain.joints(); ++j) {
    const double period = chain.period(j), d = a[j] - b[j];
    if (chain.moves_tcp(j)) most = std::max(most, std::abs(period > 0 ? std::remainder(d, period) : d));
  }
  return most;
}

bool holds(const Chain& chain, const IkSolutions& found, const double* q, double within) {
  return std::any_of(found.begin(), found.end(),
                     [&](const IkSolution& one) { return difference(chain, one.q.data(), q) < within; });
}

bool confirmed(const Chain& chain, const Pose& target, const IkSolution& one) {
  const Pose there = chain.forward({one.q.data(), chain.joints()});
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (chain.moves_tcp(i) && (one.q[i] < chain.lower()[i] || one.q[i] > chain.upper()[i])) return false;
  return norm(there.position - target.position) < 2e-9 &&
         angle_between(there.rotation, target.rotation) < 4e-8;  // arc cosine keeps half the digits
}

std::vector<Question> questions(const Chain& chain, int poses) {
  Random random(71);
  std::vector<Question> out(static_cast<std::size_t>(poses));
  for (Question& one : out) {
    for (std::size_t j = 0; j < chain.joints(); ++j) {
      one.q.push_back(random_value(chain, j, random));
      one.seed.push_back(random_value(chain, j, random));
    }
    one.target = chain.forward(one.q);
  }
  return out;
}

/// What many descents find for a pose and `found` does not hold, away from where solutions merge.
void search_exhaustively(const Chain& chain, const NumericIk& numeric, const Question& one,
                         const IkSolutions& found, Figures& out) {
  IkSolutions others;
  numeric.solve_all(one.target, one.seed, others);
  for (const IkSolution& other : others) {
    if (smallest_singular_value(chain, {other.q.data(), chain.joints()}) < 1e-4) continue;
    ++out.known;
    out.lost += !holds(chain, found, other.q.data(), 1e-4);
  }
}

Figures measure(const Chain& chain, int poses) {
  const InverseKinematics arm(chain);
  NumericSettings settings;
  settings.searches = 200;
  const NumericIk numeric(chain, settings);
  const auto all = questions(chain, poses);
  Figures out;
  out.how = arm.report();
  out.asked = poses;
  IkSolution nearest;
  IkSolutions found;
  std::vector<double> us;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Question& one = all[k];
    const bool solved = arm.solve(one.target, one.seed, nearest) == IkOutcome::solved;
    out.unsolved += !solved;
    out.inexact += solved && !confirmed(chain, one.target, nearest);
    arm.solve_all(one.target, one.seed, found);
    // Solutions that are about to merge are known to half the digits.
    const double same = smallest_singular_value(chain, one.q) < 1e-4 ? 1e-2 : 1e-6;
    out.missed += !holds(chain, found, one.q.data(), same);
    if (solved && found.count > 0 && nearest.distance > found[0].distance + 1e-3) {
      ++out.further;
      out.further_by += nearest.distance - found[0].distance;
    }
    if (k % 20 == 0) search_exhaustively(chain, numeric, one, found, out);
  }
  out.further_by /= static_cast<double>(std::max(1L, out.further));
  double begin = processor_time_us();
  for (const Question& one : all) arm.solve(one.target, one.seed, nearest);
  out.mean = (processor_time_us() - begin) / poses;
  begin = processor_time_us();
  for (const Question& one : all) arm.solve_all(one.target, one.seed, found);
  out.all_mean = (processor_time_us() - begin) / poses;
  for (const Question& one : all) {
    double least = 1e300;
    for (int k = 0; k < 3; ++k) {
      const auto from = std::chrono::steady_clock::now();
      arm.solve(one.target, one.seed, nearest);
      least = std::min(
          least, std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - from).count());
    }
    us.push_back(least);
  }
  std::sort(us.begin(), us.end());
  out.p50 = us[us.size() / 2];
  out.p99 = us[us.size() * 99 / 100];
  return out;
}

void print(const std::string& robot, const Figures& f) {
  fmt::print(
      "{:44} solve {:7.2f} {:7.2f} {:8.2f}  all {:7.2f}  missed {} of {}, lost {} of {}, further {} "
      "({:.2g}), "
      "unsolved {}, inexact {}; {}\n",
      robot, f.mean, f.p50, f.p99, f.all_mean, f.missed, f.asked, f.lost, f.known, f.further, f.further_by,
      f.unsolved, f.inexact, f.how.substr(0, 90));
  std::fflush(stdout);
}

/// Sums over the robots of one spread.
struct Sums {
  Figures f;
  long robots = 0;
  std::vector<double> means, p99s;
  void add(const Figures& one) {
    ++robots;
    f.asked += one.asked, f.missed += one.missed, f.known += one.known, f.lost += one.lost;
    f.further += one.further, f.unsolved += one.unsolved, f.inexact += one.inexact;
    f.further_by += one.further_by * static_cast<double>(one.further);
    f.mean += one.mean, f.all_mean += one.all_mean;
    means.push_back(one.mean), p99s.push_back(one.p99);
  }
  void print(const std::string& name) {
    if (robots == 0) return;
    std::sort(means.begin(), means.end());
    std::sort(p99s.begin(), p99s.end());
    const auto middle = static_cast<std::size_t>(robots / 2);
    fmt::print(
        "## {}: {} robots, solve mean of means {:.2f}, median {:.2f}, worst {:.2f} us, p99 median {:.2f}, "
        "worst {:.2f} us; solve_all mean {:.2f} us; missed {} of {}, lost {} of {}, further {} ({:.2g}), "
        "unsolved {}, inexact {}\n",
        name, robots, f.mean / static_cast<double>(robots), means[middle], means.back(), p99s[middle],
        p99s.back(), f.all_mean / static_cast<double>(robots), f.missed, f.asked, f.lost, f.known, f.further,
        f.further_by / static_cast<double>(std::max(1L, f.further)), f.unsolved, f.inexact);
  }
};

}  // namespace

int main(int argc, char** argv) {
  const int poses = argc > 1 ? std::max(20, std::atoi(argv[1])) : 1000;
  const std::string part = argc > 2 ? argv[2] : "";
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  for (const double mrad : {0.6, 3.6}) {
    const std::string name = fmt::format("ur5 elbow {} mrad", mrad);
    if (part.starts_with('=') ? part != "=" + name : !part.empty()) continue;
    auto model = catalogue.load("universal_robots/ur5");
    tilt_elbow(model, mrad);
    print(name, measure(Chain(model, model.tool_link()), poses));
  }
  if (part.starts_with('=')) return 0;
  for (const double mrad : {1.0, 5.0}) {
    Sums sums;
    for (const std::string& robot : catalogue.names()) {
      if (robot.find(part) == std::string::npos) continue;
      auto model = catalogue.load(robot);
      if (InverseKinematics(model, model.tool_link()).way() != IkWay::closed_form) continue;
      calibrate(model, robot, mrad, 0.4 * mrad);
      const Figures figures = measure(Chain(model, model.tool_link()), poses);
      print(fmt::format("{} {} mrad", robot, mrad), figures);
      sums.add(figures);
    }
    sums.print(fmt::format("up to {} mrad and {} mm", mrad, 0.4 * mrad));
  }
  return 0;
}
