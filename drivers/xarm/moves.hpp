#pragma once
/// Moves of a controller of UFACTORY that interpolates itself (position mode), as they are on the wire:
/// radians, millimetres, seconds. Any thread; allocates.
#include <optional>
#include <vector>

#include "drivers/forward/move_queue.hpp"
#include "drivers/xarm/report.hpp"
#include "drivers/xarm/ux.hpp"

namespace polyarm::xarm {

struct UxMove {
  enum class Kind : std::uint8_t { joint, line, circle };
  Kind kind = Kind::joint;
  Seven joints{};           ///< the end of a joint move
  Six pose{}, via{};        ///< the end of a line; of a circle its two points: `via` first
  double speed = 0;         ///< rad/s of the joint that turns most, or mm/s
  double acceleration = 0;  ///< the same per s
  double radius = -1;       ///< mm, of the arc at its end; below 0: it stops there
  double percent = 100;     ///< of the whole circle through the two points
};

/// The forms of a request for a move changed with the firmware.
struct UxMoveForms {
  bool joint_radius = false;  ///< joint moves with a radius: 1.5.20
  bool general = false;       ///< lines and circles with bytes for their coordinates: 1.11.100
};
UxMoveForms forms_of(const Version& version);

struct UxMoveRequest {
  Register reg{};
  std::vector<std::uint8_t> data;
};
UxMoveRequest encode(const UxMove& move, const UxMoveForms& forms);
/// Of any form. Nothing if it is no move, too short, not finite, or of another kind: in coordinates of the
/// tool, with an axis and an angle, or only to be checked.
std::optional<UxMove> decode_move(Register reg, Bytes data);

/// mm, then roll, pitch and yaw about fixed axes.
Six pose_values(const Pose& pose);
Pose pose_from(const Six& values);

/// Of a move of `order`, at its pace. Lines and circles are so slow that no joint exceeds its limit anywhere
/// on them; a radius is less than half of the move and of the next one, and circles have none at either end.
/// Where the TCP only turns, the speed is in degrees/s.
UxMove ux_move(const forward::MoveOrder& order, const forward::MoveFrame& frame);

}  // namespace polyarm::xarm
