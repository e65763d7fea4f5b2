#pragma once
/// Converts jog requests to commands of the jog controller, and its state to answers. Private to the room;
/// cell thread. Functions throw Error("bad-argument" | "unknown-joint" | "unknown-frame" | "beyond-limits").
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

/// The command of a `jog` request, without its session.
jog::JogCommand jog_command(const JogOwners& cell, const CellRobot& robot,
                            const protocol::JogMotion& request);
/// The command of a `target` request, without its session.
jog::JogCommand target_command(const JogOwners& cell, std::size_t robot,
                               const protocol::FollowTarget& request);
/// The session number of a request; 0: a new session.
std::uint32_t session_of(const std::optional<double>& given);
/// Position of the robot, and what holds it back.
protocol::JogAnswer jog_answer(const JogOwners& cell, std::size_t robot);
/// The joint, workspace zone or body that holds a motion back; empty if none does.
std::string which_text(const JogOwners& cell, std::size_t robot, jog::JogHold hold, std::int32_t which);
/// The reason that holds a motion back, as text for people.
std::string reason_text(const JogOwners& cell, std::size_t robot, jog::JogHold hold, std::int32_t which);
/// Who moves the robots: "program", "jog" or "nobody".
const char* control_holder(const Programs& programs, const Jogging& jogging);

}  // namespace polyarm::cell
