#pragma once
/// A growing set of joint states that finds the one nearest to a state, in lanes. Single precision; weights
/// of joints in the distance. One thread at a time. add() allocates now and then.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/collision/checker.hpp"

namespace polyarm::collision {

class StateSet {
 public:
  /// `weights`: of each joint's difference, per rad or m; as many as the states have values.
  StateSet(const Checker& checker, std::span<const double> weights);

  std::size_t size() const noexcept { return size_; }
  void add(std::span<const double> q);
  /// The index of the nearest state, of nearly equal ones any. Precondition: not empty.
  std::size_t nearest(std::span<const double> q) noexcept;

 private:
  static constexpr std::size_t kBlock = 512;  // states that lie together
  const CheckKernels& kernels_;
  std::size_t variables_, size_ = 0;
  std::vector<float> weights_, query_;  // squared weights
  std::vector<std::vector<float>> blocks_;
};

}  // namespace polyarm::collision
