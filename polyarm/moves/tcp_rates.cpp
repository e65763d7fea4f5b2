#include "polyarm/moves/tcp_rates.hpp"

#include <array>
#include <cassert>
#include <utility>

namespace polyarm::moves {
namespace {

/// A vector and its first two derivatives.
struct Moving {
  Vec3 value, first, second;
};
Moving operator+(const Moving& a, const Moving& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
Moving cross(const Moving& a, const Moving& b) {
  using polyarm::cross;
  return {cross(a.value, b.value), cross(a.first, b.value) + cross(a.value, b.first),
          cross(a.second, b.value) + 2.0 * cross(a.first, b.first) + cross(a.value, b.second)};
}
/// A rate times a vector.
Moving times(const std::array<double, 3>& rate, const Moving& v) {
  return {rate[0] * v.value, rate[1] * v.value + rate[0] * v.first,
          rate[2] * v.value + 2 * rate[1] * v.first + rate[0] * v.second};
}

/// The motion of a body: the velocity of its point at the world's origin, and its angular velocity.
struct Twist {
  Moving origin, turn;
  /// For a vector or a point (with the origin's velocity) of the body, in its present position.
  Moving carry(const Vec3& v, bool point) const {
    Moving out{v, {}, {}};
    const Moving base = point ? origin : Moving{};
    out.first = base.value + polyarm::cross(turn.value, v);
    out.second = base.first + polyarm::cross(turn.first, v) + polyarm::cross(turn.value, out.first);
    return out;
  }
};

}  // namespace

TcpRates::TcpRates(const kinematics::Chain& chain)
    : joints_(chain.joints()),
      axes_(chain.axes()),
      zero_(chain.forward(std::vector<double>(chain.joints(), 0.0))) {}

paths::PoseDerivatives TcpRates::at(std::span<const double> q, std::span<const double> first,
                                    std::span<const double> second,
                                    std::span<const double> third) const noexcept {
  Pose moved;  // motion since joint zero, for the body after the axes so far
  Twist twist;
  for (const kinematics::Chain::Axis& axis : axes_) {
    const std::size_t j = axis.joint;
    const std::array<double, 3> rate{axis.ratio * first[j], axis.ratio * second[j], axis.ratio * third[j]};
    const Moving z = twist.carry(moved.rotation * axis.direction, false);
    const double value = axis.ratio * q[j];
    if (axis.slides) {
      twist.origin = twist.origin + times(rate, z);
      moved.position = moved.position + value * z.value;
      continue;
    }
    const Moving o = twist.carry(moved * axis.point, true);
    twist.origin = twist.origin + times(rate, cross(o, z));
    twist.turn = twist.turn + times(rate, z);
    moved.rotation = moved.rotation * from_axis_angle(axis.direction, value);
    moved.position = o.value - moved.rotation * axis.point;
  }
  paths::PoseDerivatives out;
  out.pose = moved * zero_;
  const Moving tcp = twist.carry(out.pose.position, true);
  const Moving velocity = twist.origin + cross(twist.turn, tcp);
  out.linear = {velocity.value, velocity.first, velocity.second};
  out.angular = {twist.turn.value, twist.turn.first, twist.turn.second};
  return out;
}

TcpPath::TcpPath(const kinematics::Chain& chain, std::shared_ptr<const paths::Path> joints, TcpPart part)
    : rates_(chain), path_(std::move(joints)), part_(part) {
  assert(path_->joints() == chain.joints());
}

void TcpPath::at(double s, const paths::PathDerivatives& out) const noexcept {
  std::array<double, kinematics::Chain::kMaxJoints> q, first, second, third;
  const std::size_t n = path_->joints();
  path_->at(s, {{q.data(), n}, {first.data(), n}, {second.data(), n}, {third.data(), n}});
  const paths::PoseDerivatives tcp =
      rates_.at({q.data(), n}, {first.data(), n}, {second.data(), n}, {third.data(), n});
  const auto fill = [](std::span<double> values, const Vec3& v) {
    if (!values.empty()) values[0] = v.x, values[1] = v.y, values[2] = v.z;
  };
  const bool moves = part_ == TcpPart::translation;
  const std::array<Vec3, 3>& rates = moves ? tcp.linear : tcp.angular;
  fill(out.q, moves ? tcp.pose.position : Vec3{});
  fill(out.first, rates[0]);
  fill(out.second, rates[1]);
  fill(out.third, rates[2]);
}

}  // namespace polyarm::moves
