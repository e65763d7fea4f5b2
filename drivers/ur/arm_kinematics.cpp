#include "drivers/ur/arm_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "drivers/wire/tcp.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::ur {

namespace {
using std::numbers::pi;

Pose about_z(double angle) {
  return {{}, from_axis_angle({0, 0, 1}, angle)};
}

/// From the axis of joint i to that of the next one.
Pose behind(const Kinematics& k, std::size_t i, double q) {
  return Pose{{0, 0, k.d[i]}, {}} * about_z(q + k.theta[i]) *
         Pose{{k.a[i], 0, 0}, from_axis_angle({1, 0, 0}, k.alpha[i])};
}
}  // namespace

double flange_difference(const Kinematics& kinematics, std::span<const JointLine> described) {
  constexpr int kStates = 64;
  double plain = 0, turned = 0;
  for (int state = 0; state < kStates; ++state) {
    Pose arm, link;
    for (std::size_t i = 0; i < described.size(); ++i) {
      const double q =
          2 * pi * std::fmod(0.5 + state * std::sqrt(2.0 + 3.0 * static_cast<double>(i)), 1.0) - pi;
      arm = arm * behind(kinematics, i, q);
      link = link * described[i].origin * Pose{{}, from_axis_angle(normalized(described[i].axis), q)};
    }
    plain = std::max(plain, norm(arm.position - link.position));
    turned = std::max(turned, norm(about_z(pi) * arm.position - link.position));
  }
  return std::min(plain, turned);
}

ArmAxes axes_of(const Kinematics& kinematics) {
  ArmAxes out;
  Pose at = about_z(pi);
  for (std::size_t i = 0; i < 6; ++i) {
    out.directions[i] = at.rotation * Vec3{0, 0, 1};
    out.points[i] = at.position;
    at = at * behind(kinematics, i, 0);
  }
  out.flange = at;
  return out;
}

Pose flange_jacobian(const Kinematics& kinematics, const std::array<double, 6>& q,
                     std::array<double, 36>& J) {
  std::array<Vec3, 6> directions, points;
  Pose at;
  for (std::size_t i = 0; i < 6; ++i) {
    directions[i] = at.rotation * Vec3{0, 0, 1};
    points[i] = at.position;
    at = at * behind(kinematics, i, q[i]);
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const Vec3 rate = cross(directions[i], at.position - points[i]);
    const double column[] = {rate.x, rate.y, rate.z, directions[i].x, directions[i].y, directions[i].z};
    for (std::size_t row = 0; row < 6; ++row) J[6 * row + i] = column[row];
  }
  return at;
}

Kinematics read_kinematics(const std::string& host, int port, Nanoseconds timeout) {
  std::string why;
  const Descriptor socket = wire::connect_tcp(host, port, timeout, why);
  if (!socket)
    throw Error("unreachable", "the controller at " + host + ", port " + std::to_string(port) + ": " + why,
                "check address and cable; at an e-Series enable the primary client interface");
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  PrimaryStream stream;
  std::optional<Kinematics> nominal, arm;
  std::array<std::uint8_t, 4096> bytes;
  while (!nominal || !arm) {
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0 || !wire::wait_readable(socket.number(), left)) break;
    const wire::Received got = wire::receive(socket.number(), bytes);
    if (got.got == wire::Got::nothing) continue;
    std::vector<PrimaryEvent> events;
    if (got.got != wire::Got::bytes || !stream.feed(wire::Bytes(bytes).first(got.count), events)) break;
    for (const PrimaryEvent& event : events) {
      if (event.kind == PrimaryEvent::Kind::configuration) nominal = event.kinematics;
      if (event.kind == PrimaryEvent::Kind::kinematics) arm = event.kinematics;
    }
  }
  if (!nominal || !arm)
    throw Error("no-answer", "the controller at " + host + " did not say how its arm is built",
                "is that the port of the primary interface (30001), and is the controller ready?");
  return arm->stated() ? *arm : *nominal;
}

}  // namespace polyarm::ur
