#pragma once
/// All joint states of six general turning axes that reach a pose, by algebra. Raghavan and Roth 1993
/// ("Inverse Kinematics of the General 6R Manipulator and Related Linkages", ASME J. Mech. Design 115)
/// eliminate four of the six angles; Manocha and Canny 1994 ("Efficient Inverse Kinematics for General 6R
/// Manipulators", IEEE T-RA 10) turn the rest into an eigenvalue problem. Private to the rooms closed_form
/// and ik. Metres, radians, world frame. After prepare() the object is const: any thread.
#include <array>
#include <cstddef>
#include <span>

#include "polyarm/closed_form/closed_form.hpp"

namespace polyarm::kinematics {

/// The constants of the arm, computed once.
class GeneralSix {
 public:
  static constexpr std::size_t kMost = 24;  ///< sixteen, with touching solutions twice
  using State = std::array<double, 6>;

  /// `arm` has six turning axes. `from_tool`: solve the reversed arm, which suits other arms. `prepared`
  /// false: only finds() may be called until prepare().
  explicit GeneralSix(const ArmGeometry& arm, bool from_tool = false, bool prepared = true);
  /// Computes what all poses share, for solve().
  void prepare() noexcept;
  enum class Finds { it, not_this, nothing_ever };
  /// Finds whether solve() recovers `q` (each angle within `tolerance`, except for whole turns) from its
  /// pose, or that the arm's axes are too special for any pose. Prepares if that makes sense.
  Finds finds(const State& q, const PoseTarget& target, double tolerance) noexcept;

  /// Joint states near all solutions (to about 1e-6 rad, worse where two are about to meet), in the order of
  /// the arm's axes; some of them are not solutions. Returns their number. Allocates nothing.
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
  double scale_ = 1;             ///< 1 / m: internal lengths are in units of the arm's size
  std::array<Vec3, 6> h_;        ///< directions of the axes
  std::array<Vec3, 5> p_;        ///< from a point of one axis to a point of the next
  Vec3 first_, last_in_tool_;    ///< a point of axis 1, and one of axis 6 in the tool frame
  Rotation from_tool_rotation_;  ///< transposed rotation of the tool at zero
  Vec3 beside_6_;
  /// Features of axes 3 to 5 as polynomials: (1, sin, cos) of angle 3, times powers of the half-angle
  /// tangents of angles 4 and 5 (3 * power of 4's + power of 5's). Columns of features, 9 * first + second.
  std::array<double, kFeatures * 27> left_{};
  std::array<Rotation, 3> first_back_, second_back_;  ///< angles 1 and 2 undone at 0, 120, 240 degrees
  bool ready_ = false;
  /// The complement of the roots +-i, which every pose has four times and which are not solutions: 16 columns
  /// of 24, row-major.
  std::array<std::array<double, 16>, 24> wanted_;
};

}  // namespace polyarm::kinematics
