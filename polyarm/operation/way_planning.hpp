#pragma once
/// Plans a path before the robot follows it. Private to the room.
#include <atomic>
#include <memory>
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/moves/move_plan.hpp"
#include "polyarm/operation/point_edits.hpp"

namespace polyarm::cell {

/// A path that is planned on another thread. Read plan and error only after `done` is true.
struct PlannedWay {
  std::atomic<bool> done{false};
  std::optional<moves::MovePlan> plan;
  std::optional<Error> error;
};

/// Plans from the robot's present position, on `worker`. Cell thread. Throws Error if the request has no
/// valid target.
std::shared_ptr<const PlannedWay> plan_way(const PointOwners& cell, std::size_t robot,
                                           const protocol::PlanPreview& request);

}  // namespace polyarm::cell
