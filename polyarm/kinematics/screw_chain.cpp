#include "polyarm/kinematics/screw_chain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::kinematics {
namespace {

/// Directions and offsets (m) below this count as zero: they are rounding errors.
constexpr double kNothing = 5e-15;

using Matrix = std::array<double, 9>;  // columns

Vec3 without_noise(Vec3 v) {
  for (double* c : {&v.x, &v.y, &v.z})
    if (std::abs(*c) < kNothing) *c = 0;
  return v;
}

Matrix columns_of(const Quaternion& r) {
  const auto column = [&](const Vec3& v) { return normalized(without_noise(r * v)); };
  const Vec3 x = column({1, 0, 0}), y = column({0, 1, 0}), z = column({0, 0, 1});
  return {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z};
}

Turn turn_about(const Vec3& h) {
  if (h.y == 0 && h.z == 0) return Turn::x;
  if (h.z == 0 && h.x == 0) return Turn::y;
  if (h.x == 0 && h.y == 0) return Turn::z;
  return Turn::any;
}

/// The reference axes about which the most joints turn: the world's, or those of one of the joints.
Quaternion reference_axes(std::span<const ScrewAxis> axes) {
  std::vector<Quaternion> candidates{{}};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Quaternion upright = rotation_between({0, 0, 1}, axes[i].direction);
    candidates.push_back(upright);
    if (i == 0) continue;
    const Vec3 across = cross(axes[i].direction, axes[i - 1].direction);
    if (norm(across) < 0.1) continue;
    const Vec3 level = inverse(upright) * normalized(across);
    candidates.push_back(normalized(upright * rotation_between({1, 0, 0}, level)));
  }
  const auto aligned = [&](const Quaternion& r) {
    return std::count_if(axes.begin(), axes.end(), [&](const ScrewAxis& axis) {
      return !axis.slides && turn_about(without_noise(inverse(r) * axis.direction)) != Turn::any;
    });
  };
  return *std::max_element(candidates.begin(), candidates.end(),
                           [&](const auto& a, const auto& b) { return aligned(a) < aligned(b); });
}

void write(double* to, const Vec3& v) {
  to[0] = v.x, to[1] = v.y, to[2] = v.z;
}

/// Bit mask of the components that are not zero.
unsigned components(const double* v) {
  return (v[0] != 0 ? 1u : 0u) | (v[1] != 0 ? 2u : 0u) | (v[2] != 0 ? 4u : 0u);
}

/// The reference axis that a column equals.
Turn axis_of(const double* column) {
  return column[0] == 1 ? Turn::x : column[1] == 1 ? Turn::y : column[2] == 1 ? Turn::z : Turn::any;
}

ScrewBlock block_of(std::span<const ScrewStep> steps) {
  ScrewBlock out;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const ScrewStep& step = steps[i];
    out.ratio[i] = step.ratio;
    out.joint[i] = static_cast<std::uint32_t>(step.joint);
    out.turns[i] = step.turn == Turn::none ? 0 : 1;
    for (std::size_t c = 0; c < 3; ++c) out.h[c][i] = step.h[c];
    out.any |= step.turn == Turn::any;
    out.slides |= step.turn == Turn::none;
  }
  for (std::size_t i = steps.size(); i < kScrewBlock; ++i) out.joint[i] = out.joint[0];
  return out;
}

/// Transforms world-aligned columns at `tcp` to another frame.
void express(JacobianFrame frame, const Pose& tcp, std::size_t n, double* J) {
  for (std::size_t j = 0; j < n; ++j) {
    Vec3 linear{J[j], J[n + j], J[2 * n + j]}, angular{J[3 * n + j], J[4 * n + j], J[5 * n + j]};
    if (frame == JacobianFrame::space) {
      linear = linear + cross(tcp.position, angular);
    } else {
      linear = inverse(tcp.rotation) * linear;
      angular = inverse(tcp.rotation) * angular;
    }
    const double column[] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    for (std::size_t r = 0; r < 6; ++r) J[r * n + j] = column[r];
  }
}

}  // namespace

const ScrewKernels& screw_kernels(InstructionSet set) noexcept {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return avx512::kScrewKernels;
  if (set == InstructionSet::avx2) return avx2::kScrewKernels;
#endif
  return portable::kScrewKernels;
}

ScrewChain::ScrewChain(std::span<const ScrewAxis> axes, std::size_t joints, const Pose& T_world_tcp,
                       const Vec3& base, InstructionSet set)
    : set_{supported(set)}, kernels_{&screw_kernels(set_)} {
  if (joints > kMostVariables)
    throw Error(
        "bad-model",
        "a chain of " + std::to_string(joints) + " joints; there may be " + std::to_string(kMostVariables),
        "leave out joints that do not lie between base and tip");
  const Quaternion reference = reference_axes(axes);
  const Quaternion back = inverse(reference);
  auto kept = std::make_shared<Steps>();
  Vec3 at = base;
  std::vector<int> uses(joints, 0);
  for (const ScrewAxis& axis : axes) {
    ScrewStep step{axis.slides ? Turn::none : Turn::any, 0, axis.joint, axis.ratio, {}, {}};
    Vec3 h = normalized(without_noise(back * axis.direction));
    if (!axis.slides) step.turn = turn_about(h);
    if (step.turn != Turn::any && h.x + h.y + h.z < 0 && !axis.slides) h = -h, step.ratio = -axis.ratio;
    // Any point of a turning axis is valid; the one level with the previous point gives an offset of zero.
    Vec3 point = axis.point;
    if (!axis.slides) point = point - dot(point - at, axis.direction) * axis.direction;
    write(step.h, h);
    write(step.p, without_noise(back * (point - at)));
    step.along = components(step.p);
    at = point;
    kept->step.push_back(step);
    ++uses.at(axis.joint);
  }
  const std::vector<ScrewStep>& steps = kept->step;
  for (std::size_t k = 0; k < steps.size(); k += kScrewBlock)
    kept->block.push_back(block_of(std::span(steps).subspan(k, std::min(kScrewBlock, steps.size() - k))));
  model_.step = steps.data();
  model_.block = kept->block.data();
  model_.steps = steps.size();
  model_.joints = joints;
  std::copy_n(columns_of(reference).begin(), 9, model_.start);
  write(model_.base, base);
  std::copy_n(columns_of(normalized(back * T_world_tcp.rotation)).begin(), 9, model_.tool);
  write(model_.tool_offset, without_noise(back * (T_world_tcp.position - at)));
  model_.tool_along = components(model_.tool_offset);
  for (std::size_t c = 0; c < 3; ++c) model_.tool_axis[c] = axis_of(model_.tool + 3 * c);
  model_.distinct = std::all_of(uses.begin(), uses.end(), [](int n) { return n <= 1; });
  model_.packed = model_.distinct && steps.size() == joints;
  for (std::size_t k = 0; k < steps.size(); ++k) model_.packed = model_.packed && steps[k].joint == k;
  steps_ = std::move(kept);
}

StateBatch ScrewChain::batch_of(std::span<const double> q, BatchLayout layout,
                                std::size_t count) const noexcept {
  if (layout == BatchLayout::joint_after_joint) return {q.data(), count, count, 1};
  return {q.data(), count, 1, model_.joints};
}

Pose ScrewChain::forward(std::span<const double> q) const noexcept {
  Pose out;
  kernels_->forward(model_, q.data(), out);
  return out;
}

Pose ScrewChain::jacobian(std::span<const double> q, std::span<double> J,
                          JacobianFrame frame) const noexcept {
  Pose out;
  kernels_->jacobian(model_, q.data(), J.data(), out);
  if (frame != JacobianFrame::local_world_aligned) express(frame, out, model_.joints, J.data());
  return out;
}

void ScrewChain::forward_batch(std::span<const double> q, BatchLayout layout,
                               std::span<Pose> out) const noexcept {
  kernels_->forward_batch(model_, batch_of(q, layout, out.size()), out.data());
}

void ScrewChain::jacobian_batch(std::span<const double> q, BatchLayout layout, std::span<double> J,
                                std::span<Pose> out) const noexcept {
  kernels_->jacobian_batch(model_, batch_of(q, layout, out.size()), J.data(), out.data());
}

}  // namespace polyarm::kinematics
