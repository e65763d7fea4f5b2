#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "polyarm/collision/check_data.hpp"
#include "polyarm/collision/check_model.hpp"
#include "polyarm/collision/checker.hpp"

namespace polyarm::collision {

namespace {

constexpr std::size_t kMostOpen = 1024;   // intervals of an edge that wait
constexpr double kMarginRounding = 1e-6;  // relative: margins are rounded up to single precision

std::uint32_t first_lanes(std::size_t count) {
  return count >= 32 ? 0xffffffffu : (1u << count) - 1;
}

}  // namespace

Probe::Probe(const Checker& checker) : checker_(checker), width_(checker.width()) {
  const std::size_t scratch = scratch_floats(checker.data().model, width_);
  states_at_ = scratch;
  margins_at_ = states_at_ + checker.variables() * width_;
  memory_.assign(margins_at_ + checker.rows() * width_ + 16, 0);
  void* start = memory_.data();
  std::size_t space = memory_.size() * sizeof(float);
  aligned_ = static_cast<float*>(std::align(64, sizeof(float), start, space));
  rows_.assign(checker.rows(), 0);
  scaled_.assign(checker.rows(), 0);
  state_.assign(checker.variables(), 0);
  size_.assign(checker.variables(), 0);
  open_.reserve(kMostOpen);
}

void Probe::fill_state(std::size_t lane, std::span<const double> q) noexcept {
  float* states = floats(states_at_);
  for (std::size_t j = 0; j < q.size(); ++j) states[j * width_ + lane] = checker_.value(j, q[j]);
}

bool Probe::touches(std::span<const double> q) noexcept {
  if (!checker_.usable(q)) return true;
  float* row = floats(states_at_);
  for (std::size_t j = 0; j < q.size(); ++j, row += width_) std::fill_n(row, width_, checker_.value(j, q[j]));
  return checker_.kernels()
             .check(checker_.data().model, {floats(states_at_), nullptr, 1, true}, aligned_)
             .touching != 0;
}

void Probe::touches(std::span<const double> states, std::span<std::uint8_t> out) noexcept {
  const std::size_t n = checker_.variables();
  for (std::size_t first = 0; first < out.size(); first += width_) {
    const std::size_t count = std::min(width_, out.size() - first);
    std::uint32_t unusable = 0;
    for (std::size_t lane = 0; lane < width_; ++lane) {
      const std::span<const double> q = states.subspan((first + std::min(lane, count - 1)) * n, n);
      if (!checker_.usable(q)) unusable |= 1u << lane;
      fill_state(lane, q);
    }
    const std::uint32_t touching =
        unusable |
        checker_.kernels()
            .check(checker_.data().model, {floats(states_at_), nullptr, first_lanes(count), false}, aligned_)
            .touching;
    for (std::size_t lane = 0; lane < count; ++lane) out[first + lane] = (touching >> lane) & 1;
  }
}

void Probe::fill_line(std::span<const double> from, std::span<const double> to, const Interval* intervals,
                      std::size_t count) noexcept {
  float* states = floats(states_at_);
  for (std::size_t j = 0; j < from.size(); ++j) {
    const float begin = checker_.value(j, from[j]), way = static_cast<float>(to[j] - from[j]);
    float* row = states + j * width_;
    for (std::size_t i = 0; i < width_; ++i)
      row[i] = begin + way * static_cast<float>(intervals[std::min(i, count - 1)].middle);
  }
}

bool Probe::sampled_edge(std::span<const double> from, std::span<const double> to,
                         std::size_t states) noexcept {
  if (!checker_.usable(from) || !checker_.usable(to)) return false;
  const std::size_t rounds = std::max<std::size_t>(1, (states + width_ - 1) / width_);
  float* row = floats(states_at_);
  for (std::size_t j = 0; j < from.size(); ++j, row += width_) {
    const float begin = checker_.value(j, from[j]), way = static_cast<float>(to[j] - from[j]);
    for (std::size_t i = 0; i < width_; ++i) row[i] = begin + way * (float(i + 1) / float(width_));
  }
  for (std::size_t round = 0; round < rounds; ++round) {
    const CheckJob job{floats(states_at_), nullptr, first_lanes(width_), true};
    if (checker_.kernels().check(checker_.data().model, job, aligned_).touching) return false;
    row = floats(states_at_);
    for (std::size_t j = 0; j < from.size(); ++j, row += width_) {
      const float step = static_cast<float>((to[j] - from[j]) / double(width_ * rounds));
      for (std::size_t i = 0; i < width_; ++i) row[i] -= step;
    }
  }
  return true;
}

EdgeAnswer Probe::edge(std::span<const double> from, std::span<const double> to,
                       const EdgeOptions& options) noexcept {
  EdgeAnswer out;
  if (!checker_.usable(from) || !checker_.usable(to))
    return {EdgeVerdict::touches, checker_.usable(from) ? 1.0 : 0.0, 0};
  for (std::size_t j = 0; j < from.size(); ++j) size_[j] = std::abs(to[j] - from[j]);
  checker_.motion(size_, rows_);
  const double most = rows_.empty() ? 0 : *std::max_element(rows_.begin(), rows_.end());
  std::array<Interval, 32> now;
  std::size_t count = width_;
  for (std::size_t i = 0; i < count; ++i) now[i] = {(double(i) + 0.5) / double(count), 0.5 / double(count)};
  open_.clear();
  for (;;) {
    fill_line(from, to, now.data(), count);
    float* margins = floats(margins_at_);
    for (std::size_t r = 0; r < rows_.size(); ++r)
      for (std::size_t i = 0; i < width_; ++i)
        margins[r * width_ + i] =
            static_cast<float>(rows_[r] * now[std::min(i, count - 1)].half * (1 + kMarginRounding));
    const CheckJob job{floats(states_at_), margins, first_lanes(count), !options.exact};
    const CheckAnswer answer = checker_.kernels().check(checker_.data().model, job, aligned_);
    ++out.calls;
    if (answer.touching && !options.exact) {
      std::size_t lane = 0;
      while (!((answer.touching >> lane) & 1)) ++lane;
      return {EdgeVerdict::touches, now[lane].middle, out.calls};
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (!((answer.near >> i) & 1)) continue;
      bool open = true;
      if (options.exact) {
        for (std::size_t j = 0; j < from.size(); ++j) state_[j] = from[j] + now[i].middle * (to[j] - from[j]);
        for (std::size_t r = 0; r < rows_.size(); ++r) scaled_[r] = rows_[r] * now[i].half;
        const ExactVerdict verdict = exact(state_, scaled_);
        if (verdict == ExactVerdict::touches) return {EdgeVerdict::touches, now[i].middle, out.calls};
        open = verdict == ExactVerdict::near;
      }
      if (!open) continue;
      if (!(most * now[i].half > options.resolution) || open_.size() >= kMostOpen)
        return {EdgeVerdict::close, now[i].middle, out.calls};
      open_.push_back(now[i]);
    }
    if (open_.empty()) return out;
    if (out.calls >= options.most_calls) return {EdgeVerdict::close, open_.back().middle, out.calls};
    const std::size_t taken = std::min(open_.size(), width_ / 2), parts = width_ / taken;
    count = 0;
    for (std::size_t k = 0; k < taken; ++k) {
      const Interval whole = open_.back();
      open_.pop_back();
      const double half = whole.half / double(parts);
      for (std::size_t p = 0; p < parts; ++p)
        now[count++] = {whole.middle + (2.0 * double(p) + 1 - double(parts)) * half, half};
    }
  }
}

bool Probe::proven_around(std::span<const double> states, std::span<const double> sizes,
                          bool use_exact) noexcept {
  const std::size_t n = checker_.variables(), all = n > 0 ? states.size() / n : 0;
  float* margins = floats(margins_at_);
  for (std::size_t first = 0; first < all; first += width_) {
    const std::size_t count = std::min(width_, all - first);
    for (std::size_t lane = 0; lane < width_; ++lane) {
      const std::size_t from = (first + std::min(lane, count - 1)) * n;
      if (!checker_.usable(states.subspan(from, n))) return false;
      fill_state(lane, states.subspan(from, n));
      checker_.motion(sizes.subspan(from, n), rows_);
      for (std::size_t r = 0; r < rows_.size(); ++r)
        margins[r * width_ + lane] = static_cast<float>(rows_[r] * (1 + kMarginRounding));
    }
    const CheckJob job{floats(states_at_), margins, first_lanes(count), !use_exact};
    const std::uint32_t near = checker_.kernels().check(checker_.data().model, job, aligned_).near;
    if (near && !use_exact) return false;
    for (std::size_t lane = 0; lane < count; ++lane) {
      if (!((near >> lane) & 1)) continue;
      checker_.motion(sizes.subspan((first + lane) * n, n), rows_);
      if (exact(states.subspan((first + lane) * n, n), rows_) != ExactVerdict::free) return false;
    }
  }
  return true;
}

}  // namespace polyarm::collision
