#include "polyarm/closed_form/planar_form.hpp"

#include <cmath>
#include <numbers>

namespace polyarm::kinematics {

namespace {

/// Rows x, y, z: maps into a frame whose z is `h` and whose x is as near to `toward` as possible.
Rotation into_frame(const Vec3& h, const Vec3& toward) noexcept {
  Vec3 x = toward - dot(toward, h) * h;
  if (norm(x) < 1e-6) {
    const Vec3 other = std::abs(h.z) < 0.8 ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
    x = other - dot(other, h) * h;
  }
  x = normalized(x);
  return transposed(Rotation{x, cross(h, x), h});
}

PlanarCircle circle_of(double s, double c, double least) noexcept {
  PlanarCircle out;
  out.radius = std::hypot(s, c);
  out.angle = std::atan2(s, c) / (2 * std::numbers::pi);
  out.usable = out.radius > least;
  out.over = out.usable ? 1 / out.radius : 0.0;
  out.s = s * out.over;
  out.c = c * out.over;
  return out;
}

/// v turned about h by an angle: the constant part, and the factors of cosine and sine.
TurnedVector turned_vector(const Vec3& h, const Vec3& v) noexcept {
  const Vec3 still = dot(h, v) * h;
  return {still, v - still, cross(h, v)};
}

/// Smaller components of unit vectors are rounding errors of zero.
bool nothing(double v) noexcept {
  return std::abs(v) < 5e-15;
}

/// `into_plane`: from the world to the plane's frame.
SquareBend square_bend(const SixAxisForm& form, const Rotation& into_plane, bool wrist) noexcept {
  SquareBend out;
  const Vec3 hub = wrist ? form.h[3] : form.h[1];
  Vec3 fifth = form.h[4];
  const Vec3 plane_hub = into_plane * hub, plane_fifth = into_plane * fifth;
  if (!nothing(dot(hub, fifth)) || !nothing(dot(fifth, form.h[5]))) return out;
  if (wrist && !(nothing(plane_hub.z) && nothing(plane_fifth.x) && nothing(plane_fifth.y))) return out;
  if (wrist && plane_fifth.z < 0) out.side_5 = -1, fifth = -fifth;
  const Vec3& from = wrist ? plane_hub : plane_fifth;
  out.hub_s = nothing(from.y) ? 0 : from.y;
  out.hub_c = nothing(from.x) ? 0 : from.x;
  out.six_s = dot(cross(hub, fifth), form.h[5]);
  out.six_c = dot(hub, form.h[5]);
  out.six_angle = std::atan2(out.six_s, out.six_c) / (2 * std::numbers::pi);
  out.least_sine2 = std::max(form.least_sine * form.least_sine, form.near_edge);
  out.usable = true;
  return out;
}

}  // namespace

bool planar_form(const SixAxisForm& form, PlanarForm& out) noexcept {
  out = {};
  const bool wrist = form.family == ArmFamily::wrist_2_parallel_3;
  if (!wrist && form.family != ArmFamily::parallel_234_5_meets_6) return false;
  const Vec3 &h1 = form.h[0], &h2 = form.h[1];
  out.wrist = wrist;
  out.into_base = into_frame(h1, h2);
  out.level = nothing(h1.x) && nothing(h1.y);
  const Vec3 second = out.into_base * h2;
  out.rise = second.x;
  out.rise_along = second.z;
  out.height = form.height;
  out.upright = nothing(second.z);
  // Its x is perpendicular to axes 1 and 2.
  const Vec3 level = transposed(out.into_base).y;
  const Rotation into_plane = transposed(Rotation{level, cross(h2, level), h2});
  const auto flat = [&](const Vec3& v) { return into_plane * v; };
  out.p12 = flat(form.p12);
  out.p23 = flat(form.p23);
  out.p34 = flat(form.p34);
  out.p45 = flat(form.p45);
  out.side_3 = form.side_3;
  out.side_4 = form.side_4;
  out.elbow = circle_of(form.elbow.s, form.elbow.c, form.elbow.least);
  out.elbow_half = form.elbow.half * out.elbow.over;
  const Vec3& hub = wrist ? form.h[3] : h2;
  const Rotation into_hub = wrist ? into_frame(hub, form.h[4]) : into_plane;
  out.into_hub = into_hub * transposed(into_plane);
  const Vec3 fifth = into_hub * form.h[4];
  out.square = square_bend(form, into_plane, wrist);
  const Vec3 beside_6 = out.square.usable ? out.square.side_5 * form.h[4] : form.beside_6;
  out.beside_in_tool = form.from_tool_rotation * beside_6;
  const auto about_5 = [&](const Vec3& v) { return turned_vector(fifth, into_hub * v); };
  out.six = about_5(form.h[5]);
  out.beside = about_5(beside_6);
  out.across = about_5(cross(form.h[5], beside_6));
  out.bend = circle_of(out.six.across.z, out.six.ahead.z, 1e-6);
  out.least_length2 = form.least_length * form.least_length;
  out.least_sine2 = form.least_sine * form.least_sine;
  out.near_edge = form.near_edge;
  out.usable = out.bend.usable && out.elbow.usable && out.rise > 1e-6;
  return out.usable;
}

}  // namespace polyarm::kinematics
