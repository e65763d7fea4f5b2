#include "polyarm/collision/robot_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/collision/separation.hpp"
#include "polyarm/description/self_collision.hpp"

namespace polyarm::collision {

using description::Joint;
using description::JointType;
using description::RobotModel;

namespace {

std::size_t at(int index) {
  return static_cast<std::size_t>(index);
}

/// The variable that drives a joint of the model: ratio * q[variable] + offset.
struct Drive {
  int variable = -1;
  double ratio = 1, offset = 0;
};

Drive drive_of(const RobotModel& model, int joint) {
  Drive out;
  for (std::size_t hops = 0; hops <= model.joints.size(); ++hops) {
    const Joint& j = model.joints[at(joint)];
    if (!j.mimic) {
      const auto found = std::find(model.actuated.begin(), model.actuated.end(), joint);
      if (found != model.actuated.end()) out.variable = static_cast<int>(found - model.actuated.begin());
      return out;
    }
    out.offset += out.ratio * j.mimic->offset;
    out.ratio *= j.mimic->multiplier;
    joint = j.mimic->joint;
    if (joint < 0 || at(joint) >= model.joints.size()) break;
  }
  throw Error("bad-model", "the mimic joints of " + model.name + " form a cycle", "correct the description");
}

bool finite(const Pose& p) {
  return std::isfinite(p.position.x + p.position.y + p.position.z + p.rotation.x + p.rotation.y +
                       p.rotation.z + p.rotation.w);
}

/// The largest size of the shift of a sliding joint; infinite without limits.
double travel_of(const RobotModel& model, const Joint& joint, const Drive& drive) {
  const auto& limits =
      drive.variable < 0 ? joint.limits : model.joints[at(model.actuated[at(drive.variable)])].limits;
  if (!limits.lower || !limits.upper) return INFINITY;
  return std::max(std::abs(drive.ratio * *limits.lower + drive.offset),
                  std::abs(drive.ratio * *limits.upper + drive.offset));
}

}  // namespace

RobotBody::RobotBody(const RobotModel& model, const RobotBodyOptions& options)
    : variables_(model.actuated.size()) {
  add_frames(model);
  add_links(model, options);
  find_levers();
  find_pairs(model, options);
}

void RobotBody::add_frames(const RobotModel& model) {
  frame_of_link_.assign(model.links.size(), -1);
  pose_in_frame_.assign(model.links.size(), Pose{});
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    if (!finite(joint.origin))
      throw Error("bad-model", "the origin of joint " + joint.name + " is not finite",
                  "correct the description");
    const std::size_t parent = at(joint.parent_link), child = at(joint.child_link);
    const Pose here = pose_in_frame_[parent] * joint.origin;
    const bool turns = joint.type == JointType::revolute || joint.type == JointType::continuous;
    if (!turns && joint.type != JointType::prismatic) {
      frame_of_link_[child] = frame_of_link_[parent];
      pose_in_frame_[child] = here;
      continue;
    }
    const Drive drive = drive_of(model, static_cast<int>(i));
    const Pose to_axis{{}, rotation_between({0, 0, 1}, normalized(joint.axis))};
    JointFrame frame;
    frame.parent = frame_of_link_[parent];
    frame.variable = drive.variable < 0 ? 0 : at(drive.variable);
    frame.slides = !turns;
    frame.ratio = drive.variable < 0 ? 0 : drive.ratio;
    frame.offset = drive.offset;
    frame.at = here * to_axis;
    if (frame.slides) frame.travel = travel_of(model, joint, drive);
    frame_of_link_[child] = static_cast<int>(frames_.size());
    pose_in_frame_[child] = inverse(to_axis);
    frames_.push_back(frame);
  }
  if (frames_.size() > kMostSteps)
    throw Error("too-many", fmt::format("{} has {} moving joints, the most are {}", model.name,
                                        frames_.size(), kMostSteps));
}

void RobotBody::add_links(const RobotModel& model, const RobotBodyOptions& options) {
  const auto add = [&](LinkBody link, const std::vector<description::Shape>& shapes, const Pose& pose) {
    for (const description::Shape& shape : shapes)
      for (const ConvexBody& body : bodies_of(shape)) link.bodies.push_back(moved(pose, body));
    if (link.bodies.empty()) {
      if (!shapes.empty()) unknown_.push_back(link.name);
      return;
    }
    SphereCover covered = cover(link.bodies, options.cover);
    link.spheres = std::move(covered.spheres);
    link.excess = covered.largest_excess;
    std::vector<ConvexBody> balls;
    for (const Ball& ball : link.spheres) balls.push_back({{ball.center}, ball.radius, 0, {0, 0, 1}});
    link.around = bounding_ball(balls);
    links_.push_back(std::move(link));
  };
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    LinkBody link;
    link.name = model.links[i].name;
    link.link = static_cast<int>(i);
    link.frame = frame_of_link_[i];
    add(std::move(link), model.links[i].collisions, pose_in_frame_[i]);
  }
  for (const AttachedBody& body : options.attached) {
    if (body.link < 0 || at(body.link) >= model.links.size() || !finite(body.pose))
      throw Error("bad-model",
                  "the body " + body.name + " is attached to no link, or its pose is not finite");
    LinkBody link;
    link.name = body.name;
    link.link = body.link;
    link.attached = true;
    link.frame = frame_of_link_[at(body.link)];
    add(std::move(link), body.shapes, pose_in_frame_[at(body.link)] * body.pose);
  }
  std::size_t spheres = 0;
  for (const LinkBody& link : links_) spheres += link.spheres.size();
  if (links_.size() > kMostBodies || spheres > kMostSpheres)
    throw Error("too-many",
                fmt::format("{} has {} bodies with {} spheres, the most are {} and {}", model.name,
                            links_.size(), spheres, kMostBodies, kMostSpheres),
                "give it simpler shapes");
}

/// For each frame from the link to the base: the largest distance of the link's points from the frame's axis
/// (slides: 1), by the triangle inequality over the frames between.
std::vector<double> RobotBody::levers_by_frame(int own, std::span<const Ball> balls) const {
  std::vector<double> out(frames_.size(), 0);
  double axis_distance = 0, radius = 0;  // of the points, about the axis and about the origin of the frame
  for (const Ball& ball : balls) {
    axis_distance = std::max(axis_distance, std::hypot(ball.center.x, ball.center.y) + ball.radius);
    radius = std::max(radius, norm(ball.center) + ball.radius);
  }
  for (int k = own; k >= 0; k = frames_[at(k)].parent) {
    const JointFrame& frame = frames_[at(k)];
    out[at(k)] = frame.slides ? 1 : axis_distance;
    const Vec3& t = frame.at.position;
    if (frame.slides) radius += frame.travel;
    axis_distance = std::hypot(t.x, t.y) + radius;
    radius = norm(t) + radius;
  }
  return out;
}

std::vector<double> RobotBody::levers_of(int own, std::span<const Ball> balls) const {
  const std::vector<double> by_frame = levers_by_frame(own, balls);
  std::vector<double> out(variables_, 0);
  for (int k = own; k >= 0; k = frames_[at(k)].parent) {
    const JointFrame& frame = frames_[at(k)];
    if (frame.ratio != 0) out[frame.variable] += std::abs(frame.ratio) * by_frame[at(k)];
  }
  return out;
}

std::vector<double> RobotBody::pair_levers(int first_frame, std::span<const Ball> first, int second_frame,
                                           std::span<const Ball> second) const {
  std::vector<bool> above_first(frames_.size(), false), above_second(frames_.size(), false);
  for (int k = first_frame; k >= 0; k = frames_[at(k)].parent) above_first[at(k)] = true;
  for (int k = second_frame; k >= 0; k = frames_[at(k)].parent) above_second[at(k)] = true;
  const std::vector<double> lever_first = levers_by_frame(first_frame, first),
                            lever_second = levers_by_frame(second_frame, second);
  std::vector<double> out(variables_, 0);
  for (std::size_t k = 0; k < frames_.size(); ++k)
    if (above_first[k] != above_second[k] && frames_[k].ratio != 0)
      out[frames_[k].variable] +=
          std::abs(frames_[k].ratio) * (above_first[k] ? lever_first[k] : lever_second[k]);
  return out;
}

void RobotBody::find_levers() {
  for (const LinkBody& link : links_) {
    const std::vector<double> lever = levers_of(link.frame, link.spheres);
    double reach = 0;
    for (const Ball& ball : link.spheres) reach = std::max(reach, norm(ball.center) + ball.radius);
    for (int k = link.frame; k >= 0; k = frames_[at(k)].parent) {
      const JointFrame& frame = frames_[at(k)];
      reach += norm(frame.at.position) + frame.travel;
    }
    levers_.insert(levers_.end(), lever.begin(), lever.end());
    reach_.push_back(reach);
  }
}

void RobotBody::place(std::span<const double> q, std::span<Pose> out) const noexcept {
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const JointFrame& frame = frames_[i];
    const double value = (frame.ratio == 0 ? 0 : frame.ratio * q[frame.variable]) + frame.offset;
    Pose own = frame.at;
    if (frame.slides)
      own.position = own.position + own.rotation * Vec3{0, 0, value};
    else
      own.rotation = own.rotation * Quaternion{0, 0, std::sin(value / 2), std::cos(value / 2)};
    out[i] = frame.parent < 0 ? own : out[at(frame.parent)] * own;
  }
}

namespace {

/// Pairs of links of the model, the smaller index first.
using Pairs = std::set<std::pair<int, int>>;

void add_pair(Pairs& pairs, int a, int b) {
  pairs.insert({std::min(a, b), std::max(a, b)});
}

Pairs left_out(const RobotModel& model, const RobotBodyOptions& options, std::vector<std::string>& always) {
  Pairs out;
  for (const auto& pair : model.allowed_collisions) add_pair(out, pair[0], pair[1]);
  const int links = static_cast<int>(model.links.size());
  for (int a = 0; a < links; ++a)
    for (int b = a + 1; b < links; ++b)
      if (model.links[at(a)].contact.self_collide == false || model.links[at(b)].contact.self_collide == false)
        add_pair(out, a, b);
  for (const description::LinkPair& pair : description::needless_pairs(model, options.samples)) {
    if (pair.reason == description::PairReason::never) continue;
    const bool is_new = out.insert({pair.first, pair.second}).second;
    if (is_new && pair.reason != description::PairReason::adjacent)
      always.push_back(model.links[at(pair.first)].name + ", " + model.links[at(pair.second)].name);
  }
  return out;
}

}  // namespace

void RobotBody::find_pairs(const RobotModel& model, const RobotBodyOptions& options) {
  const Pairs excluded = left_out(model, options, always_);
  Pairs touching;  // attached body (index of links_), link of the model
  std::size_t next = links_.size();
  for (auto body = options.attached.rbegin(); body != options.attached.rend(); ++body) {
    while (next > 0 && !(links_[next - 1].attached && links_[next - 1].name == body->name)) --next;
    if (next == 0) break;
    for (const int link : body->touches) touching.insert({static_cast<int>(next - 1), link});
  }
  for (std::size_t a = 0; a < links_.size(); ++a)
    for (std::size_t b = a + 1; b < links_.size(); ++b) {
      const LinkBody &first = links_[a], &second = links_[b];
      if (first.frame == second.frame) continue;
      const bool links_only = !first.attached && !second.attached;
      if (links_only &&
          excluded.contains({std::min(first.link, second.link), std::max(first.link, second.link)}))
        continue;
      if (!links_only && (touching.contains({static_cast<int>(b), first.link}) ||
                          touching.contains({static_cast<int>(a), second.link})))
        continue;
      pairs_.push_back({a, b, pair_levers(first.frame, first.spheres, second.frame, second.spheres)});
    }
}

}  // namespace polyarm::collision
