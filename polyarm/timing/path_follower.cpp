#include "polyarm/timing/path_follower.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::timing {
namespace {

TimedPath not_empty(TimedPath path) {
  if (path.empty()) throw Error("empty-path", "there is no path to follow");
  return path;
}

/// A step back ends this close to its goal, s of the plan; and its deceleration, per s.
constexpr double kNear = 1e-4, kSlowingDown = 0.5;

}  // namespace

PathFollower::PathFollower(TimedPath path, std::vector<trajectory::MotionLimits> limits, double period_s)
    : path_(not_empty(std::move(path))),
      limits_(std::move(limits)),
      period_(period_s),
      override_(path_, limits_, period_s) {}

void PathFollower::start_at(double time) noexcept {
  start_ = std::clamp(time, 0.0, path_.duration());
  override_.begin(start_, 0);
}

void PathFollower::begin(double target) noexcept {
  if (start_ > 0) return override_.begin(start_, 0);
  std::size_t hint = 0;
  const PathMotion start = path_.profile().at(0, hint);
  const bool at_rest = start.speed == 0 && start.acceleration == 0;
  override_.begin(0, at_rest && target > 0 ? target : 0);
}

void PathFollower::step_back(double time, double way) noexcept {
  std::size_t hint = 0;
  const SpeedProfile& profile = path_.profile();
  back_to_ =
      std::max({0.0, override_.time() - time, profile.time_at(profile.at(override_.time(), hint).s - way)});
  stepping_back_ = override_.time() > back_to_ + kNear;
}

void PathFollower::advance_back(double share) noexcept {
  const double left = stepping_back_ ? override_.time() - back_to_ : 0;
  override_.advance(left > kNear ? -std::min(share, std::sqrt(2 * kSlowingDown * left)) : 0);
  if (left <= kNear && override_.stands()) stepping_back_ = false;
}

}  // namespace polyarm::timing
