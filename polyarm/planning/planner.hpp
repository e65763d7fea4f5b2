#pragma once
/// Ways around obstacles: joint states from a start to one of several goals, with every state between proven
/// free. Radians, metres. The same query, seed and instruction set give the same plan. Allocates: not for the
/// control cycle. One thread for each Probe. Reads no clock: `PlanOptions::stop` may.
///
/// Method: two trees that grow towards each other (RRT-Connect, Kuffner and LaValle 2000), with a dynamic
/// domain (Yershova et al. 2005); then shortcuts between random places of the path (Geraerts and Overmars
/// 2007).
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/collision/checker.hpp"

namespace polyarm::planning {

using JointState = std::vector<double>;

struct PlanQuery {
  JointState start;
  std::vector<JointState> goals;     ///< any of them will do
  std::vector<double> lower, upper;  ///< limits; infinite: none
};

enum class Exactness {
  automatic,  ///< by spheres; by exact shapes where these find no way
  spheres,
  exact,
};

struct PlanOptions {
  std::uint64_t seed = 1;
  std::size_t most_samples = 50'000;  ///< draws of one search; bounds the time
  std::size_t most_states = 40'000;   ///< of both trees; bounds the memory
  std::size_t shortcuts = 60;         ///< attempts; 0: the path as found
  double range = 1;                   ///< longest edge of a tree, in the norm of `weights`
  std::vector<double> weights;        ///< of each joint's change, per rad or m; empty: 1 each
  Exactness exactness = Exactness::automatic;
  /// Asked now and then; true ends the search as `out_of_time`. Null: never.
  std::function<bool()> stop;
};

enum class PlanOutcome { found, bad_query, start_touches, goal_touches, out_of_samples, out_of_time };
const char* name(PlanOutcome outcome);

struct Plan {
  PlanOutcome outcome = PlanOutcome::bad_query;
  std::vector<JointState> waypoints;  ///< from the start to a goal, joined by straight lines in joint space
  std::size_t goal = 0;               ///< the index of the goal that is reached
  double length = 0;                  ///< in the norm of the weights
  double length_found = 0;            ///< before shortcuts
  bool exact = false;                 ///< exact shapes were needed
  std::size_t samples = 0, states = 0, edges = 0;
  /// start_touches, goal_touches: what touches, and how deep. Of several goals the one that overlaps least.
  collision::Contact contact;
  std::string reason;  ///< why there is no plan, in words; empty if one was found
};

Plan plan(collision::Probe& probe, const PlanQuery& query, const PlanOptions& options = {});

/// The largest radii, one for each waypoint, with which paths::joint_lines may round the corners: in the norm
/// with weights of 1, proven free, at most `most` and half of the shorter neighbour. 0 where nothing is
/// proven.
std::vector<double> corner_radii(collision::Probe& probe, std::span<const JointState> waypoints,
                                 bool exact = false, double most = 0.5);

/// "forearm_link is 12.3 mm inside fixture shelf", or "… is 4.0 mm from …".
std::string text_of(const collision::Contact& contact);

}  // namespace polyarm::planning
