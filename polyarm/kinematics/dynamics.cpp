#include "polyarm/kinematics/dynamics.hpp"

namespace polyarm::kinematics {
namespace {

/// The kernels for one state or for a batch.
const TreeKernels& tree_kernels(InstructionSet set, bool many) noexcept {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return many ? avx512::many::kTreeKernels : avx512::single::kTreeKernels;
  if (set == InstructionSet::avx2) return many ? avx2::many::kTreeKernels : avx2::single::kTreeKernels;
#endif
  return many ? portable::many::kTreeKernels : portable::single::kTreeKernels;
}

TreeJob job(std::span<const double> q, std::span<const double> v, std::span<const double> in,
            std::span<double> out, std::size_t states = 1,
            BatchLayout layout = BatchLayout::state_after_state) noexcept {
  const auto data = [](std::span<const double> s) { return s.empty() ? nullptr : s.data(); };
  return {data(q), data(v), data(in), out.data(), states, layout == BatchLayout::state_after_state};
}

}  // namespace

Dynamics::Dynamics(const Tree& tree, InstructionSet set)
    : tree_{tree}, set_{supported(set)}, one_{&tree_kernels(set_, false)}, many_{&tree_kernels(set_, true)} {
  scratch_.resize(many_->scratch_lanes(tree_.model()));
}

void Dynamics::inverse(std::span<const double> q, std::span<const double> v, std::span<const double> a,
                       std::span<double> tau) noexcept {
  one_->inverse(tree_.model(), scratch(), job(q, v, a, tau));
}

void Dynamics::gravity(std::span<const double> q, std::span<double> tau) noexcept {
  one_->inverse(tree_.model(), scratch(), job(q, {}, {}, tau));
}

void Dynamics::bias(std::span<const double> q, std::span<const double> v, std::span<double> tau) noexcept {
  one_->inverse(tree_.model(), scratch(), job(q, v, {}, tau));
}

void Dynamics::mass_matrix(std::span<const double> q, std::span<double> M) noexcept {
  one_->mass(tree_.model(), scratch(), job(q, {}, {}, M));
}

bool Dynamics::forward(std::span<const double> q, std::span<const double> v, std::span<const double> tau,
                       std::span<double> a) noexcept {
  return one_->forward(tree_.model(), scratch(), job(q, v, tau, a));
}

void Dynamics::inverse_batch(BatchLayout layout, std::size_t states, std::span<const double> q,
                             std::span<const double> v, std::span<const double> a,
                             std::span<double> tau) noexcept {
  many_->inverse(tree_.model(), scratch(), job(q, v, a, tau, states, layout));
}

void Dynamics::gravity_batch(BatchLayout layout, std::size_t states, std::span<const double> q,
                             std::span<double> tau) noexcept {
  many_->inverse(tree_.model(), scratch(), job(q, {}, {}, tau, states, layout));
}

void Dynamics::mass_matrix_batch(BatchLayout layout, std::size_t states, std::span<const double> q,
                                 std::span<double> M) noexcept {
  many_->mass(tree_.model(), scratch(), job(q, {}, {}, M, states, layout));
}

bool Dynamics::forward_batch(BatchLayout layout, std::size_t states, std::span<const double> q,
                             std::span<const double> v, std::span<const double> tau,
                             std::span<double> a) noexcept {
  return many_->forward(tree_.model(), scratch(), job(q, v, tau, a, states, layout));
}

}  // namespace polyarm::kinematics
