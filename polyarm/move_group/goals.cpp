#include "polyarm/move_group/goals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/base/text.hpp"
#include "polyarm/kinematics/random.hpp"
#include "polyarm/move_group/poses.hpp"
#include "polyarm/planning/pose_goals.hpp"

namespace polyarm::move_group {

namespace {

using Primitive = messages::shape_msgs::msg::SolidPrimitive;
using planning::JointState;

constexpr double kSlack = 1e-6;  // m and rad that rounding explains
constexpr std::size_t kMostStates = 48;
constexpr int kSamples = 32;    // poses within tolerances and regions
constexpr double kFree = 3.14;  // rad: an orientation tolerance that leaves the axis free
constexpr std::uint64_t kSeed = 1;

void require(bool good, const std::string& what) {
  if (!good) throw Refusal(Code::INVALID_GOAL_CONSTRAINTS, what);
}

/// The angles of rotations about x, then y, then z of the turned frame, as Eigen's eulerAngles(0, 1, 2) has
/// them.
Vec3 euler_xyz(const Quaternion& q) {
  const Vec3 x = q * Vec3{1, 0, 0}, y = q * Vec3{0, 1, 0}, z = q * Vec3{0, 0, 1};
  return {std::atan2(-z.y, z.z), std::asin(std::clamp(z.x, -1.0, 1.0)), std::atan2(-y.x, x.x)};
}

}  // namespace

bool Goal::Solid::contains(const Vec3& point) const {
  const Vec3 p = inverse(pose) * point;
  switch (type) {
    case Primitive::SPHERE:
      return norm(p) <= a + kSlack;
    case Primitive::CYLINDER:
      return std::hypot(p.x, p.y) <= a + kSlack && std::abs(p.z) <= b + kSlack;
    default:
      return std::abs(p.x) <= a + kSlack && std::abs(p.y) <= b + kSlack && std::abs(p.z) <= c + kSlack;
  }
}

double Goal::Solid::least() const {
  if (type == Primitive::SPHERE) return a;
  return type == Primitive::CYLINDER ? std::min(a, b) : std::min({a, b, c});
}

Vec3 Goal::OrientationBound::error(const Quaternion& rotation) const {
  const Quaternion q = inverse(target) * rotation;
  return rotation_vector ? to_rotation_vector(q) : euler_xyz(q);
}

Goal::Goal(const Around& around, const msg::Constraints& message) : around_(around) {
  const std::size_t count = message.joint_constraints.size() + message.position_constraints.size() +
                            message.orientation_constraints.size();
  if (count > kMostConstraints)
    throw Refusal(Code::INVALID_GOAL_CONSTRAINTS,
                  fmt::format("{} constraints are given; {} are possible", count, kMostConstraints));
  if (!message.visibility_constraints.empty())
    throw Refusal(Code::INVALID_GOAL_CONSTRAINTS, "visibility constraints are not supported");
  for (const auto& each : message.joint_constraints) add(each);
  for (const auto& each : message.position_constraints) add(each);
  for (const auto& each : message.orientation_constraints) add(each);
}

void Goal::add(const msg::JointConstraint& message) {
  const auto variable = around_.arm->find_joint(message.joint_name);
  if (!variable)
    throw Refusal(Code::INVALID_GOAL_CONSTRAINTS,
                  fmt::format("'{}' has no joint '{}'{}", around_.arm->name(), message.joint_name,
                              did_you_mean(message.joint_name, around_.arm->joints())));
  const double above = message.tolerance_above, below = message.tolerance_below;
  require(std::isfinite(message.position) && above >= 0 && below >= 0,
          "the constraint of '" + message.joint_name +
              "' has a number that is not finite, or a negative tolerance");
  joints_.push_back({*variable, message.position, message.position - below, message.position + above});
}

void Goal::add(const msg::PositionConstraint& message) {
  PositionBound bound{around_.arm->link(message.link_name), {}, {}};
  bound.offset = {message.target_point_offset.x, message.target_point_offset.y,
                  message.target_point_offset.z};
  require(std::isfinite(norm(bound.offset)), "the target point offset is not finite");
  const auto& region = message.constraint_region;
  if (!region.meshes.empty())
    throw Refusal(Code::INVALID_GOAL_CONSTRAINTS,
                  "a region of meshes is not supported: box, sphere and cylinder are");
  if (region.primitives.empty() || region.primitives.size() != region.primitive_poses.size())
    throw Refusal(Code::INVALID_GOAL_CONSTRAINTS,
                  fmt::format("the position of '{}' has {} regions and {} poses of them", message.link_name,
                              region.primitives.size(), region.primitive_poses.size()));
  require(region.primitives.size() <= kMostConstraints, "the position has too many regions");
  const Pose frame = around_.frame(message.header.frame_id);
  for (std::size_t i = 0; i < region.primitives.size(); ++i) {
    const Primitive& primitive = region.primitives[i];
    const std::size_t sizes = primitive.type == Primitive::BOX        ? 3
                              : primitive.type == Primitive::SPHERE   ? 1
                              : primitive.type == Primitive::CYLINDER ? 2
                                                                      : 0;
    require(sizes > 0, "a region of this type is not supported: box, sphere and cylinder are");
    require(primitive.dimensions.size() >= sizes, "a region has too few dimensions");
    for (std::size_t k = 0; k < sizes; ++k)
      require(primitive.dimensions[k] >= 0 && primitive.dimensions[k] < 1e6,
              "a region has a size that is not finite");
    const auto& d = primitive.dimensions;
    Solid solid{primitive.type, d[0] / 2, 0, 0, {}};
    if (primitive.type == Primitive::SPHERE) solid.a = d[0];
    if (primitive.type == Primitive::CYLINDER) solid.a = d[1], solid.b = d[0] / 2;
    if (primitive.type == Primitive::BOX) solid.b = d[1] / 2, solid.c = d[2] / 2;
    solid.pose = frame * pose_of(region.primitive_poses[i], "a region", Code::INVALID_GOAL_CONSTRAINTS);
    bound.region.push_back(solid);
  }
  positions_.push_back(std::move(bound));
}

void Goal::add(const msg::OrientationConstraint& message) {
  const Vec3 tolerance{message.absolute_x_axis_tolerance, message.absolute_y_axis_tolerance,
                       message.absolute_z_axis_tolerance};
  require(tolerance.x >= 0 && tolerance.y >= 0 && tolerance.z >= 0,
          "an orientation has a tolerance that is negative or not a number");
  const auto& q = message.orientation;
  require(q.x != 0 || q.y != 0 || q.z != 0 || q.w != 0, "an orientation is a quaternion of length 0");
  const Quaternion target =
      around_.frame(message.header.frame_id).rotation *
      rotation_of(q, "the orientation of '" + message.link_name + "'", Code::INVALID_GOAL_CONSTRAINTS);
  orientations_.push_back({around_.arm->link(message.link_name), target, tolerance,
                           message.parameterization == msg::OrientationConstraint::ROTATION_VECTOR});
}

std::string Goal::violated(const JointBound& bound, std::span<const double> q) const {
  const double value = q[bound.variable];
  if (value >= bound.low - kSlack && value <= bound.high + kSlack) return "";
  return fmt::format("{} is at {:.4f}, outside {:.4f} to {:.4f}", around_.arm->joints()[bound.variable],
                     value, bound.low, bound.high);
}

std::string Goal::violated(const PositionBound& bound, std::span<const double> q) const {
  const Vec3 at = around_.link_in_world(bound.link, q) * bound.offset;
  if (std::any_of(bound.region.begin(), bound.region.end(), [&](const Solid& s) { return s.contains(at); }))
    return "";
  return fmt::format("'{}' is outside its region, {:.4f} m from the middle of the first",
                     around_.arm->link_name(bound.link), norm(at - bound.region.front().pose.position));
}

std::string Goal::violated(const OrientationBound& bound, std::span<const double> q) const {
  const Vec3 e = bound.error(around_.link_in_world(bound.link, q).rotation), &t = bound.tolerance;
  if (std::abs(e.x) <= t.x + kSlack && std::abs(e.y) <= t.y + kSlack && std::abs(e.z) <= t.z + kSlack)
    return "";
  return fmt::format(
      "'{}' is turned by {:.4f}, {:.4f}, {:.4f} rad from its orientation; {:.4f}, {:.4f}, {:.4f} are allowed",
      around_.arm->link_name(bound.link), e.x, e.y, e.z, t.x, t.y, t.z);
}

std::string Goal::violated(std::span<const double> q) const {
  std::string why;
  const auto look = [&](const auto& bounds) {
    for (const auto& bound : bounds)
      if (why.empty()) why = violated(bound, q);
  };
  look(joints_), look(positions_), look(orientations_);
  return why;
}

std::vector<msg::ConstraintEvalResult> Goal::evaluate(std::span<const double> q) const {
  std::vector<msg::ConstraintEvalResult> out;
  for (const JointBound& bound : joints_)
    out.push_back({violated(bound, q).empty(), std::abs(q[bound.variable] - bound.value)});
  for (const PositionBound& bound : positions_)
    out.push_back({violated(bound, q).empty(), norm(around_.link_in_world(bound.link, q) * bound.offset -
                                                    bound.region.front().pose.position)});
  for (const OrientationBound& bound : orientations_)
    out.push_back({violated(bound, q).empty(),
                   angle_between(bound.target, around_.link_in_world(bound.link, q).rotation)});
  return out;
}

void Goal::narrow(std::vector<double>& lower, std::vector<double>& upper) const {
  for (const JointBound& bound : joints_) {
    lower[bound.variable] = std::max(lower[bound.variable], bound.low);
    upper[bound.variable] = std::min(upper[bound.variable], bound.high);
  }
}

int Goal::pose_link() const {
  const int link = positions_.empty() ? orientations_.front().link : positions_.front().link;
  const bool one =
      std::all_of(positions_.begin(), positions_.end(), [&](const auto& b) { return b.link == link; }) &&
      std::all_of(orientations_.begin(), orientations_.end(), [&](const auto& b) { return b.link == link; });
  if (!one || positions_.size() > 1 || orientations_.size() > 1)
    throw Refusal(Code::INVALID_GOAL_CONSTRAINTS,
                  "a goal may have one position and one orientation, of one link");
  return link;
}

planning::JointState Goal::joint_goal(const Group& group, std::span<const double> start) const {
  JointState q(start.begin(), start.end());
  const kinematics::Chain& chain = around_.arm->facts().chain;
  for (const JointBound& bound : joints_) {
    const std::string& joint = around_.arm->joints()[bound.variable];
    const double low = std::max(bound.low, chain.lower()[bound.variable]),
                 high = std::min(bound.high, chain.upper()[bound.variable]);
    if (low > high)
      throw Refusal(Code::INVALID_GOAL_CONSTRAINTS,
                    fmt::format("the goal of {} is {:.4f}, and its limits are {:.4f} to {:.4f}", joint,
                                bound.value, chain.lower()[bound.variable], chain.upper()[bound.variable]));
    if (!group.has(bound.variable)) {
      if (q[bound.variable] < low - kSlack || q[bound.variable] > high + kSlack)
        throw Refusal(Code::INVALID_GOAL_CONSTRAINTS,
                      fmt::format("{} does not belong to the group '{}'", joint, group.name));
      continue;
    }
    q[bound.variable] = std::clamp(bound.value, low, high);
  }
  return q;
}

std::vector<JointState> Goal::pose_goals(const Group& group, std::span<const double> start, bool wide) const {
  const int link = pose_link();
  if (!group.solvable)
    throw Refusal(Code::NO_IK_SOLUTION,
                  "the group '" + group.name +
                      "' has no inverse kinematics: its last link is not rigid with the tool link");
  const Arm& arm = *around_.arm;
  const Pose T_link_tcp = arm.tcp_in_link(link);
  const Pose to_chain =
      arm.facts().chain.base() * inverse(around_.base());  // the chain stands where the cell's file says
  std::vector<JointState> out;
  const auto keep = [&](const JointState& q) {
    if (out.size() >= kMostStates || !violated(q).empty()) return;
    for (std::size_t i = 0; i < q.size(); ++i)
      if (!group.has(i) && std::abs(q[i] - start[i]) > kSlack) return;
    out.push_back(q);
  };
  const std::optional<ik::InverseKinematics> made =
      arm.facts().solver ? std::nullopt
                         : std::optional<ik::InverseKinematics>(std::in_place, arm.facts().chain);
  const ik::InverseKinematics& solver = made ? *made : *arm.facts().solver;
  const auto try_pose = [&](const Pose& T_world_link) {
    for (const JointState& q : planning::goals_for(solver, to_chain * T_world_link * T_link_tcp, start))
      keep(q);
  };
  const PositionBound* position = positions_.empty() ? nullptr : &positions_.front();
  const OrientationBound* orientation = orientations_.empty() ? nullptr : &orientations_.front();
  const Quaternion turned = orientation ? orientation->target : around_.link_in_world(link, start).rotation;
  const auto pose_at = [&](const Vec3& point, const Quaternion& rotation) {
    return Pose{position ? point - rotation * position->offset : point, rotation};
  };
  const Vec3 middle =
      position ? position->region.front().pose.position : around_.link_in_world(link, start).position;
  if (position || orientation) try_pose(pose_at(middle, turned));
  if (!wide && !out.empty()) return out;
  // Partial poses: the free rows of the task are what the constraints leave.
  const Pose point = {position ? position->offset : Vec3{}, {}};
  const ik::InverseKinematics partial(kinematics::Chain(arm.model(), link, arm.facts().chain.base(), point));
  kinematics::IkTask task;
  const double room =
      position ? position->region.front().least() / std::sqrt(3.0) : kinematics::IkTask::kFree;
  const Vec3 turn = orientation ? orientation->tolerance : Vec3{10, 10, 10};
  const double turns[] = {turn.x, turn.y, turn.z};
  for (std::size_t row = 0; row < 6; ++row) {
    const double free = row < 3 ? room : turns[row - 3];
    if (free == kinematics::IkTask::kFree || (row >= 3 && free >= kFree))
      task.free(row);
    else
      task.low[row] = -free, task.high[row] = free;
  }
  const auto solutions = std::make_unique<kinematics::IkSolutions>();
  partial.solve_all(to_chain * Pose{middle, turned}, task, start, *solutions);
  for (const kinematics::IkSolution& s : *solutions)
    keep(JointState(s.q.begin(), s.q.begin() + static_cast<std::ptrdiff_t>(start.size())));
  // Poses drawn from tolerances and regions.
  kinematics::Random random(kSeed);
  for (int i = 0; i < kSamples && out.size() < kMostStates; ++i) {
    const auto drawn = [&](double t) {
      return random.between(-std::min(t, std::numbers::pi), std::min(t, std::numbers::pi));
    };
    const Vec3 vector{drawn(turn.x), drawn(turn.y), drawn(turn.z)};
    Vec3 at = middle;
    if (position) {
      const Solid& solid = position->region[static_cast<std::size_t>(i) % position->region.size()];
      const double z = solid.type == Primitive::CYLINDER ? solid.b
                       : solid.type == Primitive::SPHERE ? solid.a
                                                         : solid.c;
      const double y = solid.type == Primitive::BOX ? solid.b : solid.a;
      at = solid.pose * Vec3{random.between(-solid.a, solid.a), random.between(-y, y), random.between(-z, z)};
      if (!solid.contains(at)) continue;
    }
    const double angle = norm(vector);
    try_pose(pose_at(at, turned * (angle > 0 ? from_axis_angle(normalized(vector), angle) : Quaternion{})));
  }
  if (out.empty() && wide) {
    const std::string why = solver.explain(to_chain * pose_at(middle, turned) * T_link_tcp, start).reason;
    throw Refusal(Code::NO_IK_SOLUTION,
                  why.empty() ? "no joint state within limits keeps the constraints of the goal" : why);
  }
  return out;
}

std::vector<JointState> Goal::states(const Group& group, std::span<const double> start, bool wide) const {
  if (empty()) throw Refusal(Code::INVALID_GOAL_CONSTRAINTS, "the goal has no constraints");
  const JointState q = joint_goal(group, start);
  if (!has_poses()) return {q};
  return pose_goals(group, q, wide);
}

}  // namespace polyarm::move_group
