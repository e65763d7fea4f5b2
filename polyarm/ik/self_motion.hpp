#pragma once
/// Self-motions of arms with seven turning axes. One joint is redundant, so the joint states that reach a
/// pose form curves: along a curve the arm moves and the tool does not. This class finds the points on these
/// curves that are nearest to a seed. Descents from the states of a table reach the curves, eight side by
/// side; from there each slides to where the distance is smallest. Private to this room. Radians, metres,
/// poses in the world; const after construction: any thread. Nothing throws.
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "polyarm/closed_form/closed_form.hpp"
#include "polyarm/descent/numeric_core.hpp"

namespace polyarm::ik {

using namespace kinematics;

class SelfMotion {
 public:
  using State = std::array<double, ArmGeometry::kMostAxes>;
  static constexpr std::size_t kMost = 4;

  /// Returns nothing if an axis slides or a joint drives more than one axis. Keeps a reference to `core`.
  /// `thorough` uses twice as many starts. With `only_slides`, nearest() and spread() must not be called.
  static std::optional<SelfMotion> of(const NumericCore& core, const ArmGeometry& arm,
                                      const LaneLimits& limits, bool thorough, bool only_slides = false);

  /// Up to kMost different states within limits that reach `target`, each the nearest to `seed` (a joint
  /// state of the chain) on its curve; nearest first, axis values in the order of the geometry. Returns their
  /// number. It can miss curves, and can miss all of them if limits leave only small parts. `doubtful` is set
  /// if many slides failed, as happens near singularities of the arm: nearer states may then well exist.
  /// Allocates nothing.
  std::size_t nearest(const Pose& target, std::span<const double> seed, std::span<State, kMost> out,
                      bool& doubtful) const noexcept;
  /// The nearest point of the curve that one descent from the seed reaches. True if it is so near to the seed
  /// (0.15 rad) that no other can be much nearer.
  bool nearest_here(const Pose& target, std::span<const double> seed, State& out) const noexcept;
  /// The nearest state along the curves of up to eight `starts`, which are within limits and reach the
  /// target; without starts, along curves that descents from table states reach. False if nothing is found.
  bool nearest_from(const Pose& target, std::span<const double> seed, std::span<const State> starts,
                    State& out) const noexcept;
  /// States spread over the curves, nearest to `seed` first: at least 0.15 rad apart, within limits, and
  /// within 1e-3 of the target (lengths and rad). Returns their number.
  std::size_t spread(const Pose& target, std::span<const double> seed, std::span<State> out) const noexcept;

 private:
  struct Question;
  struct Start;
  struct States;
  struct Starts;
  struct Found;
  bool read(const Pose& target, std::span<const double> seed, Question& out) const noexcept;
  double distance2(const Question& question, const double* x) const noexcept;
  void unwind(const Question& question, double* x) const noexcept;
  static double away_from(const Question& question, const Start& one) noexcept;
  bool search_from_here(const Question& question, Found& out) const noexcept;
  void descend_from(const Question& question, int steps, Descents& all, Starts& out) const noexcept;
  void find_near(const Question& question, const StatesWanted& wanted, std::size_t most,
                 States& out) const noexcept;
  void start_near_seed(const Question& question, std::size_t descents, int steps, Starts& out) const noexcept;
  void start_anywhere(const Question& question, std::size_t enough, Starts& out) const noexcept;
  void slide_from(const Question& question, std::span<const Start* const> starts, double patience,
                  Found& out) const noexcept;
  void settle_lost(const Question& question, Found& out) const noexcept;

  const NumericCore* core_ = nullptr;
  /// Weights of squared lengths and directions relative to squared radians, one for each selection of states.
  std::vector<double> factors_;
  std::size_t descents_ = 0, slides_ = 0;  ///< descents for each selection; slides for all
  std::array<double, Slides::kJoints> lower_{}, upper_{}, weight_{};
  std::array<bool, Slides::kJoints> turns_{};  ///< limits allow more than one turn
  std::unique_ptr<float[]> values_;            ///< values of the table's states, joint after joint
};

}  // namespace polyarm::ik
