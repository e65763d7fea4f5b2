#pragma once
/// Requests for motion by hand as commands of the jog controller, and its state as the answer. Private to the
/// room; cell thread. Throws Error("bad-argument" | "unknown-joint" | "unknown-frame" | "beyond-limits").
#include <cstdint>
#include <optional>
#include <string>

#include "polyarm/machine/cell_data.hpp"
#include "polyarm/machine/motions.hpp"
#include "polyarm/operation/jog_owners.hpp"
#include "polyarm/operation/jogging.hpp"
#include "polyarm/protocol/jog.hpp"
#include "polyarm/tasks/programs.hpp"

namespace polyarm::cell {

/// A `jog` of robot `robot`, without its session.
jog::JogCommand jog_command(const JogOwners& cell, const CellRobot& robot,
                            const protocol::JogMotion& request);
/// A `target` of the robot with this index, without its session.
jog::JogCommand target_command(const JogOwners& cell, std::size_t robot,
                               const protocol::FollowTarget& request);
/// The number of a session; 0: a new one.
std::uint32_t session_of(const std::optional<double>& given);
/// Where the robot is, and what holds it back.
protocol::JogAnswer jog_answer(const JogOwners& cell, std::size_t robot);
/// The joint or the zone of the workspace that holds a motion back; empty: neither does.
std::string which_text(const CellRobot& robot, jog::JogHold hold, std::int32_t which);
/// What holds a motion back, for a person.
std::string reason_text(const CellRobot& robot, jog::JogHold hold, std::int32_t which);
/// Which of those that may move the robots does: "program", "jog" or "nobody".
const char* control_holder(const Programs& programs, const Jogging& jogging);

}  // namespace polyarm::cell
