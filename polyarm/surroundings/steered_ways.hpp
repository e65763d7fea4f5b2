#pragma once
/// Ways of a base that steers. Private to this room.
#include "polyarm/surroundings/base_ground.hpp"

namespace polyarm::surroundings {

/// A way of arcs and straight lines, none sharper than `query.sharpest`, with the clearance of the ground.
/// Outcomes: found, no_way, out_of_time.
///
/// The search is an A* over short arcs and lines of the base, ahead and backwards; from each place that it
/// reaches it also tries the shortest ways without obstacles to the goal. Then shorter ways between places of
/// the result replace its pieces. It finds the same way each time. `most`: number of places from which it
/// goes on.
BaseWay find_steered_way(const Ground& ground, const BaseWayQuery& query, std::size_t most);

}  // namespace polyarm::surroundings
