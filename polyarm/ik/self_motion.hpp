#pragma once
/// Seven turning axes have one to spare: the joint states that lead to a pose lie on curves, along which the
/// arm moves and its tool does not. The nearest to a seed is where one of these curves comes nearest to it.
/// Descents from states of a table lead onto the curves, eight side by side, and from there each slides to
/// where the distance is least. Used inside this room only.
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

  /// Nothing where an axis slides or a joint drives more than one. Keeps a reference to `core`. With
  /// `thorough`, of twice as many starts.
  /// With `only_slides`, nearest() and spread() must not be called.
  static std::optional<SelfMotion> of(const NumericCore& core, const ArmGeometry& arm,
                                      const LaneLimits& limits, bool thorough, bool only_slides = false);

  /// Up to kMost different states within limits that lead to `target` and are, each along its curve, nearest
  /// to `seed` (a joint state of the chain); nearest first, axis values in the order of the geometry. Returns
  /// how many. Those of few curves are missed, and where limits leave but a little of them, all may be.
  /// `doubtful`: many slides ended nowhere, as they do near singularities of the arm, so that there may well
  /// be nearer ones. Allocates nothing.
  std::size_t nearest(const Pose& target, std::span<const double> seed, std::span<State, kMost> out,
                      bool& doubtful) const noexcept;
  /// Where the curve that one descent from the seed leads to comes so near to the seed (0.15 rad) that no
  /// other can come much nearer; false where it does not.
  bool nearest_here(const Pose& target, std::span<const double> seed, State& out) const noexcept;
  /// The nearest along the curves of up to eight `starts`, states within limits that lead to the target;
  /// where there is none, along curves that descents from states of the table lead to. False where nothing is
  /// found.
  bool nearest_from(const Pose& target, std::span<const double> seed, std::span<const State> starts,
                    State& out) const noexcept;
  /// States all over the curves, nearest to `seed` first: 0.15 rad and more from each other, within limits
  /// and within 1e-3 of the target (lengths and rad). Returns how many.
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
  bool look_here(const Question& question, Found& out) const noexcept;
  void descend_from(const Question& question, int steps, Descents& all, Starts& out) const noexcept;
  void find_near(const Question& question, const StatesWanted& wanted, std::size_t most,
                 States& out) const noexcept;
  void start_near_seed(const Question& question, std::size_t descents, int steps, Starts& out) const noexcept;
  void start_anywhere(const Question& question, std::size_t enough, Starts& out) const noexcept;
  void slide_from(const Question& question, std::span<const Start* const> starts, double patience,
                  Found& out) const noexcept;
  void settle_lost(const Question& question, Found& out) const noexcept;

  const NumericCore* core_ = nullptr;
  /// What squares of lengths and directions count beside squares of radians, in one choice of states after
  /// another.
  std::vector<double> factors_;
  std::size_t descents_ = 0, slides_ = 0;  ///< of each choice; of all
  std::array<double, Slides::kJoints> lower_{}, upper_{}, weight_{};
  std::array<bool, Slides::kJoints> turns_{};  ///< limits leave more than one turn
  std::unique_ptr<float[]> values_;            ///< of the table's states, joint after joint
};

}  // namespace polyarm::ik
