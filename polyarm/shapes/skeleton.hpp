#pragma once
/// The geometry from which a robot's shapes are built: its rigid bodies, and for each joint the position and
/// the thickness of both bodies' housings along the axis. Derived from the kinematics and the measured
/// outlines. m, rad. No side effects; any thread.
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::shapes {

/// The arrangement of the housings of a joint's two bodies.
enum class Fit {
  stacked,  ///< side by side along the axis; they meet in one plane
  inner,    ///< this body lies between the cheeks of the other one
  outer     ///< this body has cheeks on both sides of the other one
};

/// One body's end of a joint, in the body's frame. Positions along the axis are measured from `origin`.
struct End {
  int joint = -1;  ///< index into RobotModel::joints; -1: the flange
  Vec3 origin;
  Vec3 axis{0, 0, 1};
  bool slides = false;
  Fit fit = Fit::stacked;
  double from = 0, to = 0;              ///< the housing, from < to
  double meet = 0;                      ///< stacked: where it meets the other body
  double inner_from = 0, inner_to = 0;  ///< outer: the gap between the cheeks
  double radius = 0;                    ///< of this body's housing
  double other_radius = 0;              ///< of the other body's
  bool along = false;                   ///< the body runs along the axis instead of across it
  double middle() const { return (from + to) / 2; }
  Vec3 at(double place) const { return origin + place * axis; }
};

/// Links that are fixed to each other, as one body.
struct RigidBody {
  int link = -1;          ///< the link whose frame is used and that carries the shapes
  Vec3 low, high;         ///< bounds in that frame
  bool measured = false;  ///< the bounds are those of the real shape
  bool has_in = false;
  End in;                   ///< the joint that moves it
  std::vector<End> out;     ///< the joints that it carries; the flange, if it has one, is last
  bool has_flange = false;  ///< the last of `out` is the flange
};

struct Skeleton {
  std::vector<RigidBody> bodies;  ///< the base first, parents before children
  double reach = 1;               ///< m; sum of the offsets of the longest chain
};

/// `forks`: a body may hold another one between two cheeks; if false, housings are always side by side.
Skeleton skeleton_of(const description::RobotModel& model, bool forks);

}  // namespace polyarm::shapes
