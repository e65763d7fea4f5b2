#pragma once
#include <cstddef>
#include <vector>

namespace polyarm::controllers {

/// Mean of the last values. Only the constructor allocates.
class RollingMean {
 public:
  explicit RollingMean(std::size_t window = 10) : values_(window < 1 ? 1 : window, 0.0) {}
  void clear() noexcept { next_ = count_ = 0, sum_ = 0; }
  void add(double value) noexcept;
  double mean() const noexcept { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }

 private:
  std::vector<double> values_;
  std::size_t next_ = 0, count_ = 0;
  double sum_ = 0;
};

/// Velocity of a base in its own frame: x ahead, y to the left (m/s), angular to the left (rad/s).
struct PlanarTwist {
  double x = 0, y = 0, angular = 0;
  bool operator==(const PlanarTwist&) const = default;
};

/// Pose of a base: x, y (m) and heading (rad, unbounded) in the frame in which it began. Arcs are integrated
/// exactly. Everything but configure() is real-time. An update with less than a microsecond, or with NaN or
/// infinity, is refused and changes nothing.
class PlanarOdometry {
 public:
  /// `window`: updates over which the reported velocity is averaged. Not real-time.
  void configure(std::size_t window);

  bool update(const PlanarTwist& measured, double dt) noexcept;
  /// The reported velocity is `commanded`, without averaging.
  bool update_open_loop(const PlanarTwist& commanded, double dt) noexcept;
  void set_pose(double x, double y, double heading) noexcept;

  double x() const noexcept { return x_; }
  double y() const noexcept { return y_; }
  double heading() const noexcept { return heading_; }
  double linear() const noexcept { return twist_.x; }         ///< m/s, mean of the window
  double lateral() const noexcept { return twist_.y; }        ///< m/s, mean of the window
  double angular() const noexcept { return twist_.angular; }  ///< rad/s, mean of the window

 private:
  void integrate(double ahead, double aside, double turn) noexcept;
  double x_ = 0, y_ = 0, heading_ = 0;
  PlanarTwist twist_;
  RollingMean x_mean_, y_mean_, angular_mean_;
};

/// Odometry of a drive with two wheels (or two sides of wheels).
class Odometry : public PlanarOdometry {
 public:
  /// Metres; not real-time.
  void configure(double separation, double left_radius, double right_radius, std::size_t window);

  /// Wheel positions (rad) from which update_from_positions counts. Real-time, as all that follows.
  void start(double left, double right) noexcept { left_ = left, right_ = right; }
  bool update_from_positions(double left, double right, double dt) noexcept;   ///< rad, s
  bool update_from_velocities(double left, double right, double dt) noexcept;  ///< rad/s, s
  bool update_open_loop(double linear, double angular, double dt) noexcept {   ///< m/s, rad/s, s
    return PlanarOdometry::update_open_loop({linear, 0, angular}, dt);
  }

 private:
  double separation_ = 1, left_radius_ = 1, right_radius_ = 1;
  double left_ = 0, right_ = 0;
};

}  // namespace polyarm::controllers
