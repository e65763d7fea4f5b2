// What all branches of a pose cost in closed form, in one call, for arms of the catalogue; what solve_nearest
// costs on top; and forward kinematics and the Jacobian, which every other way is made of. Orocos KDL is
// measured beside them in the same run where its library is installed: its Levenberg-Marquardt solver with
// random restarts, whole turns taken off and limits checked, up to 20 restarts. Poses: 4,096 random joint
// states within limits, each with a random seed; every answer of ours is checked by the chain's own forward
// kinematics before the clock starts. Counters: p50_ns and p99_ns of single calls, timed one by one (some 20
// ns of that is the clock), branches per call, solved_percent. It cannot show what cold caches cost, and on a
// machine that does other work the p99 is that work.
//
// The numeric rows: `numeric` from a random seed, errors within 1e-6 m and rad and polished where a step or
// two do it; `numeric_batch` 4,096 targets in one call (time of one); `numeric_track` from the solution plus
// noise of 0.02 rad per joint; `numeric_out_of_reach` a pose that cannot be had. Their solved_percent counts
// what the chain's own forward kinematics confirms, inside limits.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/arm_geometry.hpp"
#include "polyarm/kinematics/random.hpp"
#include "polyarm/kinematics/singularity.hpp"

#ifdef POLYARM_KDL
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#endif

namespace {

using namespace polyarm;
using namespace polyarm::ik;
constexpr std::size_t kPoses = 4096;
constexpr const char* kArms[] = {
    "universal_robots/ur5e", "abb/irb_2400_10", "fanuc/m_10ia", "doosan/m0609",
    "kuka/lbr_iiwa_7_r800",  "fanuc/crx_10ia",  "yaskawa/hc10", "kinova/jaco2_6dof_non_spherical_j2n6s300",
    "ufactory/xarm_6",       "franka/fer_panda"};
constexpr const char* kNumericArms[] = {"universal_robots/ur5", "universal_robots/ur10", "franka/fer_panda",
                                        "kuka/lbr_iiwa_7_r800", "abb/irb_6640_185_2_8"};

struct Question {
  std::vector<double> q, seed;
  Pose target;
};

Chain chain_of(const char* name) {
  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
  return Chain(model, model.tool_link());
}

std::vector<Question> questions(const Chain& chain) {
  Random random(21);
  std::vector<Question> out(kPoses);
  for (Question& question : out) {
    for (std::size_t i = 0; i < chain.joints(); ++i) {
      question.q.push_back(random_value(chain, i, random));
      question.seed.push_back(random_value(chain, i, random));
    }
    question.target = chain.forward(question.q);
  }
  return out;
}

/// Times `ask(question)` in the benchmark's loop, then once more one by one.
template <typename Ask>
void measure(benchmark::State& state, const std::vector<Question>& all, const Ask& ask) {
  std::size_t i = 0;
  for (auto _ : state) ask(all[++i % kPoses]);
  std::vector<double> ns;
  for (const Question& question : all) {
    const auto begin = std::chrono::steady_clock::now();
    ask(question);
    ns.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count());
  }
  std::sort(ns.begin(), ns.end());
  state.counters["p50_ns"] = ns[ns.size() / 2];
  state.counters["p99_ns"] = ns[ns.size() * 99 / 100];
}

void all_branches(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  const InverseKinematics arm(chain);
  const auto all = questions(chain);
  static IkSolutions found;
  std::size_t branches = 0, solved = 0;
  for (const Question& question : all) {
    arm.solve_all(question.target, question.seed, found);
    bool right = found.count > 0;
    for (const IkSolution& one : found) {
      const Pose there = chain.forward({one.q.data(), chain.joints()});
      right &= norm(there.position - question.target.position) < 1e-8 &&
               angle_between(there.rotation, question.target.rotation) < 1e-7;
    }
    solved += right;
    branches += found.count;
  }
  measure(state, all, [&](const Question& question) {
    benchmark::DoNotOptimize(arm.solve_all(question.target, question.seed, found));
  });
  state.counters["branches"] = static_cast<double>(branches) / kPoses;
  state.counters["solved_percent"] = 100.0 * static_cast<double>(solved) / kPoses;
}

void nearest_branch(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  const InverseKinematics arm(chain);
  IkSolution found;
  measure(state, questions(chain), [&](const Question& question) {
    benchmark::DoNotOptimize(arm.solve(question.target, question.seed, found));
  });
}

/// 4,096 poses in one call, the nearest branch of each; the time is one pose's.
void solve_batch(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  const InverseKinematics arm(chain);
  const auto all = questions(chain);
  std::vector<Pose> targets;
  for (const Question& question : all) targets.push_back(question.target);
  std::vector<IkSolution> found(kPoses);
  std::vector<IkOutcome> outcomes(kPoses);
  std::size_t solved = 0;
  for (auto _ : state) solved = arm.solve_batch(targets, all[0].seed, found, outcomes);
  state.counters["each"] =
      benchmark::Counter(kPoses, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["solved_percent"] = 100.0 * static_cast<double>(solved) / kPoses;
}

void description_to_solver(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  for (auto _ : state) benchmark::DoNotOptimize(bool(InverseKinematics(chain)));
}

void forward(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  measure(state, questions(chain),
          [&](const Question& question) { benchmark::DoNotOptimize(chain.forward(question.q)); });
}

void jacobian(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  std::vector<double> J(6 * chain.joints());
  measure(state, questions(chain),
          [&](const Question& question) { benchmark::DoNotOptimize(chain.jacobian(question.q, J)); });
}

bool confirmed(const Chain& chain, const Pose& target, std::span<const double> q, double tolerance) {
  const Pose there = chain.forward(q);
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (q[i] < chain.lower()[i] || q[i] > chain.upper()[i]) return false;
  return norm(there.position - target.position) < tolerance &&
         angle_between(there.rotation, target.rotation) < tolerance;
}

void numeric(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  const NumericIk arm(chain);
  const auto all = questions(chain);
  IkSolution found;
  std::size_t solved = 0;
  for (const Question& question : all)
    solved += arm.solve(question.target, question.seed, found) == IkOutcome::solved &&
              confirmed(chain, question.target, {found.q.data(), chain.joints()}, 1.1e-6);
  measure(state, all, [&](const Question& question) {
    benchmark::DoNotOptimize(arm.solve(question.target, question.seed, found));
  });
  state.counters["solved_percent"] = 100.0 * static_cast<double>(solved) / kPoses;
}

void numeric_batch(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  const NumericIk arm(chain);
  std::vector<Pose> targets;
  for (const Question& question : questions(chain)) targets.push_back(question.target);
  std::vector<IkSolution> found(kPoses);
  for (auto _ : state) benchmark::DoNotOptimize(arm.solve_batch(targets, {}, found));
  std::size_t solved = 0;
  for (std::size_t i = 0; i < kPoses; ++i)
    solved += found[i].exact && confirmed(chain, targets[i], {found[i].q.data(), chain.joints()}, 1.1e-6);
  state.counters["each"] =
      benchmark::Counter(kPoses, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["solved_percent"] = 100.0 * static_cast<double>(solved) / kPoses;
}

/// Questions whose seed is the solution and a little noise (roughly normal).
std::vector<Question> nearby_questions(const Chain& chain) {
  std::vector<Question> out = questions(chain);
  Random random(22);
  for (Question& question : out)
    for (std::size_t i = 0; i < question.q.size(); ++i) {
      double noise = -6;
      for (int k = 0; k < 12; ++k) noise += random.unit();
      question.seed[i] = std::clamp(question.q[i] + 0.02 * noise, chain.lower()[i], chain.upper()[i]);
    }
  return out;
}

void numeric_track(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  const NumericIk arm(chain);
  const auto all = nearby_questions(chain);
  IkSolution found;
  std::size_t solved = 0;
  for (const Question& question : all)
    solved += arm.track(question.target, question.seed, found) == IkOutcome::solved &&
              confirmed(chain, question.target, {found.q.data(), chain.joints()}, 1.1e-6);
  measure(state, all, [&](const Question& question) {
    benchmark::DoNotOptimize(arm.track(question.target, question.seed, found));
  });
  state.counters["solved_percent"] = 100.0 * static_cast<double>(solved) / kPoses;
}

void numeric_out_of_reach(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  const NumericIk arm(chain);
  auto all = questions(chain);
  for (Question& question : all) question.target.position.x += 2.2 * chain.reach();
  IkSolution found;
  std::size_t i = 0;
  for (auto _ : state) {
    const Question& question = all[++i % kPoses];
    benchmark::DoNotOptimize(arm.solve(question.target, question.seed, found));
  }
}

#ifdef POLYARM_KDL
KDL::Vector kdl(const Vec3& v) {
  return {v.x, v.y, v.z};
}

/// The same arm from the same axes; all frames parallel at zero.
KDL::Chain kdl_chain(const Chain& chain) {
  std::string why_not;
  const ArmGeometry arm = *geometry_of(chain, why_not);
  KDL::Chain out;
  Vec3 at;
  for (std::size_t i = 0; i < arm.count; ++i) {
    const JointAxis& axis = arm.axes[i];
    const bool last = i + 1 == arm.count;
    const Vec3 next = last ? arm.tool_position : arm.axes[i + 1].point;
    const Vec3 first = i == 0 ? axis.point : Vec3{};
    KDL::Frame tip(kdl(next - (i == 0 ? Vec3{} : axis.point)));
    const Rotation& r = arm.tool_rotation;
    if (last) tip.M = KDL::Rotation(kdl(r.x), kdl(r.y), kdl(r.z));
    out.addSegment(KDL::Segment(KDL::Joint(kdl(first), kdl(axis.direction), KDL::Joint::RotAxis), tip));
    at = next;
  }
  return out;
}

KDL::JntArray kdl_state(const std::vector<double>& q) {
  KDL::JntArray out(static_cast<unsigned>(q.size()));
  for (unsigned i = 0; i < q.size(); ++i) out(i) = q[i];
  return out;
}

void kdl_forward(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  const KDL::Chain peer = kdl_chain(chain);
  KDL::ChainFkSolverPos_recursive solver(peer);
  KDL::JntArray q(static_cast<unsigned>(chain.joints()));
  KDL::Frame frame;
  measure(state, questions(chain), [&](const Question& question) {
    for (unsigned i = 0; i < q.rows(); ++i) q(i) = question.q[i];
    solver.JntToCart(q, frame);
    benchmark::DoNotOptimize(frame);
  });
}

void kdl_jacobian(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  const KDL::Chain peer = kdl_chain(chain);
  KDL::ChainJntToJacSolver solver(peer);
  KDL::Jacobian J(static_cast<unsigned>(chain.joints()));
  KDL::JntArray q(static_cast<unsigned>(chain.joints()));
  measure(state, questions(chain), [&](const Question& question) {
    for (unsigned i = 0; i < q.rows(); ++i) q(i) = question.q[i];
    solver.JntToJac(q, J);
    benchmark::DoNotOptimize(J.data.data());
  });
}

void kdl_lma(benchmark::State& state, const Chain& chain, const std::vector<Question>& questions_asked) {
  const KDL::Chain peer = kdl_chain(chain);
  // Radians count as metres do, as in ours; its own default counts them a hundredth.
  const Eigen::Matrix<double, 6, 1> alike = Eigen::Matrix<double, 6, 1>::Ones();
  KDL::ChainIkSolverPos_LMA solver(peer, alike);
  KDL::JntArray out(static_cast<unsigned>(chain.joints()));
  Random random(5);
  std::size_t solved = 0, asked = 0;
  measure(state, questions_asked, [&](const Question& question) {
    const Rotation r = rotation_of(question.target.rotation);
    const KDL::Frame target(KDL::Rotation(kdl(r.x), kdl(r.y), kdl(r.z)), kdl(question.target.position));
    KDL::JntArray seed = kdl_state(question.seed);
    bool inside = false;
    for (int k = 0; k < 20 && !inside; ++k) {
      inside = solver.CartToJnt(seed, target, out) >= 0;
      for (unsigned i = 0; inside && i < out.rows(); ++i) {
        out(i) = std::remainder(out(i), 2 * 3.14159265358979323846);
        inside &= out(i) >= chain.lower()[i] && out(i) <= chain.upper()[i];
      }
      for (unsigned i = 0; i < seed.rows(); ++i) seed(i) = random_value(chain, i, random);
    }
    ++asked;
    solved += inside && confirmed(chain, question.target, {out.data.data(), chain.joints()}, 2e-5);
  });
  state.counters["solved_percent"] = 100.0 * static_cast<double>(solved) / static_cast<double>(asked);
}

void kdl_lma_restarts(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  kdl_lma(state, chain, questions(chain));
}

void kdl_lma_track(benchmark::State& state, const char* name) {
  const Chain chain = chain_of(name);
  kdl_lma(state, chain, nearby_questions(chain));
}
#endif

const bool kRegistered = [] {
  for (const char* name : kArms) {
    const auto add = [&](const char* what, void (*run)(benchmark::State&, const char*)) {
      benchmark::RegisterBenchmark((std::string(what) + "/" + name).c_str(), run, name);
    };
    add("all_branches", all_branches);
    add("nearest_branch", nearest_branch);
    add("solve_batch", solve_batch);
    add("description_to_solver", description_to_solver);
    add("forward", forward);
    add("jacobian", jacobian);
#ifdef POLYARM_KDL
    add("kdl_forward", kdl_forward);
    add("kdl_jacobian", kdl_jacobian);
#endif
  }
  for (const char* name : kNumericArms) {
    const auto add = [&](const char* what, void (*run)(benchmark::State&, const char*)) {
      benchmark::RegisterBenchmark((std::string(what) + "/" + name).c_str(), run, name);
    };
    add("numeric", numeric);
    add("numeric_batch", numeric_batch);
    add("numeric_track", numeric_track);
    add("numeric_out_of_reach", numeric_out_of_reach);
#ifdef POLYARM_KDL
    add("kdl_lma_restarts", kdl_lma_restarts);
    add("kdl_lma_track", kdl_lma_track);
#endif
  }
  return true;
}();

}  // namespace
