#include "polyarm/surroundings/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "polyarm/collision/separation.hpp"
#include "polyarm/surroundings/sweep_bodies.hpp"

namespace polyarm::surroundings {

using collision::Ball;
using collision::ConvexBody;
using collision::RobotBody;

namespace {

using Body = SweptBody;
using Kind = BodyKind;

constexpr double kNever = -std::numeric_limits<double>::infinity();
constexpr double kBallsSuffice = 0.01;  // m beyond the clearance: bounding balls decide
constexpr int kDeepest = 20;            // halvings of the way between two moments

struct Pair {
  std::size_t a = 0, b = 0;
  std::vector<double> lever;  ///< of one robot: by variable
  bool active = false, fresh = true;
  double slack = kNever;  ///< a lower bound of the distance now
  bool open = false, excused = false;
  Approach approach;
};

/// Where the frames of all robots are.
struct Placed {
  Moment moment;
  std::vector<std::vector<Pose>> frames;  ///< of each robot, in the world
};

Pose between(const Pose& a, const Pose& b, double s) {
  if (a == b) return a;
  const Vec3 turn = to_rotation_vector(inverse(a.rotation) * b.rotation);
  const double angle = norm(turn);
  const Quaternion rotation =
      angle > 1e-12 ? a.rotation * from_axis_angle((1 / angle) * turn, s * angle) : a.rotation;
  return {a.position + s * (b.position - a.position), normalized(rotation)};
}

/// How far a point within `radius` of the origin of a frame moves.
double motion_of(const Pose& a, const Pose& b, double radius) {
  if (a == b) return 0;
  return norm(b.position - a.position) + angle_between(a.rotation, b.rotation) * radius;
}

}  // namespace

struct Sweep::Work : SweepBodies {
  Work(std::vector<Robot> robots, const description::Scene& scene, double clearance)
      : SweepBodies(std::move(robots), scene), clearance_(clearance) {
    add_pairs();
    states_.resize(scene.parts.size());
  }

  void add(const Moment& moment, double time, const std::function<std::uint64_t(std::size_t)>& mark_of) {
    first_ = before_.moment.robots.empty();
    time_before_ = first_ ? time : time_;
    time_ = time;
    Placed now{moment, {}};
    place(now);
    take_part_changes(now);
    find_motion(now);
    for (Pair& pair : pairs_)
      if (pair.active) follow(pair, now, mark_of);
    before_ = std::move(now);
  }

  void jump() {
    for (Pair& pair : pairs_) {
      pair.open = false;
      pair.fresh = true;
      pair.slack = kNever;
    }
  }

  void finish(bool holding_on) {
    for (Pair& pair : pairs_) {
      const bool of_part = bodies_[pair.a].part >= 0 || bodies_[pair.b].part >= 0;
      close(pair, holding_on && of_part);
    }
  }

  std::vector<Approach> approaches_;
  std::uint64_t measured_ = 0;

 private:
  void add_pairs() {
    for (std::size_t r = 0; r < models_.size(); ++r)
      for (const collision::LinkPairBody& pair : models_[r]->pairs()) {
        Pair own;
        own.a = first_body_[r] + pair.first, own.b = first_body_[r] + pair.second;
        own.lever = pair.lever;
        own.active = true;
        pairs_.push_back(std::move(own));
      }
    for (std::size_t a = 0; a < bodies_.size(); ++a)
      for (std::size_t b = a + 1; b < bodies_.size(); ++b) {
        const bool part = bodies_[a].part >= 0 || bodies_[b].part >= 0;
        if (!part && !counts(bodies_[a], bodies_[b])) continue;
        Pair pair;
        pair.a = a, pair.b = b;
        if (bodies_[b].part >= 0 && !bodies_[a].of_robot()) std::swap(pair.a, pair.b);
        pair.active = !part;
        pairs_.push_back(std::move(pair));
      }
  }

  // --- parts ----------------------------------------------------------------------------------------------

  void take_part_changes(const Placed& now) {
    for (std::size_t p = 0; p < states_.size(); ++p) {
      PartMode mode;
      if (p < now.moment.parts.size()) {
        mode.in_world = now.moment.parts[p].in_world;
        mode.held_by = now.moment.parts[p].held_by;
        if (mode.held_by >= static_cast<int>(robots_.size())) mode.held_by = -1;
      }
      if (!first_ && mode == states_[p]) continue;
      const bool taken = mode.held_by != states_[p].held_by;
      if (mode.held_by >= 0) {
        const auto r = static_cast<std::size_t>(mode.held_by);
        mode.in_hand = inverse(frame_pose(now, r, tool_frame_[r])) * now.moment.parts[p].pose;
      }
      states_[p] = mode;
      renew_pairs(static_cast<int>(p), taken);
    }
  }

  /// Pairs of a part that was taken, let go, brought or taken away.
  void renew_pairs(int part, bool taken) {
    for (Pair& pair : pairs_) {
      const Body &a = bodies_[pair.a], &b = bodies_[pair.b];
      if (a.part != part && b.part != part) continue;
      close(pair, taken);
      pair.active = counts(a, b, states_);
      pair.fresh = true;
      pair.excused = taken;
      pair.slack = kNever;
      pair.lever.clear();
      if (!pair.active) continue;
      const Body &held = a.part >= 0 ? a : b, &other = a.part >= 0 ? b : a;
      const PartMode& mode = states_[static_cast<std::size_t>(held.part)];
      if (mode.held_by < 0 || !other.of_robot() || other.robot != mode.held_by) continue;
      const auto r = static_cast<std::size_t>(mode.held_by);
      const std::vector<Ball> balls = balls_in_hand(held, mode.in_hand);
      pair.lever = models_[r]->pair_levers(tool_frame_[r], balls, other.frame, other.balls);
    }
    if (states_[static_cast<std::size_t>(part)].held_by >= 0) {
      const PartMode& mode = states_[static_cast<std::size_t>(part)];
      const auto r = static_cast<std::size_t>(mode.held_by);
      for (Body& body : bodies_)
        if (body.part == part)
          body.lever = models_[r]->levers_of(tool_frame_[r], balls_in_hand(body, mode.in_hand));
    }
  }

  // --- where it is and how far it goes --------------------------------------------------------------------

  static Pose frame_pose(const Placed& at, std::size_t robot, int frame) {
    return frame < 0 ? at.moment.robots[robot].base : at.frames[robot][static_cast<std::size_t>(frame)];
  }

  void place_robot(Placed& at, std::size_t r) const {
    std::vector<Pose>& frames = at.frames[r];
    frames.resize(models_[r]->frames().size());
    models_[r]->place(at.moment.robots[r].joints, frames);
    for (Pose& frame : frames) frame = at.moment.robots[r].base * frame;
  }
  void place(Placed& at) const {
    at.frames.resize(robots_.size());
    for (std::size_t r = 0; r < robots_.size(); ++r) place_robot(at, r);
  }

  Pose pose_of(const Body& body, const Placed& at) const {
    if (body.part >= 0) {
      const PartMode& mode = states_[static_cast<std::size_t>(body.part)];
      if (mode.held_by < 0) return at.moment.parts[static_cast<std::size_t>(body.part)].pose;
      const auto r = static_cast<std::size_t>(mode.held_by);
      return frame_pose(at, r, tool_frame_[r]) * mode.in_hand;
    }
    if (body.fixture >= 0)
      return surroundings::pose_of(scene_.fixtures[static_cast<std::size_t>(body.fixture)], scene_,
                                   at.moment);
    return body.robot >= 0 ? frame_pose(at, static_cast<std::size_t>(body.robot), body.frame) : Pose{};
  }

  void find_motion(const Placed& now) {
    joint_motion_.resize(robots_.size());
    body_motion_.assign(bodies_.size(), 0);
    if (first_) return;
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      const auto &a = before_.moment.robots[r].joints, &b = now.moment.robots[r].joints;
      joint_motion_[r].resize(a.size());
      for (std::size_t j = 0; j < a.size(); ++j) joint_motion_[r][j] = std::abs(b[j] - a[j]);
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i) body_motion_[i] = motion(bodies_[i], now);
  }

  static double sum(const std::vector<double>& lever, const std::vector<double>& joints) {
    double out = 0;
    for (std::size_t j = 0; j < lever.size() && j < joints.size(); ++j)
      if (joints[j] > 0) out += lever[j] * joints[j];
    return out;
  }

  double motion(const Body& body, const Placed& now) const {
    const double radius = norm(body.around.center) + body.around.radius;
    int robot = body.robot;
    if (body.part >= 0) {
      robot = states_[static_cast<std::size_t>(body.part)].held_by;
      const auto p = static_cast<std::size_t>(body.part);
      if (robot < 0)
        return p < now.moment.parts.size() && p < before_.moment.parts.size()
                   ? motion_of(before_.moment.parts[p].pose, now.moment.parts[p].pose, radius)
                   : 0;
    }
    if (robot < 0) return body.is_static ? 0 : motion_of(pose_of(body, before_), pose_of(body, now), radius);
    const auto r = static_cast<std::size_t>(robot);
    const Pose &base = before_.moment.robots[r].base, &after = now.moment.robots[r].base;
    double out = sum(body.lever, joint_motion_[r]);
    if (!(base == after))
      out += motion_of(
          base, after,
          norm(pose_of(body, before_) * body.around.center - base.position) + body.around.radius + out);
    return out;
  }

  // --- pairs ----------------------------------------------------------------------------------------------

  /// Links of one robot need no clearance: how near they are is how the robot is built.
  double wanted(const Pair& pair) const { return pair.lever.empty() ? clearance_ : 0; }

  double motion(const Pair& pair) const {
    if (pair.lever.empty()) return body_motion_[pair.a] + body_motion_[pair.b];
    const Body &a = bodies_[pair.a], &b = bodies_[pair.b];
    return sum(pair.lever, joint_motion_[static_cast<std::size_t>(a.of_robot() ? a.robot : b.robot)]);
  }

  struct Distance {
    double value = std::numeric_limits<double>::infinity();
    Vec3 point;
  };

  static Distance from_floor(const Body& body, const Pose& pose, double height) {
    Distance out;
    for (const ConvexBody& piece : body.pieces) {
      const Vec3 lowest = pose * piece.core_support(inverse(pose.rotation) * Vec3{0, 0, -1});
      const double distance = lowest.z - piece.radius - height;
      if (distance < out.value) out = {distance, {lowest.x, lowest.y, height}};
    }
    return out;
  }

  /// The exact distance, or the bound of bounding balls where that suffices.
  Distance distance(const Pair& pair, const Placed& at) {
    const Body &a = bodies_[pair.a], &b = bodies_[pair.b];
    const Pose pose_a = pose_of(a, at);
    if (b.kind == Kind::floor) return from_floor(a, pose_a, scene_.floor_height);
    const Pose pose_b = pose_of(b, at);
    const double rough =
        norm(pose_a * a.around.center - pose_b * b.around.center) - a.around.radius - b.around.radius;
    if (rough > clearance_ + kBallsSuffice) return {rough, {}};
    ++measured_;
    const Pose T_b_a = inverse(pose_b) * pose_a;
    Distance out;
    each_near(
        a, pose_a, b, pose_b, [&] { return out.value; },
        [&](std::size_t i, std::size_t k) { measure(a.pieces[i], T_b_a, b.pieces[k], pose_b, out); });
    return out;
  }

  static void measure(const ConvexBody& a, const Pose& T_b_a, const ConvexBody& b, const Pose& pose_b,
                      Distance& out) {
    const collision::Separation s = collision::separation(a, T_b_a, b);
    if (s.distance > 0) {
      if (s.lower < out.value) out = {s.lower, pose_b * (0.5 * (s.on_a + s.on_b))};
      return;
    }
    const collision::Depth depth = collision::overlap(a, T_b_a, b);
    if (-depth.depth >= out.value) return;
    const Vec3 deepest =
        T_b_a * a.core_support(inverse(T_b_a.rotation) * -depth.direction) - a.radius * depth.direction;
    out = {-depth.depth, pose_b * (deepest + (0.5 * depth.depth) * depth.direction)};
  }

  using MarkOf = std::function<std::uint64_t(std::size_t)>;

  void follow(Pair& pair, const Placed& now, const MarkOf& mark_of) {
    const double way = pair.fresh ? 0 : motion(pair), start = pair.slack;
    if (!pair.fresh && way <= 0) return;
    pair.slack -= way;
    if (pair.slack >= wanted(pair)) return;
    const Distance here = distance(pair, now);
    const bool fresh = std::exchange(pair.fresh, false);
    if (!fresh) search_between(pair, now, {0, start}, {1, here.value}, way, mark_of, 0);
    pair.slack = here.value;
    offer(pair, here, time_, mark_of);
  }

  struct Place {
    double s, distance;
  };

  /// Halves the way between two moments as long as something nearer than what is known could be on it.
  void search_between(Pair& pair, const Placed& now, Place from, Place to, double way, const MarkOf& mark_of,
                    int depth) {
    double target = pair.open ? std::min(wanted(pair), pair.approach.distance) : wanted(pair);
    if (pair.excused) target = std::min(target, -kPressing);
    target = std::min(target, to.distance);
    if ((from.distance + to.distance - way) / 2 >= target - kResolution || depth >= kDeepest) return;
    const double s = (from.s + to.s) / 2;
    const Distance here = distance(pair, placed_between(now, s));
    if (here.value < wanted(pair)) offer(pair, here, time_before_ + s * (time_ - time_before_), mark_of);
    search_between(pair, now, from, {s, here.value}, way / 2, mark_of, depth + 1);
    search_between(pair, now, {s, here.value}, to, way / 2, mark_of, depth + 1);
  }

  Placed placed_between(const Placed& now, double s) const {
    Placed out{now.moment, {}};
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      const auto &a = before_.moment.robots[r], &b = now.moment.robots[r];
      out.moment.robots[r].base = between(a.base, b.base, s);
      for (std::size_t j = 0; j < a.joints.size(); ++j)
        out.moment.robots[r].joints[j] = a.joints[j] + s * (b.joints[j] - a.joints[j]);
    }
    for (std::size_t p = 0; p < out.moment.parts.size() && p < before_.moment.parts.size(); ++p)
      out.moment.parts[p].pose = between(before_.moment.parts[p].pose, now.moment.parts[p].pose, s);
    for (std::size_t m = 0; m < out.moment.movers.size() && m < before_.moment.movers.size(); ++m)
      out.moment.movers[m] = before_.moment.movers[m] + s * (now.moment.movers[m] - before_.moment.movers[m]);
    place(out);
    return out;
  }

  void offer(Pair& pair, const Distance& here, double time, const MarkOf& mark_of) {
    if (here.value >= wanted(pair)) {
      close(pair, false);
      pair.excused = false;
      return;
    }
    if (pair.open && here.value >= pair.approach.distance) return;
    if (!pair.open) {
      const Body &a = bodies_[pair.a], &b = bodies_[pair.b];
      pair.approach = {};
      pair.approach.first = a.name, pair.approach.second = b.name;
      pair.approach.robot =
          static_cast<std::size_t>(std::max(0, robot_of(a, states_) >= 0 ? robot_of(a, states_) : robot_of(b, states_)));
      pair.approach.at_start = first_ && here.value <= 0;
      pair.open = true;
    }
    const bool touches = here.value <= 0, touched = pair.approach.distance < 0;
    pair.approach.distance = here.value;
    pair.approach.point = here.point;
    pair.approach.time = time;
    if (mark_of) pair.approach.mark = mark_of(pair.approach.robot);
    if (touches && !touched) pair.approach.first_mark = pair.approach.mark;
    if (pair.approach.mark == pair.approach.first_mark) pair.approach.first_distance = here.value;
  }

  void close(Pair& pair, bool taken) {
    if (!std::exchange(pair.open, false)) return;
    if ((taken || pair.excused) && pair.approach.distance >= -kPressing) return;
    approaches_.push_back(pair.approach);
  }

  double clearance_;
  std::vector<Pair> pairs_;
  std::vector<PartMode> states_;
  Placed before_;
  bool first_ = true;
  double time_ = 0, time_before_ = 0;
  std::vector<std::vector<double>> joint_motion_;
  std::vector<double> body_motion_;
};

Sweep::Sweep(std::vector<Robot> robots, const description::Scene& scene, double clearance)
    : work_(std::make_unique<Work>(std::move(robots), scene, clearance)) {}

Sweep::~Sweep() = default;

void Sweep::add(const Moment& moment, double time, const std::function<std::uint64_t(std::size_t)>& mark_of) {
  work_->add(moment, time, mark_of);
}

void Sweep::jump() {
  work_->jump();
}

void Sweep::finish(bool holding_on) {
  work_->finish(holding_on);
}

const std::vector<Approach>& Sweep::approaches() const {
  return work_->approaches_;
}

std::uint64_t Sweep::measured() const {
  return work_->measured_;
}

std::string text_of(const Approach& a) {
  const std::string point = fmt::format("({:.3f}, {:.3f}, {:.3f})", a.point.x, a.point.y, a.point.z);
  if (a.at_start)
    return fmt::format("{} is inside {} where it starts, {:.2f} mm deep, at {}", a.first, a.second,
                       -1e3 * a.distance, point);
  if (a.distance <= 0)
    return fmt::format("{} touched {} at {:.3f} s, {:.2f} mm deep, at {}", a.first, a.second, a.time,
                       std::abs(1e3 * a.distance), point);
  return fmt::format("{} comes within {:.1f} mm of {} at {:.3f} s, at {}", a.first, 1e3 * a.distance,
                     a.second, a.time, point);
}

}  // namespace polyarm::surroundings
