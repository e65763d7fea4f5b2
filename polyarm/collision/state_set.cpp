#include "polyarm/collision/state_set.hpp"

#include <algorithm>

#include "polyarm/collision/check_model.hpp"

namespace polyarm::collision {

namespace {
constexpr float kFarAway = 1e15f;  // its square is finite
}

StateSet::StateSet(const Checker& checker, std::span<const double> weights)
    : kernels_(checker.kernels()), variables_(checker.variables()), query_(variables_) {
  for (const double w : weights) weights_.push_back(static_cast<float>(w * w));
}

void StateSet::add(std::span<const double> q) {
  if (size_ % kBlock == 0) blocks_.emplace_back(kBlock * variables_, kFarAway);
  for (std::size_t j = 0; j < variables_; ++j)
    blocks_.back()[j * kBlock + size_ % kBlock] = static_cast<float>(q[j]);
  ++size_;
}

std::size_t StateSet::nearest(std::span<const double> q) noexcept {
  std::transform(q.begin(), q.end(), query_.begin(), [](double v) { return static_cast<float>(v); });
  std::size_t best = 0;
  float least = 0;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const std::size_t count = std::min(kBlock, size_ - b * kBlock);
    const std::size_t i =
        kernels_.nearest(blocks_[b].data(), kBlock, count, variables_, query_.data(), weights_.data());
    float sum = 0;
    for (std::size_t j = 0; j < variables_; ++j) {
      const float d = blocks_[b][j * kBlock + i] - query_[j];
      sum += weights_[j] * d * d;
    }
    if (b == 0 || sum < least) least = sum, best = b * kBlock + i;
  }
  return best;
}

}  // namespace polyarm::collision
