#include "polyarm/kinematics/chain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "polyarm/kinematics/random.hpp"

namespace polyarm::kinematics {

using description::Joint;
using description::JointType;
using description::RobotModel;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool finite(const Pose& p) {
  const double values[] = {p.position.x, p.position.y, p.position.z, p.rotation.x,
                           p.rotation.y, p.rotation.z, p.rotation.w};
  return std::all_of(std::begin(values), std::end(values), [](double v) { return std::isfinite(v); });
}

[[noreturn]] void refuse(const std::string& what) {
  throw Error("bad-model", what, "correct the robot's description");
}

Pose checked(Pose pose, const std::string& what) {
  if (!finite(pose)) refuse(what + " has a number that is not finite");
  pose.rotation = normalized(pose.rotation);
  return pose;
}

bool revolves(JointType type) {
  return type == JointType::revolute || type == JointType::continuous;
}

int index_in(std::size_t size, int i, const std::string& what) {
  if (i < 0 || static_cast<std::size_t>(i) >= size) refuse(what + " does not exist");
  return i;
}

}  // namespace

Chain::Frame Chain::frame_of(const Pose& pose) noexcept {
  const auto& [x, y, z, w] = pose.rotation;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
           2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),  //
           2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)},
          {pose.position.x, pose.position.y, pose.position.z}};
}

/// Uses the largest quaternion component, which avoids a division by a small number.
Pose Chain::pose_of(const Frame& f) noexcept {
  const double* r = f.r;
  Quaternion q;
  if (const double trace = r[0] + r[4] + r[8]; trace > 0) {
    q = {r[7] - r[5], r[2] - r[6], r[3] - r[1], 1 + trace};
  } else if (r[0] >= r[4] && r[0] >= r[8]) {
    q = {1 + r[0] - r[4] - r[8], r[1] + r[3], r[2] + r[6], r[7] - r[5]};
  } else if (r[4] >= r[8]) {
    q = {r[1] + r[3], 1 - r[0] + r[4] - r[8], r[5] + r[7], r[2] - r[6]};
  } else {
    q = {r[2] + r[6], r[5] + r[7], 1 - r[0] - r[4] + r[8], r[3] - r[1]};
  }
  return {{f.p[0], f.p[1], f.p[2]}, normalized(q)};
}

void Chain::append(Frame& a, const Frame& b) noexcept {
  Frame out;
  for (int i = 0; i < 3; ++i) {
    const double* row = a.r + 3 * i;
    for (int j = 0; j < 3; ++j)
      out.r[3 * i + j] = row[0] * b.r[j] + row[1] * b.r[3 + j] + row[2] * b.r[6 + j];
    out.p[i] = a.p[i] + row[0] * b.p[0] + row[1] * b.p[1] + row[2] * b.p[2];
  }
  a = out;
}

void Chain::move(Frame& f, const Step& step, double value) noexcept {
  if (step.prismatic) {
    for (int i = 0; i < 3; ++i) f.p[i] += value * f.r[3 * i + 2];
    return;
  }
  const double c = std::cos(value), s = std::sin(value);
  for (int i = 0; i < 3; ++i) {
    double* row = f.r + 3 * i;
    const double x = row[0], y = row[1];
    row[0] = c * x + s * y;
    row[1] = c * y - s * x;
  }
}

Chain::Drive Chain::drive_of(const RobotModel& model, int joint) {
  Drive drive;
  for (std::size_t followed = 0; followed <= model.joints.size(); ++followed) {
    const Joint& at = model.joints[static_cast<std::size_t>(joint)];
    if (!at.mimic) {
      const auto found = std::find(model.actuated.begin(), model.actuated.end(), joint);
      if (found != model.actuated.end()) drive.variable = static_cast<int>(found - model.actuated.begin());
      return drive;
    }
    drive.offset += drive.multiplier * at.mimic->offset;
    drive.multiplier *= at.mimic->multiplier;
    joint = index_in(model.joints.size(), at.mimic->joint, "the joint that '" + at.name + "' mimics");
  }
  refuse("the mimic joints around '" + model.joints[static_cast<std::size_t>(joint)].name +
         "' follow each other in a circle");
}

void Chain::read_joints(const RobotModel& model) {
  if (model.actuated.size() > kMaxJoints)
    throw Error("too-many-joints",
                "the robot '" + model.name + "' has " + std::to_string(model.actuated.size()) +
                    " joints that move by themselves; at most " + std::to_string(kMaxJoints) + " are taken",
                "describe the arm in a file of its own, or make joints that are not used fixed");
  for (const int i : model.actuated) {
    const Joint& joint =
        model.joints[static_cast<std::size_t>(index_in(model.joints.size(), i, "an actuated joint"))];
    const bool bounded = joint.type != JointType::continuous;
    names_.push_back(joint.name);
    lower_.push_back(bounded ? joint.limits.lower.value_or(-kInfinity) : -kInfinity);
    upper_.push_back(bounded ? joint.limits.upper.value_or(kInfinity) : kInfinity);
    if (!(lower_.back() <= upper_.back()))
      refuse("the lower limit of '" + joint.name + "' is not below its upper limit");
    slides_.push_back(joint.type == JointType::prismatic);
  }
  on_path_.assign(joints(), false);
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& j = model.joints[i];
    index_in(link_count_, j.parent_link, "the parent link of '" + j.name + "'");
    index_in(link_count_, j.child_link, "the child link of '" + j.name + "'");
    tree_.push_back({j.parent_link, j.child_link, checked(j.origin, "the origin of '" + j.name + "'"),
                     normalized(j.axis), j.type, j.moves() ? drive_of(model, static_cast<int>(i)) : Drive{}});
  }
}

void Chain::add_step(const Joint& joint, const Drive& drive, Pose& pending) {
  if (joint.type == JointType::planar || joint.type == JointType::floating) return;  // stays at its origin
  const Quaternion to_axis = rotation_between({0, 0, 1}, normalized(joint.axis));
  steps_.push_back({frame_of(pending * Pose{{}, to_axis}), joint.type == JointType::prismatic, drive});
  pending = Pose{{}, inverse(to_axis)};
  if (drive.variable >= 0) on_path_[static_cast<std::size_t>(drive.variable)] = true;
}

void Chain::read_path(const RobotModel& model, int tip_link) {
  std::vector<int> path;
  int link = index_in(link_count_, tip_link, "the tip link");
  while (link != root_) {
    const int joint = model.links[static_cast<std::size_t>(link)].parent_joint;
    if (path.size() > model.joints.size()) refuse("the links form a circle");
    path.push_back(
        index_in(model.joints.size(), joint,
                 "the joint that carries '" + model.links[static_cast<std::size_t>(link)].name + "'"));
    link = model.joints[static_cast<std::size_t>(joint)].parent_link;
  }
  std::reverse(path.begin(), path.end());
  Pose pending = T_world_base_;
  for (const int i : path) {
    const auto at = static_cast<std::size_t>(i);
    pending = pending * tree_[at].origin;
    if (model.joints[at].moves()) add_step(model.joints[at], tree_[at].drive, pending);
  }
  last_ = frame_of(pending * T_tip_tcp_);
  const auto moving = static_cast<std::size_t>(std::count(on_path_.begin(), on_path_.end(), true));
  if (moving > kMostMoving)
    throw Error("too-many-joints",
                std::to_string(moving) + " joints of the robot '" + model.name + "' move '" +
                    model.links[static_cast<std::size_t>(tip_link)].name + "'; at most " +
                    std::to_string(kMostMoving) + " are taken",
                "choose a tool that fewer joints move, or make joints that are not used fixed");
}

void Chain::find_periods() {
  period_.assign(joints(), 0.0);
  std::vector<int> uses(joints(), 0);
  for (const Step& step : steps_) {
    if (step.drive.variable < 0) continue;
    const auto i = static_cast<std::size_t>(step.drive.variable);
    // A joint that also drives others, before or behind this one, does not return to the same pose after one
    // turn.
    const bool whole_turns = !step.prismatic && std::abs(step.drive.multiplier) == 1.0;
    period_[i] = ++uses[i] == 1 && whole_turns ? 2 * std::numbers::pi : 0.0;
  }
  for (const double period : period_) turns_.push_back(period > 0);
}

Chain::Chain(const RobotModel& model, int tip_link, Pose T_world_base, Pose T_tip_tcp)
    : T_world_base_{checked(T_world_base, "the base's pose")},
      T_tip_tcp_{checked(T_tip_tcp, "the tool centre point")},
      link_count_{model.links.size()},
      root_{index_in(model.links.size(), model.root, "the root link")} {
  read_joints(model);
  read_path(model, tip_link);
  find_periods();
  std::vector<ScrewAxis> screws;
  for (const Axis& axis : axes())
    screws.push_back({axis.joint, axis.slides, axis.ratio, axis.direction, axis.point});
  const std::vector<double> zero(joints(), 0.0);
  screws_ = ScrewChain(screws, joints(), pose_of(sweep(zero)), T_world_base_.position);
  find_reach();
}

Chain::Frame Chain::sweep(std::span<const double> q) const noexcept {
  Frame frame;
  for (const Step& step : steps_) {
    append(frame, step.fixed);
    move(frame, step, step.drive.value(q));
  }
  append(frame, last_);
  return frame;
}

Pose Chain::forward(std::span<const double> q) const noexcept {
  return screws_.forward(q);
}

std::vector<Chain::Axis> Chain::axes() const {
  const std::vector<double> zero(joints(), 0.0);
  std::vector<Axis> out;
  Frame frame;
  for (const Step& step : steps_) {
    append(frame, step.fixed);
    move(frame, step, step.drive.value(zero));
    if (step.drive.variable < 0 || step.drive.multiplier == 0) continue;
    out.push_back({static_cast<std::size_t>(step.drive.variable),
                   step.prismatic,
                   step.drive.multiplier,
                   {frame.r[2], frame.r[5], frame.r[8]},
                   {frame.p[0], frame.p[1], frame.p[2]}});
  }
  return out;
}

void Chain::link_poses(std::span<const double> q, std::span<Pose> out) const noexcept {
  std::fill(out.begin(), out.end(), T_world_base_);
  for (const TreeJoint& joint : tree_) {
    Pose pose = out[static_cast<std::size_t>(joint.parent)] * joint.origin;
    const double value = joint.drive.value(q);
    if (revolves(joint.type)) pose.rotation = pose.rotation * from_axis_angle(joint.axis, value);
    if (joint.type == JointType::prismatic) pose.position = pose * (value * joint.axis);
    out[static_cast<std::size_t>(joint.child)] = pose;
  }
}

Pose Chain::jacobian(std::span<const double> q, std::span<double> J) const noexcept {
  return screws_.jacobian(q, J);
}

double Chain::largest_value(const Step& step) const noexcept {
  const Drive& d = step.drive;
  if (d.variable < 0) return std::abs(d.offset);
  const auto i = static_cast<std::size_t>(d.variable);
  if (d.multiplier == 0) return std::abs(d.offset);
  return std::max(std::abs(d.multiplier * lower_[i] + d.offset),
                  std::abs(d.multiplier * upper_[i] + d.offset));
}

double Chain::distance_squared(std::span<const double> q) const noexcept {
  const Vec3 arm = forward(q).position - T_world_base_.position;
  return dot(arm, arm);
}

namespace {

/// The maximum of `f` between two ends: the best value of a coarse grid, refined by golden section.
template <typename Function>
double peak_between(double lower, double upper, const Function& f) {
  constexpr int kCells = 24, kNarrowings = 45;
  const double cell = (upper - lower) / kCells;
  double best = lower, most = f(lower);
  for (int i = 1; i <= kCells; ++i)
    if (const double value = f(lower + i * cell); value > most) most = value, best = lower + i * cell;
  double a = std::max(lower, best - cell), b = std::min(upper, best + cell);
  for (int i = 0; i < kNarrowings; ++i) {
    const double width = (b - a) / std::numbers::phi;
    if (f(b - width) > f(a + width))
      b = a + width;
    else
      a = b - width;
  }
  return (a + b) / 2;
}

}  // namespace

/// The value of the joint that takes the TCP furthest from the base while the others stay. For a joint that
/// turns once the squared distance is a + b cos q + c sin q, so three values determine it.
double Chain::furthest_turn(std::span<double> q, std::size_t joint) const noexcept {
  const auto at = [&](double value) {
    q[joint] = value;
    return distance_squared(q);
  };
  double lower = lower_[joint], upper = upper_[joint];
  if (!std::isfinite(lower)) lower = std::isfinite(upper) ? upper - 2 * std::numbers::pi : -std::numbers::pi;
  if (!std::isfinite(upper)) upper = lower + 2 * std::numbers::pi;
  if (!(period_[joint] > 0)) return peak_between(lower, upper, at);
  constexpr double kThird = 2 * std::numbers::pi / 3;
  const double f0 = at(0), f1 = at(kThird), f2 = at(-kThird);
  const double best = std::atan2((f1 - f2) / std::numbers::sqrt3, (2 * f0 - f1 - f2) / 3);
  return best + period_[joint] * std::max(0.0, std::ceil((lower - best) / period_[joint]));
}

/// Moves one joint to the value of furthest_turn(), or to a limit.
void Chain::stretch_joint(std::span<double> q, std::size_t joint) const noexcept {
  const double was = q[joint];
  const double turned = slides_[joint] ? was : furthest_turn(q, joint);
  double most = -1, best = was;
  for (const double value : {was, lower_[joint], upper_[joint], turned}) {
    if (!std::isfinite(value) || value < lower_[joint] || value > upper_[joint]) continue;
    q[joint] = value;
    const double distance = distance_squared(q);
    if (distance > most) most = distance, best = value;
  }
  q[joint] = best;
}

void Chain::find_reach() {
  double first_length = 0;
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const double* p = steps_[k].fixed.p;
    const Vec3 length = k == 0 ? Vec3{p[0], p[1], p[2]} - T_world_base_.position : Vec3{p[0], p[1], p[2]};
    first_length += norm(length) + (steps_[k].prismatic ? largest_value(steps_[k]) : 0.0);
  }
  const Vec3 rest{last_.p[0], last_.p[1], last_.p[2]};
  reach_bound_ = first_length + norm(steps_.empty() ? rest - T_world_base_.position : rest);
  if (!std::isfinite(reach_bound_)) {
    reach_ = kInfinity;
    return;
  }
  Random random(1);
  std::array<double, kMaxJoints> values{};
  const std::span<double> q(values.data(), joints());
  constexpr int kStarts = 6, kSweeps = 12;
  for (int start = 0; start < kStarts; ++start) {
    for (std::size_t i = 0; i < joints(); ++i)
      if (on_path_[i]) q[i] = random_value(*this, i, random);
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (std::size_t i = 0; i < joints(); ++i)
        if (on_path_[i]) stretch_joint(q, i);
    reach_ = std::max(reach_, std::sqrt(distance_squared(q)));
  }
}

}  // namespace polyarm::kinematics
