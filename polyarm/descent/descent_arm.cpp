#include <algorithm>
#include <cmath>
#include <iterator>

#include "polyarm/base/error.hpp"
#include "polyarm/descent/descent_lanes.hpp"

namespace polyarm::kinematics {

using Bend = DescentArm::Bend;

namespace {

constexpr std::size_t kMostAxes = 64;  // the capacity of sweep()

Vec3 any_square_to(const Vec3& v) {
  const Vec3 least = std::abs(v.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return normalized(cross(v, least));
}

/// The common perpendicular of two axes as x of the frame between them; `before` if they are parallel.
Vec3 between(const Vec3& a, const Vec3& b, const Vec3& before) {
  const Vec3 n = cross(a, b);
  const Vec3 x = norm(n) < 1e-12 ? before : n;
  const Vec3 square = x - dot(x, a) * a;
  return norm(square) < 1e-14 ? any_square_to(a) : normalized(square);
}

Rotation frame_with(const Vec3& x, const Vec3& z) {
  const Vec3 square = normalized(x - dot(x, z) * z);
  return {square, cross(z, square), z};
}

Bend bend_of(double cosine, double sine) {
  constexpr double kNone = 1e-14;
  if (std::abs(sine) < kNone) return cosine > 0 ? Bend::none : Bend::back;
  if (std::abs(cosine) < kNone) return sine > 0 ? Bend::left : Bend::right;
  return Bend::any;
}

double length_of(const Chain& chain) {
  const double reach = chain.reach();
  return std::isfinite(reach) && reach > 1e-6 ? reach / 2 : 0.5;
}

DescentArm::Single side_by_side(const DescentArm& arm) {
  DescentArm::Single out;
  if (arm.axes.empty() || arm.axes.size() > std::size(out.turns) || arm.axes.size() != arm.joints) return out;
  out.possible = true;
  for (std::size_t i = 0; i < arm.axes.size(); ++i) {
    const DescentArm::Axis& axis = arm.axes[i];
    out.possible = out.possible && axis.joint == i && axis.ratio == 1;
    out.slides = out.slides || axis.slides;
    out.turns[i] = axis.slides ? 0 : 1;
    out.offset[i] = axis.offset;
    out.lower[i] = arm.lower[i];
    out.upper[i] = arm.upper[i];
  }
  return out;
}

}  // namespace

DescentArm::DescentArm(const Chain& chain) : length{length_of(chain)} {
  const std::vector<Chain::Axis> found = chain.axes();
  if (found.size() > kMostAxes)
    throw Error("bad-model", "more than 64 joints and followers lie between base and tool",
                "use a shorter chain");
  std::array<int, Chain::kMaxJoints> place;
  place.fill(-1);
  for (const Chain::Axis& axis : found) {
    if (place[axis.joint] >= 0) continue;
    place[axis.joint] = static_cast<int>(joints);
    chain_joint[joints] = axis.joint;
    unit[joints] = chain.slides(axis.joint) ? length : 1.0;
    const double low = chain.lower()[axis.joint], high = chain.upper()[axis.joint];
    const bool whole_turn = chain.period(axis.joint) > 0 && high - low >= chain.period(axis.joint);
    lower[joints] = whole_turn ? -1e9 : std::max(-1e9, low / unit[joints]);
    upper[joints] = whole_turn ? 1e9 : std::min(1e9, high / unit[joints]);
    ++joints;
  }
  const Pose tool = chain.forward(std::vector<double>(chain.joints(), 0.0));
  const Rotation tool_turn = rotation_of(tool.rotation);
  std::array<bool, Chain::kMaxJoints> seen{};
  Vec3 x = found.empty() ? Vec3{1, 0, 0} : any_square_to(found[0].direction);
  if (!found.empty()) {
    first_turn = frame_with(x, found[0].direction);
    first_point = (1 / length) * found[0].point;
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Chain::Axis& from = found[i];
    const Vec3& z = from.direction;
    Axis out;
    out.joint = static_cast<std::size_t>(place[from.joint]);
    out.slides = from.slides;
    out.first_of_joint = !seen[out.joint];
    seen[out.joint] = true;
    out.ratio = from.ratio * unit[out.joint] / (from.slides ? length : 1.0);
    if (i > 0) {
      const Rotation before = frame_with(x, found[i - 1].direction);
      out.bend_cos = dot(before.z, z);
      out.bend_sin = -dot(before.y, z);
      out.bend = bend_of(out.bend_cos, out.bend_sin);
      const double size = std::hypot(out.bend_cos, out.bend_sin);
      out.bend_cos /= size, out.bend_sin /= size;
    }
    const bool last = i + 1 == found.size();
    const Vec3 next = last ? x : between(z, found[i + 1].direction, x);
    const Rotation here = frame_with(x, z), there = frame_with(next, z);
    out.offset = std::atan2(dot(here.y, there.x), dot(here.x, there.x));
    out.offset_cos = std::cos(out.offset), out.offset_sin = std::sin(out.offset);
    const Vec3 step = (1 / length) * ((last ? tool.position : found[i + 1].point) - from.point);
    out.step = transposed(there) * step;
    for (double* value : {&out.step.x, &out.step.y, &out.step.z})
      if (std::abs(*value) < 1e-15) *value = 0;
    if (last) last_turn = transposed(there) * tool_turn;
    x = next;
    axes.push_back(out);
  }
  if (axes.empty()) last_turn = tool_turn;
  single = side_by_side(*this);
}

}  // namespace polyarm::kinematics
