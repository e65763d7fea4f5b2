#include "polyarm/joint_control/forward_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::controllers {

ForwardMotion::ForwardMotion(timing::TimedPath path, std::vector<hardware::ForwardMove> moves, double begin)
    : path_(std::move(path)), moves_(std::move(moves)), sample_(path_.joints()), time_(begin) {}

double ForwardMotion::distance(double time, std::span<const double> measured, std::size_t& hint) noexcept {
  path_.sample(time, sample_, {}, {}, {}, hint);
  double sum = 0;
  for (std::size_t j = 0; j < sample_.size(); ++j) {
    const double off = sample_[j] - measured[j];
    sum += off * off;
  }
  return sum;
}

double ForwardMotion::find(std::span<const double> measured, double period) noexcept {
  constexpr int kAhead[] = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32};  // periods
  std::size_t hint = hint_;
  double best = time_, least = distance(time_, measured, hint);
  hint_ = hint;
  for (const int ahead : kAhead) {
    const double time = std::min(time_ + ahead * period, duration());
    if (const double off = distance(time, measured, hint); off < least) best = time, least = off;
  }
  return time_ = best;
}

double ForwardMotion::off_start(std::span<const double> measured) noexcept {
  std::size_t hint = 0;
  path_.sample(time_, sample_, {}, {}, {}, hint);
  double most = 0;
  for (std::size_t j = 0; j < sample_.size(); ++j) {
    const double off = std::abs(sample_[j] - measured[j]);
    if (!(off <= most)) most = off;
    if (std::isnan(most)) break;  // a joint that is not measured is nowhere
  }
  return most;
}

}  // namespace polyarm::controllers
