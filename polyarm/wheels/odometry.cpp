#include "polyarm/wheels/odometry.hpp"

#include <cmath>
#include <numeric>

namespace polyarm::controllers {

namespace {
constexpr double kShortest = 1e-6;  // s
}

void RollingMean::add(double value) noexcept {
  if (count_ == values_.size())
    sum_ -= values_[next_];
  else
    ++count_;
  values_[next_] = value;
  sum_ += value;
  if (++next_ < values_.size()) return;
  next_ = 0;
  sum_ = std::accumulate(values_.begin(), values_.end(), 0.0);  // so that rounding does not add up
}

void Odometry::configure(double separation, double left_radius, double right_radius, std::size_t window) {
  separation_ = separation;
  left_radius_ = left_radius;
  right_radius_ = right_radius;
  linear_mean_ = angular_mean_ = RollingMean(window);
  linear_ = angular_ = 0;
  start(0, 0);
  set_pose(0, 0, 0);
}

bool Odometry::update_from_positions(double left, double right, double dt) noexcept {
  if (!(dt >= kShortest) || !update_from_velocities((left - left_) / dt, (right - right_) / dt, dt))
    return false;
  start(left, right);
  return true;
}

bool Odometry::update_from_velocities(double left, double right, double dt) noexcept {
  const double linear = (left * left_radius_ + right * right_radius_) / 2;
  const double angular = (right * right_radius_ - left * left_radius_) / separation_;
  if (!(dt >= kShortest) || !std::isfinite(linear) || !std::isfinite(angular)) return false;
  integrate(linear * dt, angular * dt);
  linear_mean_.add(linear);
  angular_mean_.add(angular);
  linear_ = linear_mean_.mean();
  angular_ = angular_mean_.mean();
  return true;
}

bool Odometry::update_open_loop(double linear, double angular, double dt) noexcept {
  if (!(dt >= kShortest) || !std::isfinite(linear) || !std::isfinite(angular)) return false;
  integrate(linear * dt, angular * dt);
  linear_ = linear;
  angular_ = angular;
  return true;
}

void Odometry::set_pose(double x, double y, double heading) noexcept {
  x_ = x;
  y_ = y;
  heading_ = heading;
  linear_mean_.clear();
  angular_mean_.clear();
}

/// Along an arc: its chord points half the turn ahead and is distance * sin(turn / 2) / (turn / 2) long.
void Odometry::integrate(double distance, double turn) noexcept {
  const double half = turn / 2;
  const double chord = std::abs(half) < 1e-9 ? distance : distance * std::sin(half) / half;
  x_ += chord * std::cos(heading_ + half);
  y_ += chord * std::sin(heading_ + half);
  heading_ += turn;
}

}  // namespace polyarm::controllers
