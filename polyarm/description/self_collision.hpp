#pragma once
/// Finds the pairs of links that never need a collision check, by sampling joint states. Any thread.
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// The reason why a pair needs no check, in the terms of MoveIt's setup assistant.
enum class PairReason { adjacent, default_state, always, never };
std::string_view name(PairReason reason);

struct LinkPair {
  int first = 0, second = 0;  ///< indices of links, the smaller first
  PairReason reason = PairReason::never;
};

/// Finds the pairs that need no check. adjacent: no link with a collision shape lies between them.
/// default_state: they touch at `home` (at zero if there is no home). always: they touch in more than 95 % of
/// the samples. never: in none. Joint states are uniform within the limits (±π or ±1 m if there are none);
/// mimic joints follow. The same seed gives the same pairs. A mesh counts as its convex pieces
/// (hulls::make_bodies); a mesh without pieces occurs only in adjacent pairs.
std::vector<LinkPair> needless_pairs(const RobotModel& model, int samples = 10'000, std::uint32_t seed = 1);

/// True if two links touch at a state of all actuated joints; empty if a shape is unknown.
std::optional<bool> links_touch(const RobotModel& model, int first, int second, std::span<const double> q);

}  // namespace polyarm::description
