#pragma once
/// Ways of a wheeled base to a place, past everything else in a cell: turns on the spot and straight lines,
/// or arcs and straight lines of a base that steers. Metres, radians; places in the world, whose z axis is
/// up. Any thread; allocates.
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "polyarm/surroundings/bodies.hpp"

namespace polyarm::surroundings {

/// Position and heading of the frame about which a base turns.
struct BasePlace {
  double x = 0, y = 0, heading = 0;
};

/// The place after a piece of a way: `length` is negative backwards; `curvature`, in 1/m, is positive to the
/// left.
BasePlace along(const BasePlace& from, double curvature, double length);

/// A turn on the spot, by the shorter side, if both places have the same position; else an arc, or a straight
/// line with one heading.
struct BaseLeg {
  BasePlace from, to;
  bool backwards = false;
  double curvature = 0;  ///< of an arc: 1/m, positive to the left; 0 otherwise
  double length = 0;     ///< m, of an arc or a line; 0 for a turn
};

struct BaseWayQuery {
  std::size_t robot = 0;  ///< index of the base
  Pose T_root_base;       ///< the frame that its wheels move, in the root link
  BasePlace goal;
  double clearance = 0;        ///< from everything; less if start or goal have less, and up to 50 mm more where
                               ///< there is room
  /// Largest curvature of its ways, 1/m; infinite: it turns on the spot.
  double sharpest = std::numeric_limits<double>::infinity();
  std::function<bool()> stop;  ///< true ends the search; null: it ends after a number of tries alone
};

enum class BaseWayOutcome { found, start_touches, goal_touches, no_way, out_of_time };

struct BaseWay {
  BaseWayOutcome outcome = BaseWayOutcome::no_way;
  std::vector<BaseLeg> legs;  ///< from the present place to the goal; empty if it is there
  std::string mine, other;    ///< start_touches, goal_touches: the two bodies
  double kept = 0;            ///< found: the clearance that all legs keep
};

/// The base moves with what it carries: robots on it with their joints as they are, parts that they hold, and
/// parts that lie on it. Obstacles are fixtures, other parts and other robots where they are at this moment;
/// the ground is not: bodies below the lowest point of the base. Lines are proven free along their whole
/// length, and turns by the region that they sweep.
///
/// The search is an A* over the start, the goal, places on the axes of both, places around the corners of
/// obstacles, and a fixed series of others; edges are checked when they are reached. So it finds the same way
/// each time, and a short one. It finds no way that needs a turn where the base has no room to turn, except
/// at the start and the goal. Ways of bases that steer: steered_ways.hpp. Throws as SweepBodies does.
BaseWay find_base_way(const std::vector<Robot>& robots, const description::Scene& scene, const Moment& moment,
                      const BaseWayQuery& query);

}  // namespace polyarm::surroundings
