#pragma once
/// The inside of InverseKinematics: what it knows about its arm, and the candidates of one question. Private
/// to this room. Metres, radians; axis values in the order of ArmGeometry unless noted otherwise.
#include <algorithm>
#include <memory>
#include <numbers>
#include <optional>

#include "polyarm/closed_form/closed_form.hpp"
#include "polyarm/closed_form/general_six.hpp"
#include "polyarm/closed_form/sliding_arm.hpp"
#include "polyarm/closed_form/spare_end.hpp"
#include "polyarm/closed_form/srs_arm.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/ik/self_motion.hpp"

namespace polyarm::ik {

inline constexpr double kTurn = 2 * std::numbers::pi;
using AxisValues = std::array<double, ArmGeometry::kMostAxes>;

/// One candidate solution. Deliberately uninitialised: initialising sixty-four of them costs more than the
/// solve.
struct Candidate {
  AxisValues value;
  double position2, orientation2;  ///< squares of the errors
  double distance2;                ///< square of the weighted distance from the seed
  bool exact, singular;
};

/// The candidates of one question that are exact and within limits, and the best of the others.
struct Gathered {
  std::array<Candidate, IkSolutions::kCapacity> all;
  std::size_t count = 0;
  Candidate nearest;  ///< nearest to the pose among those that are not exact
  double nearest_size = 1e300;
  AxisValues seed{};
  bool beyond_limits = false;  ///< an exact candidate outside the limits was found
  bool at_limit = false;       ///< the next candidates were moved onto limits
  /// Branches that came close to the pose but are not exact.
  std::array<AxisValues, 8> nearly;
  std::size_t nearly_count = 0;
  bool spread = false;  ///< when full: replace one of the two closest candidates
  /// Of two members of one solution family keep the one nearer to the seed, else the first one.
  bool nearest_stays = false;

  const Candidate& best() const noexcept {
    std::size_t out = 0;
    for (std::size_t k = 1; k < count; ++k)
      if (all[k].distance2 < all[out].distance2) out = k;
    return all[out];
  }
  void replace_most_alike(const Candidate& one) noexcept;
  void take(const Candidate& one) noexcept {
    if (count < all.size()) {
      all[count++] = one;
      return;
    }
    const auto further = [](const Candidate& a, const Candidate& b) { return a.distance2 < b.distance2; };
    if (spread) return replace_most_alike(one);
    Candidate& furthest = *std::max_element(all.begin(), all.end(), further);
    if (one.distance2 < furthest.distance2) furthest = one;
  }
};

/// A curve of joint states along which the tool hardly moves; one stride along it; its directions.
struct FlatCurve;
struct FlatStride;
struct FlatWays;
/// The arm may be near such a curve if some direction moves the tool by less than this; lengths in units of
/// the arm's size.
inline constexpr double kFlatCurve = 6e-4;

/// The same job with a fixed number of descent steps, independent of the error and of limits.
inline BranchJob whatever_the_error(BranchJob job, int steps) noexcept {
  job.limits = nullptr;
  job.worth_polishing = 1e3;
  job.patience = steps;
  job.good_enough = 0;
  job.most_steps = steps;
  return job;
}

/// Joint states that wait for a descent.
struct WaitingStates {
  Branches branches;
  std::size_t count = 0;
};

/// The ideal arm nearest to a slightly non-ideal one; descents start from its solutions.
struct IdealStart {
  SixAxisForm strict, wary;  ///< wary: nearly singular counts as singular
  std::array<int, 6> to_arm{0, 1, 2, 3, 4, 5};
  double deviation = 0;  ///< distance of the true arm from the ideal one, m and rad
};

/// Largest deviation of axes from the conditions of a family (rad, and lengths in units of the arm's size) at
/// which its branches are useful starts. Two axes tilted by 5 mrad each are 10 mrad apart.
inline constexpr double kWidestStart = 1.2e-2;

/// The best solution of several sweeps, and the distance from the seed at which another one may exist.
struct NearestBranch {
  AxisValues value{};
  double position2 = 0, orientation2 = 0;
  double distance2 = 1e300;
  double doubt2 = 1e300;  ///< square of the distance of the nearest branch that may hide another solution
};

/// The same form, except that poses near a border of the solution set count as singular.
inline SixAxisForm tolerant_form_of(SixAxisForm form) noexcept {
  form.wary = true;
  form.near_edge = 4 * form.edge;
  return form;
}

struct DescentQuestion;

struct InverseKinematics::Arm {
  using JointValues = std::array<double, Chain::kMaxJoints>;
  IkSettings settings;
  std::string report;
  SixAxisClass known;
  ArmGeometry geometry;
  std::optional<Chain> described;             ///< always set after construction
  std::optional<NumericIk> moves;             ///< descends to descent_tolerance; empty if no joint moves the
                                              ///< TCP
  std::optional<NumericIk> numeric;           ///< set if the closed form may miss solutions
  std::unique_ptr<const GeneralSix> general;  ///< for six axes without a closed form
  /// The same from the arm's other end, if the algebra suits both ends. Rounding loses about one state in a
  /// thousand in one elimination, but seldom the same state in both.
  std::unique_ptr<const GeneralSix> general_too;
  std::unique_ptr<const SlidingArm> sliding;  ///< for SCARAs and gantries
  std::unique_ptr<const SrsArm> srs;          ///< for seven axes with a spherical shoulder and wrist
  std::optional<SpareEnd> end;                ///< for other arms of seven axes with one suitable end
  std::optional<SelfMotion> curves;           ///< for seven turning axes
  LaneArm lanes;
  SixAxisForm form;
  /// The same form, but nearly singular counts as singular.
  SixAxisForm wary;
  /// For a slightly non-ideal arm: the form that reports poses near borders, where solutions meet.
  SixAxisForm first;
  /// For slightly non-ideal arms. Also set for arms that are searched or solved by algebra because they are
  /// too far from ideal to find all branches from here.
  std::optional<IdealStart> start;
  /// The fast path for poses that are neither nearly singular nor out of reach; its family is `none` if there
  /// is no fast path.
  QuickJob quick;
  std::array<int, 6> to_arm{0, 1, 2, 3, 4, 5};
  /// The closed form fails to recover some test states: the true arm is too far from the ideal one.
  bool weak = false;
  int spare = -1;  ///< the axis that is fixed at one value after another; -1 if there is none
  std::size_t joints = 0;
  LaneLimits limits;
  double worth_polishing = 1e-3;

  bool formed() const noexcept { return known.family != ArmFamily::none || general || sliding; }
  /// True if only the polynomial solves this arm.
  bool algebraic() const noexcept { return general && known.family == ArmFamily::none; }
  /// True if the nearest solution has to be found along curves of states, because no shorter method applies.
  bool slides_along() const noexcept {
    const auto slides = [](const JointAxis& axis) { return axis.slides; };
    return formed() && spare >= 0 && !srs && !end &&
           std::none_of(geometry.axes.begin(), geometry.axes.begin() + geometry.count, slides);
  }
  bool solvable() const noexcept { return geometry.count > 0; }
  void read(const Chain& chain);
  std::string describe_known() const;
  NumericSettings numeric_settings() const;
  NumericSettings move_settings() const;
  void add_numeric();
  void settle(const SixAxisClass& found, std::array<int, 6> six);
  void restore(const SixAxisClass& found, std::array<int, 6> axes);
  void find_form();
  void find_six();
  /// @param both_ends algebra is the only method: try it from both ends.
  void find_general(bool both_ends);
  template <typename Value>
  bool is_state(const JointValues& q, const Value& value) const noexcept;
  bool branches_hold(const Pose& target, const JointValues& q, const JointValues& seed) const noexcept;
  int found_of_own_states(int states) const noexcept;
  void find_sliding();
  void find_fewer();
  void find_start();
  void find_start_of_fewer();
  IdealStart start_of(const SixAxisClass& seen, const std::array<int, 6>& axes) const;
  int states_found_from_start(int states) const noexcept;
  void offer_start(BranchJob job, std::size_t before, Gathered& out) const noexcept;
  void compare(const Branches& found, NearestBranch& best) const noexcept;
  void descend_from_seed(BranchJob job, NearestBranch& best) const noexcept;
  bool solve_from_start(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;
  void find_seven();
  void write_quick(const QuickAnswers& from, std::size_t lane, std::span<const double> seed,
                   IkSolution& to) const noexcept;
  bool takes_quick(std::span<const double> seed) const noexcept;
  IkOutcome solve_slowly(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept;
  IkOutcome solve_all_slowly(const Pose& target, std::span<const double> seed,
                             IkSolutions& out) const noexcept;
  bool accepts(const Pose& target, std::span<const double> seed) const noexcept;
  void collect(const DescentQuestion& question, const InverseKinematics& self,
               IkSolutions& out) const noexcept;
  IkOutcome why_unreached(const DescentQuestion& question) const noexcept;
  void gather(const Pose& target, std::span<const double> seed, bool nearest_only,
              Gathered& out) const noexcept;
  void iterate(const Pose& target, std::span<const double> seed, bool nearest_only,
               Gathered& out) const noexcept;
  void take(const IkSolution& one, Gathered& out) const noexcept;
  void sample(BranchJob& job, AxisValues& at, bool nearest_only, Gathered& out) const noexcept;
  void solve_at(BranchJob& job, const SixAxisForm& strict_form, const SixAxisForm& tolerant_form,
                Gathered& out) const noexcept;
  void search_at(BranchJob& job, const SixAxisForm& strict_form, std::size_t before,
                 Gathered& out) const noexcept;
  void offer(BranchJob& job, std::span<const AxisValues> states, std::size_t before,
             Gathered& out) const noexcept;
  void offer_alone(const BranchJob& job, const AxisValues& state, Gathered& out) const noexcept;
  void offer_dips(const BranchJob& job, const Pose& target, std::span<const double> seed,
                  Gathered& out) const noexcept;
  bool offer_slides(const BranchJob& job, const Pose& target, std::span<const double> seed, bool nearest_only,
                    Gathered& out) const noexcept;
  void offer_roots(BranchJob& job, std::size_t before, Gathered& out) const noexcept;
  void descend_all(const BranchJob& job, WaitingStates& waiting, std::size_t before,
                   Gathered& out) const noexcept;
  void solve_nearly_ideal(BranchJob& job, const SixAxisForm& strict_form, const SixAxisForm& tolerant_form,
                          Gathered& out) const noexcept;
  /// @param least_edge a lower bound for SixAxisForm::edge.
  void along_families(const BranchJob& job, double least_edge, std::size_t before,
                      Gathered& out) const noexcept;
  void along_family(BranchJob job, const BranchJob& asked, std::uint32_t axes, std::uint32_t branches_of_it,
                    std::size_t before, Gathered& out) const noexcept;
  void put_on_limits(const BranchJob& job, const AxisValues& state, std::size_t before,
                     Gathered& out) const noexcept;
  void around_seed(const BranchJob& job, std::size_t before, Gathered& out) const noexcept;
  void find_twins(const BranchJob& job, std::size_t since, Gathered& out) const noexcept;
  void along_curves(const BranchJob& job, std::size_t since, Gathered& out) const noexcept;
  void walk(const BranchJob& job, const AxisValues& from, const FlatWays& ways, std::size_t since,
            FlatCurve& curve, Gathered& out) const noexcept;
  void stride_along(const BranchJob& job, const FlatCurve& curve, FlatStride& out) const noexcept;
  bool go_along(const BranchJob& job, std::size_t since, FlatCurve& curve, Gathered& out) const noexcept;
  void search_all_directions(const BranchJob& job, const AxisValues& at, const FlatWays& ways, double least_radius,
                      std::size_t since, Gathered& out) const noexcept;
  void see_motions(std::span<const AxisValues> states, bool both, LeastMotions& out) const noexcept;
  void search_beside(const BranchJob& job, const AxisValues& at, const LeastMotions& flat, std::size_t lane,
                   bool solved, std::size_t since, Gathered& out) const noexcept;
  bool same(const BranchJob& job, const AxisValues& a, const AxisValues& b, bool crowded) const noexcept;
  void sift(const BranchJob& job, const Branches& branches, std::size_t since, Gathered& out) const noexcept;
  void write(const Candidate& from, std::span<const double> seed, IkSolution& to) const noexcept;
};

}  // namespace polyarm::ik
