#pragma once
/// What messages may ask of joints. A position outside a joint's limits, a rate or an effort far beyond them,
/// and what is no finite number are refused before anything moves, in words that name joint and value. What
/// is a little faster or stronger than a limit is left to the limiter of the loop, as in ros2_control. rad or
/// m, per s, per s², N m or N. Cell thread, but for note_position.
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

enum class Asked : std::uint8_t { position, velocity, acceleration, effort };

class RequestedLimits {
 public:
  /// A position may be this far beyond its limit, rad or m: numbers are rounded in files and messages.
  static constexpr double kRounding = 1e-4;
  /// A rate or an effort above its limit is limited; above this many times the limit it is a mistake.
  static constexpr double kFarBeyond = 10;
  /// Of what has no limit: beyond this it is a mistake.
  static constexpr double kMost = 1e9;

  /// While configuring. `told` is the name as messages have it; without facts nothing but kMost is known.
  void reset(std::size_t joints);
  void set(std::size_t joint, std::string told, const JointFacts* facts);

  /// Control thread: where the joint is. From outside its limits it may be asked to stay, or to come back.
  void note_position(std::size_t joint, double position) noexcept {
    at_[joint].store(position, std::memory_order_relaxed);
  }
  /// The same for all joints.
  void note_positions(std::span<const double> positions) noexcept {
    std::atomic<double>* at = at_.get();
    for (const double position : positions) (at++)->store(position, std::memory_order_relaxed);
  }
  double position(std::size_t joint) const noexcept { return at_[joint].load(std::memory_order_relaxed); }
  std::size_t size() const noexcept { return joints_.size(); }

  /// Adds to `problems` why `value` cannot be asked for: "beyond-limits" or "not-a-number". `where` ends the
  /// sentence: " at point 3".
  void check(Problems& problems, std::size_t joint, Asked kind, double value,
             const std::string& where = {}) const;
  /// Throws that instead.
  void require(std::size_t joint, Asked kind, double value) const;

 private:
  struct Joint {
    std::string told;
    double lower = -kUnlimited, upper = kUnlimited;
    double velocity = kUnlimited, acceleration = kUnlimited, effort = kUnlimited;
  };
  void check_position(Problems& problems, std::size_t joint, double value, const std::string& where) const;
  std::vector<Joint> joints_;
  std::unique_ptr<std::atomic<double>[]> at_;  // NaN: not known
};

}  // namespace polyarm::controllers
