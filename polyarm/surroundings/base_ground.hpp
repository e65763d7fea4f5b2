#pragma once
/// What a base can hit on its ways. Private to this room. Metres, radians. Const functions: any thread.
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/surroundings/base_ways.hpp"
#include "polyarm/surroundings/sweep_bodies.hpp"

namespace polyarm::surroundings {

/// An angle within ±180°.
inline double wrapped(double angle) {
  return std::remainder(angle, 2 * std::numbers::pi);
}

/// What turns less, or drives less, does not move.
inline constexpr double kSameHeading = 1e-6, kSamePlace = 1e-4;

/// A body of the base, in its frame on the plane z = 0 of the world.
struct OwnBody {
  collision::ConvexBody body;  ///< without discs
  std::string name;
  double low = 0, high = 0;  ///< along z
  double farthest = 0;       ///< of its points from the axis about which the base turns
};

struct OtherBody {
  collision::ConvexBody body;  ///< in the world
  std::string name;
  double low = 0, high = 0;
};

/// The bodies of the cell, sorted into those that the base takes along and those that are in its way.
class Ground : private SweepBodies {
 public:
  /// All arguments outlive it.
  Ground(const std::vector<Robot>& robots, const description::Scene& scene, const Moment& moment,
         const BaseWayQuery& query);

  const BasePlace& start() const { return start_; }
  const std::vector<OtherBody>& others() const { return others_; }
  double farthest() const { return farthest_; }
  double farthest_beside(const OtherBody& other) const;
  void keep(double clearance) { clearance_ = clearance; }
  double clearance() const { return clearance_; }

  /// What is nearest to the base at a place, as far as it is nearer than `within`.
  struct Nearest {
    double distance = std::numeric_limits<double>::infinity();
    std::string mine, other;
  };
  Nearest nearest(const BasePlace& place, double within) const;
  /// A vertical cylinder about the axis of the frame that the wheels move, inside the base, for a quick look.
  struct Core {
    double radius = 0, low = 0, high = 0;
  };
  Core core() const;
  /// True if something is nearer than `within` to that cylinder there.
  bool is_beside(const Core& core, double x, double y, double within) const;

  // Each is true if the base keeps the clearance:
  bool line_is_free(const BasePlace& from, const BasePlace& to) const;
  /// Along an arc, or a line; as along().
  bool arc_is_free(const BasePlace& from, double curvature, double length) const;
  /// By a whole turn.
  bool turns_freely(double x, double y) const;
  bool turn_is_free(const BasePlace& at, double heading) const;

 private:
  bool is_carried(int robot) const;
  bool is_own(const SweptBody& body) const;
  std::optional<Pose> place_of(const SweptBody& body) const;
  void add_own(const SweptBody& body);
  bool is_load(const SweptBody& body) const;
  void add_loads();
  void add_other(const SweptBody& body);
  bool lies_on_base(const SweptBody& part, const Pose& place) const;
  template <typename Take>
  bool each_near(const collision::ConvexBody& swept, double within, const Take& take) const;
  bool is_free(const collision::ConvexBody& swept) const;
  bool is_empty_around(const BasePlace& at, double more) const;
  bool turned_is_free(const Pose& from, const Pose& to, double turn, double radius) const;

  const Moment& moment_;
  const BaseWayQuery& query_;
  BasePlace start_;
  std::vector<std::vector<Pose>> frames_;
  std::vector<OwnBody> own_;
  std::vector<char> is_load_;  // by part
  std::vector<OtherBody> others_;
  collision::BoxTree tree_;
  double low_ = std::numeric_limits<double>::infinity(), high_ = -low_, farthest_ = 0;
  double clearance_ = 0;
};

}  // namespace polyarm::surroundings
