#include "drivers/franka/limits.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::franka {

namespace {

constexpr MotionLimits kPanda = {{2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61},
                                 {15, 7.5, 10, 12.5, 15, 20, 20},
                                 {7500, 3750, 5000, 6250, 7500, 10000, 10000},
                                 false};
constexpr MotionLimits kResearch3 = {{2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26},
                                     {10, 10, 10, 10, 10, 10, 10},
                                     {5000, 5000, 5000, 5000, 5000, 5000, 5000},
                                     true};

/// v = offset + sqrt(slope * way to the end), which a robot can brake from before the end.
struct Approach {
  double offset, slope, lower, upper;
};
constexpr Approach kApproach[7] = {{-0.30, 12.00, -2.7501, 2.7501}, {-0.20, 5.17, -1.7918, 1.7918},
                                   {-0.20, 7.00, -2.9065, 2.9065},  {-0.30, 8.00, -3.0481, -0.1458},
                                   {-0.35, 34.0, -2.8101, 2.8101},  {-0.35, 11.0, 0.54092, 4.5205},
                                   {-0.35, 34.0, -3.0196, 3.0196}};

}  // namespace

const MotionLimits& motion_limits(int version) noexcept {
  return version <= 5 ? kPanda : kResearch3;
}

VelocityBounds velocity_bounds(int version, std::size_t joint, double q) noexcept {
  const MotionLimits& limits = motion_limits(version);
  const double most = limits.velocity[joint];
  if (!limits.by_position) return {-most, most};
  const Approach& a = kApproach[joint];
  const auto bound = [&](double way) {
    return std::clamp(a.offset + std::sqrt(std::max(0.0, a.slope * way)), 0.0, most);
  };
  return {-bound(q - a.lower), bound(a.upper - q)};
}

}  // namespace polyarm::franka
