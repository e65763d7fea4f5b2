// The page docs/ik-catalogue.md: for every robot of the catalogue how its inverse kinematics is solved, how
// many branches poses have, how many poses are solved and how long that takes.
//
//   build/release/bench/ik_catalogue [POSES] [PART OF A NAME] > docs/ik-catalogue.md
//
// `ik_catalogue setup [PART OF A NAME | =WAY]` measures instead how long it takes from a chain to a solver
// that is ready, of every robot: least and median of 60 solvers, in us; then the first question and the
// median of 200 (all branches); last of each way the worst. The first question is a new solver's, so that
// work put off until it is asked would show.
//
// Poses are those of random joint states within limits (POSES of each robot, 500 by default), each with a
// random seed. An answer counts that the chain's own forward kinematics confirms to 1e-8 m and 1e-7 rad,
// within limits. Times are of single calls, median, with the clock's some 20 ns; other work on the machine
// shows in them.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <string>

#include "bench/ik_words.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/random.hpp"

namespace {

using namespace polyarm;
using namespace polyarm::ik;

std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "processor unknown";
}

struct Row {
  int axes = 0;
  std::string way, report;
  double branches = 0, solved = 0, kept = 0, all_us = 0, nearest_us = 0;
};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <typename Call>
double microseconds(const Call& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

bool confirmed(const Chain& chain, const Pose& target, const IkSolution& one) {
  const Pose there = chain.forward({one.q.data(), chain.joints()});
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (chain.moves_tcp(i) && (one.q[i] < chain.lower()[i] || one.q[i] > chain.upper()[i])) return false;
  return norm(there.position - target.position) < 1e-8 &&
         angle_between(there.rotation, target.rotation) < 1e-7;
}

/// Whether one of `found` is `q` but for whole turns.
bool among(const Chain& chain, const IkSolutions& found, const std::vector<double>& q) {
  return std::any_of(found.begin(), found.end(), [&](const IkSolution& one) {
    double worst = 0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const double period = chain.period(i), d = one.q[i] - q[i];
      if (chain.moves_tcp(i)) worst = std::max(worst, std::abs(period > 0 ? std::remainder(d, period) : d));
    }
    return worst < 1e-3;
  });
}

Row measure(const description::RobotModel& model, int poses) {
  const Chain chain(model, model.tool_link());
  const InverseKinematics arm(chain);
  Row out;
  for (std::size_t i = 0; i < chain.joints(); ++i) out.axes += chain.moves_tcp(i);
  out.way = words(arm.way());
  out.report = arm.report();
  Random random(61);
  IkSolutions found;
  IkSolution one;
  std::vector<double> all_us, nearest_us;
  for (int i = 0; i < poses; ++i) {
    std::vector<double> q, seed;
    for (std::size_t j = 0; j < chain.joints(); ++j) {
      q.push_back(random_value(chain, j, random));
      seed.push_back(random_value(chain, j, random));
    }
    const Pose target = chain.forward(q);
    all_us.push_back(microseconds([&] { arm.solve_all(target, seed, found); }));
    nearest_us.push_back(microseconds([&] { arm.solve(target, seed, one); }));
    out.branches += static_cast<double>(found.count) / poses;
    out.solved += 100.0 * confirmed(chain, target, one) / poses;
    out.kept += 100.0 * among(chain, found, q) / poses;
  }
  out.all_us = median(all_us);
  out.nearest_us = median(nearest_us);
  return out;
}

struct Setup {
  double least_us = 0, median_us = 0, first_us = 0, all_us = 0;
};

Setup measure_setup(const Chain& chain) {
  constexpr int kSolvers = 60, kPoses = 200;
  Setup out;
  std::vector<double> made_us, first_us, all_us;
  Random random(61);
  std::vector<double> q(chain.joints()), seed(chain.joints());
  IkSolutions found;
  const auto draw = [&] {
    for (std::size_t j = 0; j < chain.joints(); ++j)
      q[j] = random_value(chain, j, random), seed[j] = random_value(chain, j, random);
    return chain.forward(q);
  };
  for (int i = 0; i < kSolvers; ++i) {
    std::optional<InverseKinematics> arm;
    made_us.push_back(microseconds([&] { arm.emplace(chain); }));
    const Pose target = draw();
    first_us.push_back(microseconds([&] { arm->solve_all(target, seed, found); }));
  }
  const InverseKinematics arm(chain);
  for (int i = 0; i < kPoses; ++i) {
    const Pose target = draw();
    all_us.push_back(microseconds([&] { arm.solve_all(target, seed, found); }));
  }
  out.least_us = *std::min_element(made_us.begin(), made_us.end());
  out.median_us = median(made_us);
  out.first_us = median(first_us);
  out.all_us = median(all_us);
  return out;
}

void print_setups(const description::Catalogue& catalogue, const std::string& part) {
  struct Worst {
    int robots = 0;
    double us = 0;
    std::string robot;
  };
  std::map<std::string, Worst> worst;
  for (const std::string& robot : catalogue.names()) {
    if (!part.starts_with('=') && robot.find(part) == std::string::npos) continue;
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const std::string way = words(InverseKinematics(chain).way());
    if (part.starts_with('=') && !way.starts_with(part.substr(1))) continue;
    const Setup here = measure_setup(chain);
    fmt::print("{:45} {:12} {:6.1f} {:6.1f}   {:6.1f} {:6.1f}\n", robot, way, here.least_us, here.median_us,
               here.first_us, here.all_us);
    Worst& most = worst[way];
    ++most.robots;
    if (here.median_us > most.us) most.us = here.median_us, most.robot = robot;
  }
  for (const auto& [way, most] : worst)
    fmt::print("{}: {} robots, at most {:.1f} us ({})\n", way, most.robots, most.us, most.robot);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "setup") {
    print_setups(description::Catalogue({POLYARM_SOURCE_DIR "/robots"}), argc > 2 ? argv[2] : "");
    return 0;
  }
  const int poses = argc > 1 ? std::max(1, std::atoi(argv[1])) : 500;
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  fmt::print(
      "# Inverse kinematics of every robot of the catalogue\n\n"
      "Written by `build/release/bench/ik_catalogue {0} > docs/ik-catalogue.md` ({1}, one core, beside other "
      "work). For each robot the program draws {0} random joint states within its limits, and solves their "
      "poses. [Inverse kinematics](inverse-kinematics.md) explains the ways.\n\n"
      "| column | meaning |\n|---|---|\n"
      "| branches | mean number of solutions within the limits. An arm with a redundant axis has infinitely "
      "many; at most 64 are counted |\n"
      "| solved | poses for which `solve` finds a solution that forward kinematics confirms |\n"
      "| found again | poses whose solutions contain the joint state that the pose was made from; empty for "
      "arms with a redundant axis |\n"
      "| all, nearest | median time of `solve_all` and of `solve`, from random seeds |\n"
      "| report | what the solver found about the arm |\n\n"
      "| robot | axes | way | branches | solved | found again | all | nearest | report |\n"
      "|---|---|---|---|---|---|---|---|---|\n",
      poses, processor());
  for (const std::string& robot : catalogue.names()) {
    if (argc > 2 && robot.find(argv[2]) == std::string::npos) continue;
    const Row row = measure(catalogue.load(robot), poses);
    const bool endless = row.way == "spare axis" || row.axes > 6;
    fmt::print("| {} | {} | {} | {:.1f} | {:.5g} % | {} | {:.3g} µs | {:.3g} µs | {} |\n", robot, row.axes,
               row.way, row.branches, row.solved, endless ? "" : fmt::format("{:.5g} %", row.kept),
               row.all_us, row.nearest_us, row.report);
  }
  return 0;
}
