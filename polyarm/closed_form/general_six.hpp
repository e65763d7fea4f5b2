#pragma once
/// All joint states of six turning axes of any kind that lead to a pose, by algebra: Raghavan and Roth 1993
/// ("Inverse Kinematics of the General 6R Manipulator and Related Linkages", ASME J. Mech. Design 115)
/// eliminate four of the six angles, Manocha and Canny 1994 ("Efficient Inverse Kinematics for General 6R
/// Manipulators", IEEE T-RA 10) turn what is left into eigenvalues. Used inside this room only.
#include <array>
#include <cstddef>
#include <span>

#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

/// What of the arm alone enters, taken once.
class GeneralSix {
 public:
  static constexpr std::size_t kMost = 24;  ///< sixteen, and touching ones twice
  using State = std::array<double, 6>;

  /// `arm` has six turning axes. `from_tool`: solved as the reversed arm, which other arms suit.
  /// `prepared` false: only for finds(), until prepare().
  explicit GeneralSix(const ArmGeometry& arm, bool from_tool = false, bool prepared = true);
  /// Takes what all poses have in common, for solve().
  void prepare() noexcept;
  enum class Finds { it, not_this, nothing_ever };
  /// Whether `q`, each angle within `tolerance` but for whole turns, is among what solve() has for its pose;
  /// or that the arm's axes are so special to each other that no pose is solved. Prepares where that has any
  /// prospect.
  Finds finds(const State& q, const PoseTarget& target, double tolerance) noexcept;

  /// Joint states near all of the solutions (to some 1e-6 rad, worse where two are about to meet), in the
  /// order of the arm's axes; among them some that are none. Returns how many. Allocates nothing.
  std::size_t solve(const PoseTarget& target, std::span<State, kMost> out) const noexcept;

 private:
  struct Elimination;
  struct Ends;
  struct Start;
  Ends ends_of(const PoseTarget& target) const noexcept;
  void see_target(const Ends& ends, Elimination& e) const noexcept;
  void see_middle() noexcept;
  struct Thirds {
    std::array<double, kMost> value;
    std::size_t count = 0;
  };
  bool find_thirds(const Start& start, Thirds& out) const noexcept;
  template <typename Prepare>
  bool find_all_thirds(const Elimination& e, double give_up, const Prepare& prepare,
                       Thirds& out) const noexcept;
  bool complete(const Elimination& e, const Ends& ends, double third, State& q) const noexcept;
  double finish(const Elimination& e, const Ends& ends, State& q) const noexcept;

  static constexpr std::size_t kFeatures = 14;
  using Features = std::array<double, kFeatures>;
  Features left_at(double third, double fourth, double fifth) const noexcept;
  Features left_with(const Rotation& third, const Rotation& fourth, const Rotation& fifth) const noexcept;
  Features right_with(const Ends& ends, const Rotation& first, const Rotation& second) const noexcept;

  bool from_tool_;
  double scale_ = 1;             ///< 1 / m: lengths inside are parts of the arm's size
  std::array<Vec3, 6> h_;        ///< directions of the axes
  std::array<Vec3, 5> p_;        ///< from a point of one axis to a point of the next
  Vec3 first_, last_in_tool_;    ///< a point of axis 1, and one of axis 6 as the tool sees it
  Rotation from_tool_rotation_;  ///< transposed rotation of the tool at zero
  Vec3 beside_6_;
  /// Features of what axes 3 to 5 do, as polynomials: (1, sin, cos) of angle 3, then powers of the half-angle
  /// tangents of angles 4 and 5 (3 * power of 4's + power of 5's): columns of features, 9 * first + second.
  std::array<double, kFeatures * 27> left_{};
  std::array<Rotation, 3> first_back_, second_back_;  ///< angles 1 and 2 undone at 0, 120, 240 degrees
  bool ready_ = false;
  /// Square to the roots +-i that every pose has four times over and that are no solutions: 16 columns of 24,
  /// row by row.
  std::array<std::array<double, 16>, 24> wanted_;
};

}  // namespace polyarm::kinematics
