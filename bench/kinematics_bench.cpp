// What forward kinematics, the Jacobian and dynamics cost for arms of the catalogue: one state after the
// other, and 128 states in a call. One thread. Each figure is processor time per state of 61 rounds over
// 1,024 random states, run once before the clock starts; everything takes its turn in each round, so that
// what else the machine does falls on all alike. least, p50 and p99 of the rounds: on a machine that others
// use, the least is the nearest to what the code costs. `dependent`: each call waits for the result of the
// one before. Orocos KDL is measured in the same rounds where its library is installed, and all results are
// compared with its before any clock starts (and the dynamics with themselves). Instruction sets: all that
// the processor has, or the one that POLYARM_INSTRUCTIONS names (portable, avx2, avx512). It cannot show what
// cold caches cost.
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/dynamics.hpp"
#include "polyarm/kinematics/random.hpp"

#ifdef POLYARM_KDL
#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainfdsolver_recursive_newton_euler.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#endif

namespace {

using namespace polyarm;
using namespace polyarm::kinematics;
constexpr std::size_t kStates = 1024, kRounds = 61, kCall = 128;
constexpr const char* kArms[] = {"universal_robots/ur5e", "franka/fer_panda", "abb/irb_2400_10"};
constexpr const char* kFigures[] = {"forward kinematics", "the same, dependent", "forward + Jacobian",
                                    "inverse dynamics",   "mass matrix",         "forward dynamics"};
constexpr std::size_t kFigureCount = std::size(kFigures);

/// Random states of an arm, state after state, and joint after joint for each kCall of them.
struct States {
  std::size_t n;
  std::vector<double> rows, columns;
  States(const Chain& chain, std::uint64_t seed, bool within_limits) : n(chain.joints()) {
    Random random(seed);
    rows.resize(n * kStates), columns.resize(n * kStates);
    for (std::size_t s = 0; s < kStates; ++s)
      for (std::size_t i = 0; i < n; ++i)
        rows[s * n + i] = columns[s / kCall * kCall * n + i * kCall + s % kCall] =
            within_limits ? random_value(chain, i, random) : random.between(-2, 2);
  }
  std::span<const double> at(std::size_t s) const { return {rows.data() + s * n, n}; }
  std::span<const double> call(std::size_t first) const { return {columns.data() + first * n, kCall * n}; }
};

/// One column of the table: what does each figure for all states; empty where it does not.
struct Contestant {
  std::string name;
  std::array<std::function<void()>, kFigureCount> run;
  std::array<std::vector<double>, kFigureCount> ns;
};

struct Arm {
  description::RobotModel model;
  Chain chain;
  Tree tree;
  States q, v, a;
  explicit Arm(const std::string& name)
      : model(description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name)),
        chain(model, model.tool_link()),
        tree(model),
        q(chain, 1, true),
        v(chain, 2, false),
        a(chain, 3, false) {}
};

/// The chain and dynamics of one instruction set, and where their results go.
struct Ours {
  const Arm& arm;
  ScrewChain chain;
  Dynamics dynamics;
  std::vector<Pose> poses;
  std::vector<double> J, values;
  double depends = 0;
  Ours(const Arm& of, InstructionSet set) : arm(of), chain(screws(of.chain, set)), dynamics(of.tree, set) {
    const std::size_t n = chain.joints();
    poses.resize(kStates), J.resize(6 * n * kCall), values.resize(n * n * kStates);
  }
  static ScrewChain screws(const Chain& chain, InstructionSet set) {
    std::vector<ScrewAxis> axes;
    for (const auto& axis : chain.axes())
      axes.push_back({axis.joint, axis.slides, axis.ratio, axis.direction, axis.point});
    const std::vector<double> zero(chain.joints(), 0.0);
    return {axes, chain.joints(), chain.forward(zero), chain.base().position, set};
  }
  std::span<Pose> poses_of_call() { return std::span(poses).first(kCall); }
  std::span<double> result(std::size_t s, std::size_t size) { return {values.data() + s * size, size}; }

  void forward() {
    for (std::size_t s = 0; s < kStates; ++s) poses[s] = chain.forward(arm.q.at(s));
  }
  void dependent() {
    std::array<double, Chain::kMaxJoints> q{};
    for (std::size_t s = 0; s < kStates; ++s) {
      std::copy(arm.q.at(s).begin(), arm.q.at(s).end(), q.begin());
      q[0] += 1e-300 * depends;
      depends = chain.forward(std::span(q).first(arm.q.n)).rotation.w;
    }
  }
  void jacobian() {
    for (std::size_t s = 0; s < kStates; ++s) poses[s] = chain.jacobian(arm.q.at(s), J);
  }
  void inverse() {
    for (std::size_t s = 0; s < kStates; ++s)
      dynamics.inverse(arm.q.at(s), arm.v.at(s), arm.a.at(s), result(s, arm.q.n));
  }
  void mass() {
    for (std::size_t s = 0; s < kStates; ++s) dynamics.mass_matrix(arm.q.at(s), result(s, arm.q.n * arm.q.n));
  }
  void accelerations() {
    for (std::size_t s = 0; s < kStates; ++s)
      (void)dynamics.forward(arm.q.at(s), arm.v.at(s), arm.a.at(s), result(s, arm.q.n));
  }
};

void add_ours(Ours& ours, const char* set, std::vector<Contestant>& out) {
  constexpr auto kLayout = BatchLayout::joint_after_joint;
  const Arm& arm = ours.arm;
  out.push_back({set,
                 {[&] { ours.forward(); }, [&] { ours.dependent(); }, [&] { ours.jacobian(); },
                  [&] { ours.inverse(); }, [&] { ours.mass(); }, [&] { ours.accelerations(); }},
                 {}});
  const auto calls = [](const auto& one) {
    return [one] {
      for (std::size_t first = 0; first < kStates; first += kCall) one(first);
    };
  };
  out.push_back(
      {std::string(set) + ", batch",
       {calls([&](std::size_t s) { ours.chain.forward_batch(arm.q.call(s), kLayout, ours.poses_of_call()); }),
        {},
        calls([&](std::size_t s) {
          ours.chain.jacobian_batch(arm.q.call(s), kLayout, ours.J, ours.poses_of_call());
        }),
        calls([&](std::size_t s) {
          ours.dynamics.inverse_batch(kLayout, kCall, arm.q.call(s), arm.v.call(s), arm.a.call(s),
                                      ours.values);
        }),
        calls([&](std::size_t s) {
          ours.dynamics.mass_matrix_batch(kLayout, kCall, arm.q.call(s), ours.values);
        }),
        calls([&](std::size_t s) {
          (void)ours.dynamics.forward_batch(kLayout, kCall, arm.q.call(s), arm.v.call(s), arm.a.call(s),
                                            ours.values);
        })},
       {}});
}

/// The largest difference of forward(inverse(a)) from a.
double own_error(Ours& ours) {
  const Arm& arm = ours.arm;
  std::vector<double> tau(arm.q.n), back(arm.q.n);
  double worst = 0;
  for (std::size_t s = 0; s < kStates; ++s) {
    ours.dynamics.inverse(arm.q.at(s), arm.v.at(s), arm.a.at(s), tau);
    if (!ours.dynamics.forward(arm.q.at(s), arm.v.at(s), tau, back)) return INFINITY;
    for (std::size_t i = 0; i < arm.q.n; ++i) worst = std::max(worst, std::abs(back[i] - arm.a.at(s)[i]));
  }
  return worst;
}

#ifdef POLYARM_KDL
KDL::Vector kdl(const Vec3& v) {
  return {v.x, v.y, v.z};
}
KDL::Frame kdl(const Pose& p) {
  const Quaternion& r = p.rotation;
  return {KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w), kdl(p.position)};
}
KDL::RigidBodyInertia kdl(const std::optional<description::Inertial>& body) {
  if (!body) return KDL::RigidBodyInertia::Zero();
  const auto& i = body->inertia;
  return KDL::RigidBodyInertia(body->mass, kdl(body->center),
                               KDL::RotationalInertia(i[0], i[3], i[5], i[1], i[2], i[4]));
}

/// The same links and joints, from root to tool.
KDL::Chain kdl_chain(const description::RobotModel& model) {
  std::vector<int> path;
  for (int link = model.tool_link(); link != model.root;) {
    path.push_back(model.links[static_cast<std::size_t>(link)].parent_joint);
    link = model.joints[static_cast<std::size_t>(path.back())].parent_link;
  }
  KDL::Chain out;
  for (auto it = path.rbegin(); it != path.rend(); ++it) {
    const auto& joint = model.joints[static_cast<std::size_t>(*it)];
    const KDL::Frame origin = kdl(joint.origin);
    const KDL::Joint moves = joint.moves()
                                 ? KDL::Joint(origin.p, origin.M * kdl(joint.axis), KDL::Joint::RotAxis)
                                 : KDL::Joint(KDL::Joint::Fixed);
    out.addSegment(
        KDL::Segment(moves, origin, kdl(model.links[static_cast<std::size_t>(joint.child_link)].inertial)));
  }
  return out;
}

struct Peer {
  const Arm& arm;
  KDL::Chain chain;
  KDL::ChainFkSolverPos_recursive fk;
  KDL::ChainJntToJacSolver jac;
  KDL::ChainIdSolver_RNE id;
  KDL::ChainDynParam dyn;
  KDL::ChainFdSolver_RNE fd;
  std::vector<KDL::JntArray> q, v, a;
  KDL::JntArray out;
  KDL::Jacobian J;
  KDL::JntSpaceInertiaMatrix M;
  KDL::Frame pose;
  std::vector<KDL::Wrench> wrenches;
  explicit Peer(const Arm& of)
      : arm(of),
        chain(kdl_chain(of.model)),
        fk(chain),
        jac(chain),
        id(chain, kdl(of.tree.gravity())),
        dyn(chain, kdl(of.tree.gravity())),
        fd(chain, kdl(of.tree.gravity())),
        q(copies(of.q)),
        v(copies(of.v)),
        a(copies(of.a)),
        out(chain.getNrOfJoints()),
        J(chain.getNrOfJoints()),
        M(chain.getNrOfJoints()),
        wrenches(chain.getNrOfSegments(), KDL::Wrench::Zero()) {}
  static std::vector<KDL::JntArray> copies(const States& states) {
    std::vector<KDL::JntArray> out(kStates, KDL::JntArray(static_cast<unsigned>(states.n)));
    for (std::size_t s = 0; s < kStates; ++s)
      for (unsigned i = 0; i < states.n; ++i) out[s](i) = states.at(s)[i];
    return out;
  }
  /// The figure for one state.
  void one(std::size_t figure, std::size_t s) {
    switch (figure) {
      case 2:
        fk.JntToCart(q[s], pose);
        jac.JntToJac(q[s], J);
        return;
      case 3:
        id.CartToJnt(q[s], v[s], a[s], wrenches, out);
        return;
      case 4:
        dyn.JntToMass(q[s], M);
        return;
      case 5:
        fd.CartToJnt(q[s], v[s], a[s], wrenches, out);
        return;
      default:
        fk.JntToCart(q[s], pose);
        return;
    }
  }
  Contestant contestant() {
    Contestant result{"Orocos KDL", {}, {}};
    for (const std::size_t figure : {0u, 2u, 3u, 4u, 5u})
      result.run[figure] = [this, figure] {
        for (std::size_t s = 0; s < kStates; ++s) one(figure, s);
      };
    return result;
  }
};

/// The largest differences of our results from KDL's.
void compare(Ours& ours, Peer& peer, const char* set) {
  const Arm& arm = ours.arm;
  const std::size_t n = arm.q.n;
  std::vector<double> J(6 * n), tau(n), M(n * n), accelerations(n);
  double position = 0, jacobian = 0, torque = 0, mass = 0, acceleration = 0;
  const auto differs = [](double& worst, double x, double y) { worst = std::max(worst, std::abs(x - y)); };
  for (std::size_t s = 0; s < kStates; ++s) {
    const Pose pose = ours.chain.jacobian(arm.q.at(s), J);
    peer.one(2, s);
    position =
        std::max(position, norm(pose.position - Vec3{peer.pose.p.x(), peer.pose.p.y(), peer.pose.p.z()}));
    for (unsigned r = 0; r < 6; ++r)
      for (unsigned i = 0; i < n; ++i) differs(jacobian, J[r * n + i], peer.J(r, i));
    ours.dynamics.inverse(arm.q.at(s), arm.v.at(s), arm.a.at(s), tau);
    peer.one(3, s);
    for (unsigned i = 0; i < n; ++i) differs(torque, tau[i], peer.out(i));
    ours.dynamics.mass_matrix(arm.q.at(s), M);
    peer.one(4, s);
    for (unsigned r = 0; r < n; ++r)
      for (unsigned i = 0; i < n; ++i) differs(mass, M[r * n + i], peer.M(r, i));
    (void)ours.dynamics.forward(arm.q.at(s), arm.v.at(s), arm.a.at(s), accelerations);
    peer.one(5, s);
    for (unsigned i = 0; i < n; ++i)
      acceleration =
          std::max(acceleration, std::abs(accelerations[i] - peer.out(i)) / (1 + std::abs(peer.out(i))));
  }
  std::printf(
      "%s against KDL, largest difference: position %.1e m, Jacobian %.1e, torque %.1e N m, mass %.1e, "
      "acceleration %.1e of itself\n",
      set, position, jacobian, torque, mass, acceleration);
}
#endif

/// Time this thread has spent on a processor.
double processor_ns() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

void race(std::vector<Contestant>& all) {
  for (std::size_t round = 0; round < kRounds; ++round)
    for (Contestant& one : all)
      for (std::size_t f = 0; f < kFigureCount; ++f) {
        if (!one.run[f]) continue;
        one.run[f]();
        const double begin = processor_ns();
        one.run[f]();
        one.ns[f].push_back((processor_ns() - begin) / kStates);
      }
}

double percentile(std::vector<double>& ns, std::size_t percent) {
  std::sort(ns.begin(), ns.end());
  return ns[(ns.size() - 1) * percent / 100];
}

void print(std::vector<Contestant>& all) {
  std::printf("\n| ns per state: least / p50 / p99 |");
  for (const Contestant& one : all) std::printf(" %s |", one.name.c_str());
  std::printf("\n|---|");
  for (std::size_t i = 0; i < all.size(); ++i) std::printf("---|");
  for (std::size_t f = 0; f < kFigureCount; ++f) {
    std::printf("\n| %s |", kFigures[f]);
    for (Contestant& one : all)
      one.ns[f].empty() ? std::printf(" |")
                        : std::printf(" %.1f / %.1f / %.1f |", percentile(one.ns[f], 0),
                                      percentile(one.ns[f], 50), percentile(one.ns[f], 99));
  }
  std::printf("\n");
  Contestant& peer = all.back();
  if (peer.name != "Orocos KDL") return;
  for (std::size_t f = 0; f < kFigureCount; ++f) {
    if (peer.ns[f].empty()) continue;
    std::printf("%s: %s takes 1/%.1f of KDL's least time, its batch 1/%.1f\n", kFigures[f],
                all[0].name.c_str(), percentile(peer.ns[f], 0) / percentile(all[0].ns[f], 0),
                percentile(peer.ns[f], 0) / percentile(all[1].ns[f], 0));
  }
}

std::vector<InstructionSet> sets() {
  const char* wanted = std::getenv("POLYARM_INSTRUCTIONS");
  std::vector<InstructionSet> out;
  for (const auto set : {InstructionSet::avx512, InstructionSet::avx2, InstructionSet::portable})
    if (supported(set) == set && (!wanted || std::string(wanted) == name(set))) out.push_back(set);
  return out;
}

void measure(const std::string& name) {
  const Arm arm(name);
  std::printf("\n## %s, %zu axes\n\n", name.c_str(), arm.chain.joints());
  std::vector<Contestant> all;
  std::vector<std::unique_ptr<Ours>> ours;
  for (const InstructionSet set : sets()) {
    ours.push_back(std::make_unique<Ours>(arm, set));
    add_ours(*ours.back(), kinematics::name(set), all);
    std::printf("%s: forward of inverse dynamics differs by at most %.1e rad/s^2\n", kinematics::name(set),
                own_error(*ours.back()));
  }
#ifdef POLYARM_KDL
  Peer peer(arm);
  for (const auto& one : ours) compare(*one, peer, kinematics::name(one->dynamics.instructions()));
  all.push_back(peer.contestant());
#else
  std::printf("Orocos KDL is not installed: not measured here\n");
#endif
  race(all);
  print(all);
}

}  // namespace

int main() {
  if (sets().empty()) {
    std::fprintf(stderr, "POLYARM_INSTRUCTIONS names none that this processor has: portable, avx2, avx512\n");
    return 2;
  }
  for (const char* arm : kArms) measure(arm);
}
