#include "polyarm/trajectory/path_follower.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::trajectory {
namespace {

TimedPath not_empty(TimedPath path) {
  if (path.empty()) throw Error("empty-path", "there is no path to follow");
  return path;
}

}  // namespace

PathFollower::PathFollower(TimedPath path, std::vector<MotionLimits> limits, double period_s)
    : path_(not_empty(std::move(path))),
      limits_(std::move(limits)),
      period_(period_s),
      override_(path_, limits_, period_s) {}

void PathFollower::begin(double target) noexcept {
  std::size_t hint = 0;
  const PathMotion start = path_.profile().at(0, hint);
  const bool at_rest = start.speed == 0 && start.acceleration == 0;
  override_.begin(0, at_rest && target > 0 ? target : 0);
}

}  // namespace polyarm::trajectory
