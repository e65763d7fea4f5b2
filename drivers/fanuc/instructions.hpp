#pragma once
/// Moves as instructions of the Remote Motion Interface. Const: any thread. Allocates. What an instruction
/// means and when it is answered (when it is done): the maker's operator's manual B-84184EN/01.
#include <array>
#include <memory>

#include "drivers/fanuc/rmi.hpp"
#include "drivers/wire/shaper.hpp"
#include "polyarm/hardware/forward_moves.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::fanuc {

using wire::Six;

/// What the instructions of one robot need to know of it.
struct InstructionFrame {
  Pose base;                ///< T_world_base, of the cell
  double world_height = 0;  ///< m, of the controller's world frame above the base: the height of axis 2
  std::shared_ptr<const kinematics::Chain> flange;  ///< of the face plate in the base
  int tool = 9;                                     ///< number of the tool frame that the driver writes
  double ramp = 0.2;                                ///< s in which the robot speeds up and slows down
};

/// The arm's configuration, as the controller states it with a position.
struct Configuration {
  std::array<int, 7> values{};  ///< Front, Up, Left, Flip, Turn4, Turn5, Turn6
};
/// Of an answer to FRC_ReadCartesianPosition.
Configuration configuration_of(const RmiMessage& answer);

/// The TCP in the face plate at the end of the move: T_flange_tcp.
Pose tool_of(const hardware::ForwardMove& move, const InstructionFrame& frame);
/// Degrees, joint 3 against the horizontal, as the interface has it; and back.
Six rmi_joints(const Six& radians);
Six radians_of(const Six& rmi_joints);
/// Per cent: the robot leaves the path at most `blend` before the end. With CNT the next motion begins in the
/// slowing down of this one; c per cent before its end, the rest of the way is c² of that of the slowing
/// down.
int cnt_of(const hardware::ForwardMove& move, double ramp);

/// `fine`: the robot comes to rest at the end, whatever the move says. `configuration`: of an arc.
RmiLine instruction_of(const hardware::ForwardMove& move, const InstructionFrame& frame, int sequence,
                       bool fine, const Configuration& configuration);
/// Writes the tool frame.
RmiLine tool_line(const Pose& tool, const InstructionFrame& frame);

}  // namespace polyarm::fanuc
