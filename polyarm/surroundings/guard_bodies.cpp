#include "polyarm/surroundings/guard_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "polyarm/collision/separation.hpp"

namespace polyarm::surroundings {

using collision::ConvexBody;
using Body = SweptBody;
using Kind = BodyKind;

namespace {

constexpr double kLessOfMany = 0.02;  // m
constexpr std::uint64_t kDepth = 20;  // distances that take as long as the depth of an overlap
constexpr double kUnknown = -std::numeric_limits<double>::infinity();

std::size_t at(int index) {
  return static_cast<std::size_t>(index);
}

/// How far a point within `radius` of the origin of a frame moves.
double motion_between(const Pose& a, const Pose& b, double radius) {
  if (a == b) return 0;
  return norm(b.position - a.position) + angle_between(a.rotation, b.rotation) * radius;
}

double sum(std::span<const double> lever, std::span<const double> size) {
  double out = 0;
  for (std::size_t j = 0; j < lever.size() && j < size.size(); ++j) out += lever[j] * size[j];
  return out;
}

/// By link: true for the link that carries the tool and all behind it, such as the jaws of a gripper.
std::vector<char> hand_of(const description::RobotModel& model) {
  std::vector<char> out(model.links.size(), 0);
  for (std::size_t i = 0; i < out.size(); ++i)
    for (int link = static_cast<int>(i); link >= 0 && !out[i];) {
      out[i] = link == model.tool_link();
      const int joint = model.links[at(link)].parent_joint;
      link = joint < 0 ? -1 : model.joints[at(joint)].parent_link;
    }
  return out;
}

/// The place of the disc around a point of a body that is farthest against `normal`.
Vec3 lowest(const ConvexBody& body, const Pose& pose, const Vec3& point, const Vec3& normal) {
  if (body.disc <= 0) return pose * point;
  const Vec3 axis = pose.rotation * body.axis, across = normal - dot(normal, axis) * axis;
  const double size = norm(across);
  return size > 1e-9 ? pose * point - (body.disc / size) * across : pose * point;
}

}  // namespace

GuardBodies::GuardBodies(std::vector<Robot> robots, const description::Scene& scene,
                         const std::vector<GuardZone>& zones)
    : SweepBodies(std::move(robots), scene) {
  planes_.resize(bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (bodies_[i].kind == Kind::floor) planes_[i] = {{0, 0, 1}, scene.floor_height};
  zone_robot_.assign(bodies_.size(), -2);
  for (const GuardZone& zone : zones) add_zone(zone);
  parts_.resize(scene.parts.size());
  for (const Robot& robot : robots_) hands_.push_back(hand_of(*robot.model));
  for (std::size_t a = 0; a < bodies_.size(); ++a) {
    for (std::size_t b = a + 1; b < bodies_.size(); ++b) add_pair(a, b);
    if (pairs_.size() > kMostPairs)
      throw Error("too-many-bodies", std::to_string(robots_.size()) + " robots with " +
                                         std::to_string(bodies_.size()) +
                                         " bodies around them are more than guards can follow");
  }
  for (std::size_t r = 0; r < models_.size(); ++r) {
    for (const collision::LinkPairBody& link : models_[r]->pairs()) {
      GuardPair pair;
      pair.a = static_cast<std::uint32_t>(first_body_[r] + link.first);
      pair.b = static_cast<std::uint32_t>(first_body_[r] + link.second);
      pair.robot_a = pair.robot_b = static_cast<int>(r);
      pair.own = true;
      pair.active = !is_hand(bodies_[pair.a]) || !is_hand(bodies_[pair.b]);  // a gripper closes
      pair.slack = kUnknown;
      pair.lever = link.lever;
      pairs_.push_back(std::move(pair));
    }
    frames_.emplace_back(models_[r]->frames().size());
    joint_motion_.emplace_back(models_[r]->variables(), 0.0);
    ahead_.emplace_back();
    for (std::vector<Pose>& frames : ahead_.back()) frames.resize(frames_.back().size());
    ahead_step_.emplace_back();
    for (std::vector<double>& step : ahead_step_.back()) step.assign(models_[r]->variables(), 0.0);
    ahead_count_.push_back(-1);
  }
  std::size_t most = 0;
  for (const auto& frames : frames_) most = std::max(most, frames.size());
  trial_.resize(most);
  motion_.assign(bodies_.size(), 0);
  moved_.assign(bodies_.size(), 0);
  placed_.resize(bodies_.size());
}

void GuardBodies::add_zone(const GuardZone& zone) {
  Body body;
  body.name = "zone " + zone.name;
  body.kind = zone.box ? Kind::fixture : Kind::floor;
  body.is_static = true;
  if (zone.box) {
    description::Shape shape;
    shape.size = zone.high - zone.low;
    shape.pose.position = 0.5 * (zone.low + zone.high);
    body.pieces = collision::bodies_of(shape);
    for (const ConvexBody& piece : body.pieces) body.balls.push_back(collision::bounding_ball(piece));
    body.around = collision::bounding_ball(body.pieces);
  }
  bodies_.push_back(std::move(body));
  planes_.push_back({zone.normal, dot(zone.normal, zone.point)});
  zone_robot_.push_back(zone.robot);
}

/// Pairs of different owners; those of one robot come from its model.
void GuardBodies::add_pair(std::size_t a, std::size_t b) {
  const Body &first = bodies_[a], &second = bodies_[b];
  GuardPair pair;
  pair.a = static_cast<std::uint32_t>(a), pair.b = static_cast<std::uint32_t>(b);
  pair.of_part = first.part >= 0 || second.part >= 0;
  pair.of_zone = zone_robot_[a] != -2 || zone_robot_[b] != -2;
  pair.slack = kUnknown;
  if (first.part >= 0 && second.part >= 0 && robots_.size() < 2) return;  // no two hands could bring them together
  if (pair.of_zone) {
    if (pair.of_part || !first.of_robot() || first.is_root) return;
    if (zone_robot_[b] >= 0 && zone_robot_[b] != first.robot) return;
    pair.active = true;
  } else if (!pair.of_part) {
    if (!counts(first, second)) return;
    pair.active = true;
  }
  // A plane is always the second body of its pair.
  if (bodies_[pair.a].kind == Kind::floor) std::swap(pair.a, pair.b);
  pair.robot_a = bodies_[pair.a].of_robot() ? bodies_[pair.a].robot : -1;
  pair.robot_b = bodies_[pair.b].of_robot() ? bodies_[pair.b].robot : -1;
  pairs_.push_back(std::move(pair));
}

bool GuardBodies::is_hand(const Body& body) const noexcept {
  if (body.kind == Kind::tool || body.kind == Kind::fingers) return true;
  return body.of_robot() && hands_[at(body.robot)][at(body.link)];
}

// --- the present ------------------------------------------------------------------------------------------

void GuardBodies::place(std::size_t robot, std::span<const double> joints,
                        std::vector<Pose>& frames) const noexcept {
  const std::size_t count = models_[robot]->frames().size();
  models_[robot]->place(joints, {frames.data(), count});
  for (std::size_t i = 0; i < count; ++i) frames[i] = moment_.robots[robot].base * frames[i];
}

void GuardBodies::try_joints(std::size_t robot, std::span<const double> joints) noexcept {
  place(robot, joints, trial_);
}

int GuardBodies::frame_of(std::uint32_t body) const noexcept {
  const Body& b = bodies_[body];
  return b.part >= 0 ? tool_frame_[at(parts_[at(b.part)].held_by)] : b.frame;
}

void GuardBodies::add_ahead(std::size_t robot, std::span<const double> joints,
                            std::span<const double> step) noexcept {
  int& count = ahead_count_[robot];
  count = std::max(count, 0);
  if (count == static_cast<int>(kAhead)) return;
  place(robot, joints, ahead_[robot][at(count)]);
  std::vector<double>& size = ahead_step_[robot][at(count)];
  std::copy_n(step.begin(), std::min(step.size(), size.size()), size.begin());
  ++count;
}

GuardGap GuardBodies::gap_while_braking(const GuardPair& pair, int moved, double drift,
                                        double enough) noexcept {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  GuardGap out = gap_of(pair, kAny, moved);
  const int other = pair.own ? -1 : pair.other_than(moved);
  if (other < 0) return out;
  if (ahead_count_[at(other)] < 0 || out.distance - drift >= enough) {
    out.distance -= drift;
    return out;
  }
  // Between two places the distance falls below the mean of both by at most half of the way between them.
  double before = out.distance, least = before;
  for (int k = 0; k < ahead_count_[at(other)]; ++k) {
    const GuardGap here = gap_of(pair, kAny, moved, k);
    const double way = change(pair, other, ahead_step_[at(other)][at(k)]);
    least = std::min({least, here.distance, (before + here.distance - way) / 2});
    before = here.distance;
    if (here.distance < out.distance) out = here;
  }
  out.distance = least;
  return out;
}

Pose GuardBodies::pose_of(std::uint32_t body, int moved, int ahead) const noexcept {
  const Body& b = bodies_[body];
  const int robot = robot_of(b, parts_);
  if (robot < 0) return placed_[body];
  const int frame = frame_of(body);
  const Pose pose = frame < 0 ? moment_.robots[at(robot)].base : frames(robot, moved, ahead)[at(frame)];
  return b.part >= 0 ? pose * parts_[at(b.part)].in_hand : pose;
}

void GuardBodies::look(const Moment& moment) {
  if (!looked_) moment_ = moment;
  find_motion(moment);
  moment_ = moment;  // its vectors keep their size
  for (std::size_t r = 0; r < robots_.size(); ++r) place(r, moment_.robots[r].joints, frames_[r]);
  take_part_changes(moment);
  if (looked_) follow_pairs();
  looked_ = true;
}

double GuardBodies::motion_of_robot_body(std::size_t body, const Pose& base,
                                         const Pose& next) const noexcept {
  const Body& b = bodies_[body];
  double out = sum(b.lever, joint_motion_[at(robot_of(b, parts_))]);
  if (base == next) return out;
  const Vec3 center = pose_of(static_cast<std::uint32_t>(body), -1) * b.around.center;
  return out + motion_between(base, next, norm(center - base.position) + b.around.radius + out);
}

/// How far each body has moved since the last moment, at most.
void GuardBodies::find_motion(const Moment& moment) noexcept {
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    const std::vector<double>&from = moment_.robots[r].joints, &to = moment.robots[r].joints;
    for (std::size_t j = 0; j < joint_motion_[r].size(); ++j)
      joint_motion_[r][j] = j < from.size() && j < to.size() ? std::abs(to[j] - from[j]) : 0;
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const int robot = robot_of(body, parts_);
    if (robot >= 0) {
      motion_[i] =
          looked_ ? motion_of_robot_body(i, moment_.robots[at(robot)].base, moment.robots[at(robot)].base)
                  : 0;
      moved_[i] += motion_[i];
      continue;
    }
    motion_[i] = 0;
    if (body.is_static && looked_) continue;
    Pose next;
    if (body.part >= 0) {
      if (at(body.part) >= moment.parts.size()) continue;
      next = moment.parts[at(body.part)].pose;
    } else if (body.fixture >= 0) {
      next = surroundings::pose_of(scene_.fixtures[at(body.fixture)], scene_, moment);
    }
    motion_[i] = motion_between(placed_[i], next, norm(body.around.center) + body.around.radius);
    placed_[i] = next;
    if (looked_) moved_[i] += motion_[i];
  }
}

void GuardBodies::follow_pairs() noexcept {
  for (GuardPair& pair : pairs_) {
    if (!pair.active) continue;
    pair.slack -=
        pair.own ? sum(pair.lever, joint_motion_[at(pair.robot_a)]) : motion_[pair.a] + motion_[pair.b];
  }
}

void GuardBodies::take_part_changes(const Moment& moment) {
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    PartMode mode;
    if (p < moment.parts.size()) {
      mode.in_world = moment.parts[p].in_world;
      mode.held_by =
          moment.parts[p].held_by < static_cast<int>(robots_.size()) ? moment.parts[p].held_by : -1;
    }
    if (looked_ && mode == parts_[p]) continue;
    if (mode.held_by >= 0) {
      const std::size_t r = at(mode.held_by);
      const Pose tool = tool_frame_[r] < 0 ? moment.robots[r].base : frames_[r][at(tool_frame_[r])];
      mode.in_hand = inverse(tool) * moment.parts[p].pose;
    }
    parts_[p] = mode;
    renew(static_cast<int>(p));
  }
}

/// The pairs of a part that was taken, released, brought or removed.
void GuardBodies::renew(int part) {
  const PartMode& mode = parts_[at(part)];
  for (Body& body : bodies_) {
    if (body.part != part) continue;
    if (mode.held_by >= 0)
      body.lever = models_[at(mode.held_by)]->levers_of(tool_frame_[at(mode.held_by)],
                                                        balls_in_hand(body, mode.in_hand));
    const auto index = static_cast<std::size_t>(&body - bodies_.data());
    if (mode.held_by < 0 && at(part) < moment_.parts.size()) placed_[index] = moment_.parts[at(part)].pose;
  }
  for (GuardPair& pair : pairs_) {
    const Body &a = bodies_[pair.a], &b = bodies_[pair.b];
    if (a.part != part && b.part != part) continue;
    pair.robot_a = robot_of(a, parts_), pair.robot_b = robot_of(b, parts_);
    // Hands, and what they hold, push loose parts: that is their work.
    const auto works = [&](const Body& x, const Body& y) {
      return x.part >= 0 && robot_of(x, parts_) < 0 && (y.part >= 0 || is_hand(y));
    };
    pair.active = counts(a, b, parts_) && !works(a, b) && !works(b, a);
    pair.own = pair.robot_a >= 0 && pair.robot_a == pair.robot_b;
    pair.slack = kUnknown;
    ++pair.version;
    if (!pair.active || !pair.own) continue;
    const Body &held = a.part >= 0 ? a : b, &link = a.part >= 0 ? b : a;
    pair.lever = models_[at(mode.held_by)]->pair_levers(
        tool_frame_[at(mode.held_by)], balls_in_hand(held, mode.in_hand), link.frame, link.balls);
  }
}

// --- bounds and distances ---------------------------------------------------------------------------------

double GuardBodies::reach(std::uint32_t body, std::span<const double> size) const noexcept {
  return sum(bodies_[body].lever, size);
}

void GuardBodies::reaches(int robot, std::span<const double> size,
                          std::span<const std::vector<double>> others, std::span<double> out) const noexcept {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const int by = robot_of(bodies_[i], parts_);
    out[i] = by < 0 ? 0 : sum(bodies_[i].lever, by == robot ? size : std::span<const double>(others[at(by)]));
  }
}

void GuardBodies::levers(int robot, std::span<double> out) const noexcept {
  std::fill(out.begin(), out.end(), 0.0);
  for (const Body& body : bodies_)
    if (robot_of(body, parts_) == robot)
      for (std::size_t j = 0; j < out.size() && j < body.lever.size(); ++j)
        out[j] = std::max(out[j], body.lever[j]);
}

double GuardBodies::fastest(int robot, std::span<const double> size) const noexcept {
  double out = 0;
  for (const Body& body : bodies_)
    if (robot_of(body, parts_) == robot) out = std::max(out, sum(body.lever, size));
  return out;
}

double GuardBodies::change(const GuardPair& pair, int robot, std::span<const double> size) const noexcept {
  return sum(lever_of(pair, robot), size);
}

GuardGap GuardBodies::from_plane(const GuardPair& pair, int moved) const noexcept {
  const Plane& plane = planes_[pair.b];
  const Pose pose = pose_of(pair.a, moved);
  GuardGap out{std::numeric_limits<double>::infinity(), {}, {}, plane.normal};
  const Vec3 down = inverse(pose.rotation) * -plane.normal;
  for (const ConvexBody& piece : bodies_[pair.a].pieces) {
    const Vec3 point = pose * piece.core_support(down) - piece.radius * plane.normal;
    const double distance = dot(plane.normal, point) - plane.offset;
    if (distance < out.distance) out.distance = distance, out.on_a = point;
  }
  out.on_b = out.on_a - out.distance * plane.normal;
  return out;
}

GuardGap GuardBodies::between(const ConvexBody& a, const Pose& pose_a, const ConvexBody& b,
                              const Pose& pose_b) noexcept {
  ++measured_;
  const Pose T_b_a = inverse(pose_b) * pose_a;
  const collision::Separation s = collision::separation(a, T_b_a, b);
  if (s.distance > 0) {
    const Vec3 on_a = pose_b * s.on_a, on_b = pose_b * s.on_b, way = on_a - on_b;
    return {s.lower, on_a, on_b, (1 / std::max(norm(way), 1e-12)) * way};
  }
  measured_ += kDepth;
  const collision::Depth depth = collision::overlap(a, T_b_a, b);
  const Vec3 normal = pose_b.rotation * depth.direction;
  const Vec3 deepest = pose_b * (T_b_a * a.core_support(inverse(T_b_a.rotation) * -depth.direction) -
                                 a.radius * depth.direction);
  return {-depth.depth, deepest, deepest + depth.depth * normal, normal};
}

GuardGap GuardBodies::gap_of(const GuardPair& pair, double enough, int moved, int ahead) noexcept {
  if (bodies_[pair.b].kind == Kind::floor) return from_plane(pair, moved);
  return gap_at(pair, pose_of(pair.a, moved, ahead), pose_of(pair.b, moved, ahead), enough);
}

GuardGap GuardBodies::gap_after(const GuardPair& pair, bool a, const Pose& motion, double enough) noexcept {
  const Pose pose_a = pose_of(pair.a, -1), pose_b = pose_of(pair.b, -1);
  return gap_at(pair, a ? motion * pose_a : pose_a, a ? pose_b : motion * pose_b, enough);
}

/// Of two bodies that have pieces.
GuardGap GuardBodies::gap_at(const GuardPair& pair, const Pose& pose_a, const Pose& pose_b,
                             double enough) noexcept {
  const Body &a = bodies_[pair.a], &b = bodies_[pair.b];
  const double rough =
      norm(pose_a * a.around.center - pose_b * b.around.center) - a.around.radius - b.around.radius;
  GuardGap out{std::max(rough, enough), {}, {}, {0, 0, 1}};
  if (rough > enough) return out;
  out.distance = std::numeric_limits<double>::infinity();
  each_near(
      a, pose_a, b, pose_b, [&] { return out.distance; },
      [&](std::size_t i, std::size_t k) {
        const GuardGap gap = between(a.pieces[i], pose_a, b.pieces[k], pose_b);
        if (gap.distance < out.distance) out = gap;
      });
  return out;
}

GuardBodies::Nearest GuardBodies::nearest(int robot, double within, bool tried) noexcept {
  Nearest out;
  out.gap.distance = within;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const GuardPair& pair = pairs_[i];
    if (!pair.active || pair.own || pair.of_zone || !pair.concerns(robot)) continue;
    if (!tried && pair.slack >= out.gap.distance) continue;
    const GuardGap gap = gap_of(pair, out.gap.distance, tried ? robot : -1);
    if (gap.distance < out.gap.distance) out = {static_cast<int>(i), gap};
  }
  return out;
}

double GuardBodies::measure(std::size_t index, double enough) noexcept {
  return pairs_[index].slack = gap_of(pairs_[index], enough).distance;
}

std::size_t GuardBodies::measure_points(std::size_t index, int robot, double range, std::span<GuardGap> out,
                                        double& left_out) noexcept {
  GuardPair& pair = pairs_[index];
  left_out = std::numeric_limits<double>::infinity();
  pair.slack = std::numeric_limits<double>::infinity();
  const bool of_a = pair.robot_a == robot;
  const Body &a = bodies_[pair.a], &b = bodies_[pair.b];
  const Pose pose_a = pose_of(pair.a, -1), pose_b = pose_of(pair.b, -1);
  std::size_t count = 0;
  // Keeps the nearest; `gap` begins as the nearest points of two pieces.
  const auto add = [&](const GuardGap& gap) {
    if (gap.distance > range) return;
    if (count < out.size()) {
      out[count++] = gap;
      return;
    }
    GuardGap dropped = gap;
    const auto farthest = std::max_element(
        out.begin(), out.end(), [](const GuardGap& x, const GuardGap& y) { return x.distance < y.distance; });
    if (farthest != out.end() && gap.distance < farthest->distance) std::swap(*farthest, dropped);
    left_out = std::min(left_out, dropped.distance);
  };
  const bool on_plane = b.kind == Kind::floor;
  const auto spread = [&](const ConvexBody& piece, const Pose& pose, const GuardGap& gap) {
    const Vec3 in = of_a ? gap.normal : -gap.normal;  // from the obstacle towards the body
    const double plane = of_a ? dot(in, gap.on_b) : dot(in, gap.on_a);
    for (const Vec3& corner : piece.points) {
      const Vec3 point = lowest(piece, pose, corner, in) - piece.radius * in;
      GuardGap one = gap;
      one.distance = dot(in, point) - plane;
      if (on_plane) pair.slack = std::min(pair.slack, one.distance);
      (of_a ? one.on_a : one.on_b) = point;
      add(one);
    }
  };
  if (on_plane) {
    const Plane& plane = planes_[pair.b];
    for (const ConvexBody& piece : a.pieces) {
      GuardGap gap{1, {}, plane.offset * plane.normal, plane.normal};
      spread(piece, pose_a, gap);
    }
    return count;
  }
  const auto look_at = [&](std::size_t i, std::size_t k) {
    const GuardGap gap = between(a.pieces[i], pose_a, b.pieces[k], pose_b);
    pair.slack = std::min(pair.slack, gap.distance);
    if (gap.distance > range) return;
    if (of_a)
      spread(a.pieces[i], pose_a, gap);
    else
      spread(b.pieces[k], pose_b, gap);
  };
  if (!a.tree.empty() || !b.tree.empty()) {
    // Of very many pieces only the near ones are measured; the others are farther away than this.
    range -= kLessOfMany;
    pair.slack = left_out = range;
    each_near(
        a, pose_a, b, pose_b, [&] { return range; }, look_at);
    return count;
  }
  for (std::size_t i = 0; i < a.pieces.size(); ++i) {
    const Vec3 center = pose_a * a.balls[i].center;
    for (std::size_t k = 0; k < b.pieces.size(); ++k) {
      const double rough = norm(center - pose_b * b.balls[k].center) - a.balls[i].radius - b.balls[k].radius;
      if (rough > range)
        pair.slack = std::min(pair.slack, rough);
      else
        look_at(i, k);
    }
  }
  return count;
}

void GuardBodies::slide(std::uint32_t body, int robot, const Vec3& point, const Vec3& normal, double sign,
                        std::span<double> out) const noexcept {
  const std::vector<collision::JointFrame>& chain = models_[at(robot)]->frames();
  for (int k = frame_of(body); k >= 0; k = chain[at(k)].parent) {
    const collision::JointFrame& joint = chain[at(k)];
    if (joint.ratio == 0 || joint.variable >= out.size()) continue;
    const Pose& frame = frames_[at(robot)][at(k)];
    const Vec3 axis = frame.rotation * Vec3{0, 0, 1};
    const double rate = joint.slides ? dot(normal, axis) : dot(normal, cross(axis, point - frame.position));
    out[joint.variable] += sign * joint.ratio * rate;
  }
}

void GuardBodies::gradient(const GuardPair& pair, int robot, const GuardGap& gap,
                           std::span<double> out) const noexcept {
  std::fill(out.begin(), out.end(), 0.0);
  if (pair.robot_a == robot) slide(pair.a, robot, gap.on_a, gap.normal, 1, out);
  // Of a pair of one robot the plane moves with the second body.
  if (pair.robot_b == robot) slide(pair.b, robot, pair.own ? gap.on_a : gap.on_b, gap.normal, -1, out);
}

}  // namespace polyarm::surroundings
