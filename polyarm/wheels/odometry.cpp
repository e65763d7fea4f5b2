#include "polyarm/wheels/odometry.hpp"

#include <cmath>
#include <numeric>

namespace polyarm::controllers {

namespace {
constexpr double kShortest = 1e-6;  // s

bool usable(const PlanarTwist& twist, double dt) noexcept {
  return dt >= kShortest && std::isfinite(twist.x) && std::isfinite(twist.y) && std::isfinite(twist.angular);
}
}  // namespace

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

void PlanarOdometry::configure(std::size_t window) {
  x_mean_ = y_mean_ = angular_mean_ = RollingMean(window);
  twist_ = {};
  set_pose(0, 0, 0);
}

bool PlanarOdometry::update(const PlanarTwist& measured, double dt) noexcept {
  if (!usable(measured, dt)) return false;
  integrate(measured.x * dt, measured.y * dt, measured.angular * dt);
  x_mean_.add(measured.x);
  y_mean_.add(measured.y);
  angular_mean_.add(measured.angular);
  twist_ = {x_mean_.mean(), y_mean_.mean(), angular_mean_.mean()};
  return true;
}

bool PlanarOdometry::update_open_loop(const PlanarTwist& commanded, double dt) noexcept {
  if (!usable(commanded, dt)) return false;
  integrate(commanded.x * dt, commanded.y * dt, commanded.angular * dt);
  twist_ = commanded;
  return true;
}

void PlanarOdometry::set_pose(double x, double y, double heading) noexcept {
  x_ = x;
  y_ = y;
  heading_ = heading;
  x_mean_.clear();
  y_mean_.clear();
  angular_mean_.clear();
}

/// Along an arc: its chord points half the turn ahead, and is sin(turn / 2) / (turn / 2) times as long.
void PlanarOdometry::integrate(double ahead, double aside, double turn) noexcept {
  const double half = turn / 2;
  const double chord = std::abs(half) < 1e-9 ? 1 : std::sin(half) / half;
  const double c = std::cos(heading_ + half), s = std::sin(heading_ + half);
  x_ += chord * (ahead * c - aside * s);
  y_ += chord * (ahead * s + aside * c);
  heading_ += turn;
}

void Odometry::configure(double separation, double left_radius, double right_radius, std::size_t window) {
  separation_ = separation;
  left_radius_ = left_radius;
  right_radius_ = right_radius;
  start(0, 0);
  PlanarOdometry::configure(window);
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
  return update({linear, 0, angular}, dt);
}

}  // namespace polyarm::controllers
