#pragma once
/// Which links of a robot need never be compared for collisions, found by trying many joint states.
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// Why a pair need not be compared, in the words of MoveIt's setup assistant.
enum class PairReason { adjacent, default_state, always, never };
std::string_view name(PairReason reason);

struct LinkPair {
  int first = 0, second = 0;  ///< indices of links, the smaller first
  PairReason reason = PairReason::never;
};

/// Adjacent: with nothing that collides between them; default: they touch at `home` (zero without one);
/// always: they touch in more than 95 % of the samples; never: in none. Joint states are drawn evenly within
/// the limits (±π, ±1 m where there are none), mimicking joints follow; the same seed gives the same pairs.
/// Shapes count as their convex hulls; meshes that are not binary STL, or are not found, count as touching
/// what they may, and are in no pair but adjacent ones.
std::vector<LinkPair> needless_pairs(const RobotModel& model, int samples = 10'000, std::uint32_t seed = 1);

/// Whether two links touch at a state of all actuated joints; nothing where a shape is not known.
std::optional<bool> links_touch(const RobotModel& model, int first, int second, std::span<const double> q);

}  // namespace polyarm::description
