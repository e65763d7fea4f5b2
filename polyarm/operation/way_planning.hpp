#pragma once
/// Planning a way before it is gone. Private to the room.
#include <atomic>
#include <memory>
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/moves/move_plan.hpp"
#include "polyarm/operation/point_edits.hpp"

namespace polyarm::cell {

/// A way that is being planned on another thread. Read plan and error when it is done.
struct PlannedWay {
  std::atomic<bool> done{false};
  std::optional<moves::MovePlan> plan;
  std::optional<Error> error;
};

/// From where the robot is, on `worker`. Cell thread. Throws Error where the request names no place.
std::shared_ptr<const PlannedWay> plan_way(const PointOwners& cell, std::size_t robot,
                                           const protocol::PlanPreview& request);

}  // namespace polyarm::cell
