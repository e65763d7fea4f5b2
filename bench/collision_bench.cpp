/// What does a collision check cost, and how long does planning take?
///
/// collision_bench [checks] [edges] [plans] [missed]: all without words. QUERIES=40 in the environment: so
/// many queries of each world (100). Prints, for a Panda and a UR5e of the catalogue in three worlds
/// (tests/planning/worlds.hpp):
///   checks  processor time per random state, in batches and one by one, for each instruction set; FCL beside
///   it edges   a free edge of 32 states, sampled and proven plans   a way between random free states whose
///   straight line is blocked; p50, p90, p99, max in us; then corners
///           and jerk-limited timing; success over seeds
///   missed  states in contact by exact shapes (and by FCL) that spheres call free: must be 0; false alarms
///
/// What it cannot show: other robots, meshes (the catalogue's links are capsules), and a machine without
/// other load. Times are processor time of this thread; the best of several rounds where one number is
/// printed.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/collision/check_data.hpp"
#include "polyarm/collision/checker.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "polyarm/planning/planner.hpp"
#include "polyarm/planning/pose_goals.hpp"
#include "polyarm/timing/timing.hpp"
#include "tests/planning/worlds.hpp"

#ifdef POLYARM_FCL
#include <fcl/fcl.h>
#endif

namespace polyarm {
namespace {

using collision::Checker;
using collision::CheckerOptions;
using collision::EdgeVerdict;
using collision::Probe;
using collision::RobotBody;
using collision::World;
using kinematics::Chain;
using kinematics::InstructionSet;
using kinematics::Random;
using planning::JointState;

double now_us() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) * 1e6 + double(t.tv_nsec) * 1e-3;
}

/// The best of `rounds` runs, us.
template <class Run>
double best_us(int rounds, const Run& run) {
  double best = 1e30;
  for (int i = 0; i < rounds; ++i) {
    const double from = now_us();
    run();
    best = std::min(best, now_us() - from);
  }
  return best;
}

struct Arm {
  explicit Arm(const std::string& robot)
      : name(robot),
        model(description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(robot)),
        chain(model, model.tool_link()),
        body(std::make_shared<const RobotBody>(model)) {}
  JointState draw(Random& random) const {
    JointState q;
    for (std::size_t j = 0; j < chain.joints(); ++j) q.push_back(random_value(chain, j, random));
    return q;
  }
  std::string name;
  description::RobotModel model;
  Chain chain;
  std::shared_ptr<const RobotBody> body;
};

struct Place {
  const char* name;
  World world;
};
std::vector<Place> places() {
  return {{"table", planning::table_world()},
          {"cage", planning::cage_world()},
          {"shelf", planning::shelf_world()}};
}

constexpr InstructionSet kSets[] = {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512};

// --- FCL: the same shapes
// ---------------------------------------------------------------------------------------

#ifdef POLYARM_FCL
using Transform = fcl::Transform3d;
Transform transform_of(const Pose& pose) {
  Transform out = Transform::Identity();
  const Quaternion& r = pose.rotation;
  out.linear() = Eigen::Quaterniond(r.w, r.x, r.y, r.z).toRotationMatrix();
  out.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return out;
}

/// Every link against the world through a dynamic AABB tree, and the pairs of links that the checker has.
class Fcl {
 public:
  Fcl(const Arm& arm, const World& world) : arm_(arm), poses_(arm.model.links.size()) {
    for (const collision::LinkBody& link : arm.body->links()) {
      links_.emplace_back();
      for (const description::Shape& shape : arm.model.links[std::size_t(link.link)].collisions)
        links_.back().push_back({std::make_unique<fcl::CollisionObjectd>(geometry(shape)), shape.pose});
    }
    for (const collision::Obstacle& o : world.obstacles()) {
      if (o.is_half_space) continue;
      description::Shape shape;
      shape.kind = o.kind;
      shape.size = 2.0 * o.half;
      shape.radius = o.kind == description::ShapeKind::cylinder ? o.body.disc : o.body.radius;
      if (o.body.points.size() == 2) shape.length = norm(o.body.points[1] - o.body.points[0]);
      world_.push_back(std::make_unique<fcl::CollisionObjectd>(geometry(shape), transform_of(o.pose)));
      tree_.registerObject(world_.back().get());
    }
    tree_.setup();
  }
  bool touches(const JointState& q) {
    arm_.chain.link_poses(q, poses_);
    for (std::size_t i = 0; i < links_.size(); ++i)
      for (auto& [object, pose] : links_[i]) {
        object->setTransform(transform_of(poses_[std::size_t(arm_.body->links()[i].link)] * pose));
        object->computeAABB();
      }
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (arm_.body->links()[i].frame < 0) continue;
      for (auto& [object, pose] : links_[i]) {
        bool hit = false;
        tree_.collide(object.get(), &hit, [](fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* out) {
          *static_cast<bool*>(out) = collide(*a, *b);
          return *static_cast<bool*>(out);
        });
        if (hit) return true;
      }
    }
    for (const collision::LinkPairBody& pair : arm_.body->pairs())
      for (auto& [a, pose_a] : links_[pair.first])
        for (auto& [b, pose_b] : links_[pair.second])
          if (a->getAABB().overlap(b->getAABB()) && collide(*a, *b)) return true;
    return false;
  }

 private:
  static bool collide(const fcl::CollisionObjectd& a, const fcl::CollisionObjectd& b) {
    fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    return fcl::collide(&a, &b, request, result) > 0;
  }
  static std::shared_ptr<fcl::CollisionGeometryd> geometry(const description::Shape& shape) {
    switch (shape.kind) {
      case description::ShapeKind::box:
        return std::make_shared<fcl::Boxd>(shape.size.x, shape.size.y, shape.size.z);
      case description::ShapeKind::sphere:
        return std::make_shared<fcl::Sphered>(shape.radius);
      case description::ShapeKind::capsule:
        return std::make_shared<fcl::Capsuled>(shape.radius, shape.length);
      default:
        return std::make_shared<fcl::Cylinderd>(shape.radius, shape.length);
    }
  }
  const Arm& arm_;
  std::vector<Pose> poses_;
  std::vector<std::vector<std::pair<std::unique_ptr<fcl::CollisionObjectd>, Pose>>> links_;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> world_;
  fcl::DynamicAABBTreeCollisionManagerd tree_;
};
#endif

// --- checks
// -----------------------------------------------------------------------------------------------------

void bench_checks(const Arm& arm) {
  constexpr std::size_t kStates = 4096;
  Random random(1);
  std::vector<double> flat;
  std::vector<JointState> states;
  for (std::size_t i = 0; i < kStates; ++i) {
    states.push_back(arm.draw(random));
    flat.insert(flat.end(), states.back().begin(), states.back().end());
  }
  for (const Place& place : places()) {
    std::vector<std::uint8_t> out(kStates);
    for (const InstructionSet set : kSets) {
      if (kinematics::supported(set) != set) continue;
      CheckerOptions options;
      options.instructions = set;
      const Checker checker(arm.body, place.world, options);
      Probe probe(checker);
      std::vector<double> free_states;
      std::vector<std::uint8_t> verdict(1);
      const double batch = best_us(15, [&] { probe.touches(flat, out); });
      for (std::size_t i = 0; i < kStates; ++i)
        if (!out[i]) free_states.insert(free_states.end(), states[i].begin(), states[i].end());
      std::vector<std::uint8_t> none(free_states.size() / arm.chain.joints());
      const double free = best_us(15, [&] { probe.touches(free_states, none); });
      std::size_t touching = 0;
      const double single = best_us(5, [&] {
        for (const JointState& q : states) touching += probe.touches(q);
      });
      std::printf(
          "  %-6s %-9s batch %6.1f ns/state, free ones only %6.1f, one by one %7.1f (%.0f %% touch)\n",
          place.name, name(set), 1000 * batch / kStates, none.empty() ? 0 : 1000 * free / double(none.size()),
          1000 * single / kStates, 100.0 * double(touching) / (5 * kStates));
    }
    const Checker checker(arm.body, place.world);
    Probe probe(checker);
    std::size_t touching = 0;
    const double exact = best_us(3, [&] {
      for (std::size_t i = 0; i < 500; ++i) touching += probe.touches_exactly(states[i]);
    });
    const double nearest = best_us(3, [&] {
      for (std::size_t i = 0; i < 500; ++i) touching += probe.nearest(states[i]).distance > 0;
    });
    std::printf("  %-6s exact verdict %.2f us, nearest pair %.2f us a state\n", place.name, exact / 500,
                nearest / 500);
#ifdef POLYARM_FCL
    Fcl fcl(arm, place.world);
    const double peer = best_us(3, [&] {
      for (std::size_t i = 0; i < 1000; ++i) touching += fcl.touches(states[i]);
    });
    std::printf("  %-6s FCL, the same shapes: %.2f us a state\n", place.name, peer / 1000);
#endif
  }
}

// --- edges
// ------------------------------------------------------------------------------------------------------

void bench_edges(const Arm& arm) {
  for (const Place& place : places())
    for (const InstructionSet set : kSets) {
      if (kinematics::supported(set) != set) continue;
      CheckerOptions options;
      options.instructions = set;
      const Checker checker(arm.body, place.world, options);
      Probe probe(checker);
      Random random(2);
      std::vector<std::pair<JointState, JointState>> edges;
      int unproven = 0;
      while (edges.size() < 300) {
        JointState from = arm.draw(random), to = arm.draw(random);
        double way = 0;
        for (std::size_t j = 0; j < to.size(); ++j) way += (to[j] - from[j]) * (to[j] - from[j]);
        for (std::size_t j = 0; j < to.size(); ++j) to[j] = from[j] + (to[j] - from[j]) / std::sqrt(way);
        if (!probe.sampled_edge(from, to, 32)) continue;
        unproven += probe.edge(from, to).verdict != EdgeVerdict::free;
        edges.push_back({from, to});
      }
      std::size_t free = 0;
      double calls = 0;
      const double sampled = best_us(15, [&] {
        for (const auto& [from, to] : edges) free += probe.sampled_edge(from, to, 32);
      });
      const double proven = best_us(15, [&] {
        calls = 0;
        for (const auto& [from, to] : edges) calls += probe.edge(from, to).calls;
      });
      std::printf(
          "  %-6s %-9s free edge of 1 rad: 32 samples %5.2f us, proven %6.2f us (%.1f calls of %zu states; "
          "%d of 300 "
          "not proven)\n",
          place.name, name(set), sampled / 300, proven / 300, calls / 300, checker.width(), unproven);
    }
}

// --- plans
// ------------------------------------------------------------------------------------------------------

double at(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, std::size_t(part * double(values.size())))];
}
void print_row(const char* what, const std::vector<double>& us) {
  double sum = 0;
  for (const double v : us) sum += v;
  std::printf("    %-28s p50 %8.0f  p90 %8.0f  p99 %8.0f  max %9.0f  mean %8.0f us\n", what, at(us, 0.5),
              at(us, 0.9), at(us, 0.99), at(us, 1), us.empty() ? 0 : sum / double(us.size()));
}

void bench_plans(const Arm& arm, int queries) {
  constexpr std::uint64_t kSeeds = 5;
  for (const Place& place : places()) {
    const Checker checker(arm.body, place.world);
    Probe probe(checker);
    Random random(3);
    std::vector<double> searched, planned, timed;
    int found = 0, all = 0, exact = 0, timed_out = 0;
    double length = 0, length_found = 0;
    const auto draw = [&] {
      for (;;)
        if (JointState q = arm.draw(random); !probe.touches(q)) return q;
    };
    std::vector<trajectory::MotionLimits> limits;
    for (const int j : arm.model.actuated) {
      const auto& l = arm.model.joints[std::size_t(j)].limits;
      limits.push_back(trajectory::MotionLimits::symmetric(
          l.velocity.value_or(2), l.acceleration.value_or(10), l.jerk.value_or(100)));
    }
    for (int i = 0; i < queries; ++i) {
      planning::PlanQuery query{draw(), {draw()}, arm.chain.lower(), arm.chain.upper()};
      query.goals = planning::with_turns(arm.chain, std::move(query.goals), query.start);
      if (std::any_of(query.goals.begin(), query.goals.end(), [&](const JointState& goal) {
            return probe.edge(query.start, goal).verdict == EdgeVerdict::free;
          })) {
        --i;
        continue;
      }
      int solved = 0;
      for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        planning::PlanOptions options, raw;
        options.seed = raw.seed = seed;
        raw.shortcuts = 0;
        options.most_samples = raw.most_samples = 5000;
        double from = now_us();
        planning::plan(probe, query, raw);
        searched.push_back(now_us() - from);
        from = now_us();
        const planning::Plan made = planning::plan(probe, query, options);
        planned.push_back(now_us() - from);
        ++all;
        if (made.outcome != planning::PlanOutcome::found) {
          searched.pop_back(), planned.pop_back();
          continue;
        }
        ++found, ++solved;
        exact += made.exact;
        length += made.length, length_found += made.length_found;
        from = now_us();
        const std::vector<double> radii = planning::corner_radii(probe, made.waypoints, made.exact);
        std::vector<paths::JointWaypoint> points;
        for (std::size_t k = 0; k < radii.size(); ++k) points.push_back({made.waypoints[k], radii[k], {}});
        paths::PathSections path = paths::joint_lines(points);
        for (auto& section : path.sections) timing::timed(std::move(section), limits);
        timed.push_back(planned.back() + now_us() - from);
      }
      if (solved == 0) {
        ++timed_out;
        std::printf(
            "    not solved with any seed: query %d, clearance %.1f mm at the start, %.1f mm at the goal\n",
            i, 1000 * probe.nearest(query.start).distance, 1000 * probe.nearest(query.goals[0]).distance);
      }
    }
    std::printf(
        "  %-6s %d of %d found (%d queries with no seed), %d with exact shapes; length %.2f, before "
        "shortcuts "
        "%.2f\n",
        place.name, found, all, timed_out, exact, length / std::max(found, 1),
        length_found / std::max(found, 1));
    print_row("search", searched);
    print_row("search and shortcuts", planned);
    print_row("and corners, jerk-limited", timed);
  }
}

// --- missed contacts
// --------------------------------------------------------------------------------------------

void count_missed(const Arm& arm, std::size_t states) {
  for (const Place& place : places()) {
    const Checker checker(arm.body, place.world);
    Probe probe(checker);
    Random random(4);
    std::size_t contacts = 0, missed = 0, alarms = 0;
#ifdef POLYARM_FCL
    Fcl fcl(arm, place.world);
    std::size_t fcl_contacts = 0, fcl_missed = 0, fcl_differs = 0;
#endif
    for (std::size_t i = 0; i < states; ++i) {
      const JointState q = arm.draw(random);
      const bool spheres = probe.touches(q), exact = probe.touches_exactly(q);
      contacts += exact;
      missed += exact && !spheres;
      alarms += spheres && !exact;
#ifdef POLYARM_FCL
      const bool peer = fcl.touches(q);
      fcl_contacts += peer;
      fcl_missed += peer && !spheres;
      fcl_differs += peer != exact;
#endif
    }
    std::printf(
        "  %-6s %zu states, %zu in contact, %zu missed by spheres, %zu false alarms (%.2f %% of free "
        "states)\n",
        place.name, states, contacts, missed, alarms, 100.0 * double(alarms) / double(states - contacts));
#ifdef POLYARM_FCL
    std::printf("  %-6s FCL: %zu in contact, %zu missed by spheres, %zu unlike the exact verdict\n",
                place.name, fcl_contacts, fcl_missed, fcl_differs);
#endif
  }
}

}  // namespace

int run(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const auto asked = [&](const char* word) {
    for (int i = 1; i < argc; ++i)
      if (std::strcmp(argv[i], word) == 0) return true;
    return argc == 1;
  };
  for (const char* name : {"franka/fer_panda", "universal_robots/ur5e"}) {
    const double from = now_us();
    const Arm arm(name);
    std::size_t spheres = 0;
    double excess = 0;
    for (const collision::LinkBody& link : arm.body->links())
      spheres += link.spheres.size(), excess = std::max(excess, link.excess);
    std::printf("%s: %zu links with %zu spheres, at most %.1f mm outside, %zu pairs; compiled in %.1f ms\n",
                name, arm.body->links().size(), spheres, 1000 * excess, arm.body->pairs().size(),
                (now_us() - from) / 1000);
    if (asked("checks")) bench_checks(arm);
    if (asked("edges")) bench_edges(arm);
    if (asked("plans")) bench_plans(arm, std::getenv("QUERIES") ? std::atoi(std::getenv("QUERIES")) : 100);
    if (asked("missed")) count_missed(arm, 100'000);
  }
  return 0;
}

}  // namespace polyarm

int main(int argc, char** argv) {
  return polyarm::run(argc, argv);
}
