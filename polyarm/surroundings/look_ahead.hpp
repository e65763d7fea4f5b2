#pragma once
/// Looks along the planned way of one robot: until when it stays clear of everything around it. Each pair of
/// bodies is followed by steps that are proven: while the joints can move a body by less than its clearance,
/// nothing is measured. Metres, radians, seconds of the plan. One thread; allocates in the constructor alone.
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/surroundings/guard_bodies.hpp"

namespace polyarm::surroundings {

/// A planned way of the joints in time.
class PlannedWay {
 public:
  virtual ~PlannedWay() = default;
  virtual double duration() const noexcept = 0;
  /// Position and velocity of all joints at a time of the plan.
  virtual void at(double time, std::span<double> position, std::span<double> velocity) noexcept = 0;
  /// Bounds of the joints' accelerations.
  virtual std::span<const double> acceleration() const noexcept = 0;
};

struct LookAheadOptions {
  double clearance = 0.005;  ///< m between a robot and everything else
  /// Where start, goal or an end of a move is nearer than the clearance, this share of the distance there is
  /// kept.
  double share = 0.7;
  /// Exact distances that follow the way in one look, beside those that find what is near. What is known
  /// stays known: a robot among many bodies begins late, but it begins.
  std::uint64_t most_measured = 600;
  std::uint64_t at_first = 5;  ///< times as many in the first look along a way
};

/// From when to when on a way the tool, or a part that the robot holds, is meant to touch something.
struct TouchTime {
  double from = 0, to = 0;
};

class LookAhead {
 public:
  /// Held parts that lie on something, and tools that grip, may overlap with it by this, m.
  static constexpr double kPressing = 0.002;
  /// Steps along the way near something are at most so long that a body moves by this, m.
  static constexpr double kResolution = 5e-4;
  /// The ends of moves on one way that set how near they may come; of later ones the clearance is kept.
  static constexpr std::size_t kMostEnds = 128;

  LookAhead(GuardBodies& bodies, int robot, const LookAheadOptions& options);

  /// A new way; `ends`: times at which moves end on it. What may move is measured there; what no robot moves
  /// when it first comes near.
  /// `touches`: in order; of more than kMostEnds the later ones do not count.
  void begin(PlannedWay& way, std::span<const double> ends, std::span<const TouchTime> touches = {}) noexcept;

  struct Answer {
    double free_until = 0;  ///< time of the plan; infinite: nothing on the way as far as it was looked
    int pair = -1;          ///< what is in the way then; -1: nothing, or it is not known yet (most_measured)
    GuardGap gap;
    double required = 0;  ///< the distance that is kept there, m
  };
  /// From `now` to `until`. `stopping`: of each robot, how far its joints can still move, by variable; of
  /// this one it is not used.
  Answer look(PlannedWay& way, double now, double until,
              std::span<const std::vector<double>> stopping) noexcept;
  /// The highest speed of any point of the robot at the last look, m per s of the plan.
  double speed() const noexcept { return speed_; }

 private:
  struct Of {
    double required = 0;
    bool is_required = false;  // `required` is known
    double clear_until = -1;
    double moved = 0;  // by its obstacle, when the pair was followed
    double drift = 0;  // that was assumed then
    double seen = -1;  // the slack of the pair after it was measured last
    std::uint32_t version = 0;
  };
  bool may_change(const GuardPair& pair) const noexcept;
  double distance_of(std::size_t pair, double enough) noexcept;
  void find_reaches(PlannedWay& way, double now, double until,
                    std::span<const std::vector<double>> stopping) noexcept;
  void require(std::size_t pair) noexcept;
  void require_at(std::size_t end, const GuardPair& pair, Of& of) noexcept;
  double drift(const GuardPair& pair) const noexcept;
  bool scan(std::size_t pair, PlannedWay& way, double now, double until, Answer& out) noexcept;
  void follow_further(PlannedWay& way, double now, double until) noexcept;
  bool is_known(std::size_t pair, double until) const noexcept;
  bool is_still(std::size_t pair) const noexcept;
  bool is_held(const GuardPair& pair) const noexcept;
  bool may_touch(const GuardPair& pair) const noexcept;
  double looked_until(const GuardPair& pair, double now, double until) const noexcept;
  const GuardPair& pair_at(std::size_t i) const noexcept { return bodies_.pairs()[pairs_[i]]; }
  std::uint32_t obstacle_of(const GuardPair& pair) const noexcept {
    return pair.robot_a == robot_ ? pair.b : pair.a;
  }

  GuardBodies& bodies_;
  int robot_;
  LookAheadOptions options_;
  std::vector<std::size_t> pairs_;  // that concern this robot, or will when it holds a part
  std::vector<Of> of_;              // of each of them
  std::vector<std::size_t> mine_;   // those near the way, as places in pairs_
  std::vector<double> q_, v_, from_, way_, step_;
  std::vector<double> reaches_;  // of this look, by body
  std::vector<double> ends_;
  std::vector<std::vector<Pose>> end_frames_;  // of the robot, at each of them
  std::vector<TouchTime> touches_;
  std::uint64_t budget_ = 0;
  bool is_first_ = true;  // the next look is the first one along the way
  double speed_ = 0;
};

}  // namespace polyarm::surroundings
