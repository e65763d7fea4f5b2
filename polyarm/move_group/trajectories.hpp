#pragma once
/// Timed plans as messages, and checks of trajectories of others. Any thread; allocates.
#include <functional>
#include <span>

#include "polyarm/move_group/scene.hpp"
#include "polyarm/moves/move_plan.hpp"

namespace polyarm::move_group {

/// The joints of the group, sampled often enough that quintics between the points follow the plan.
msg::RobotTrajectory to_message(const Arm& arm, const Group& group, const moves::MovePlan& plan,
                                std::span<const double> start);

/// Calls `look` with joint states along the plan, at most `step` seconds apart, until it returns false.
void along(const moves::MovePlan& plan, double step,
           const std::function<bool(std::span<const double>)>& look);

/// Throws Refusal(code) if a straight line between neighbours touches something; names the pair.
void check_free(surroundings::Surroundings& around, const std::vector<std::vector<double>>& states, int code,
                const std::string& what);

/// The name that MoveIt knows a body by, and its kind: ContactInformation's body types.
std::string body_name(const std::string& body);
std::uint32_t body_type(const std::string& body);

}  // namespace polyarm::move_group
