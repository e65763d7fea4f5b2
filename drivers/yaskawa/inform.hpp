#pragma once
/// Our job POLYARM for forward mode: the variables of the controller that it shares with the driver, and its
/// text. Any thread.
#include <string>

#include "drivers/forward/move_queue.hpp"
#include "drivers/yaskawa/hses.hpp"

namespace polyarm::yaskawa {

inline constexpr const char* kMovesJob = "POLYARM";
inline constexpr int kMovesJobVersion = 1;
/// Moves that the job holds at a time, with the one under way: one in each place.
inline constexpr std::size_t kMoveSlots = 2;

/// Network inputs that the driver writes. The ladder holds the robot from outside while the session is open
/// and the heartbeat does not change.
inline constexpr int kHeartbeatByte = 2701;  ///< 27010 to 27017
inline constexpr std::uint8_t kBeatBit = 1, kSessionBit = 2;

/// D variables. While the job runs, the driver writes `put`, `session` and `output`, and the job the others.
/// While it stands, the driver may write all but `half`.
struct SharedDoubles {
  static constexpr int first = 80, count = 7;
  static constexpr int put = 80;           ///< number of the newest move
  static constexpr int ended = 81;         ///< of the newest move that has ended
  static constexpr int session = 82;       ///< of the driver
  static constexpr int session_here = 83;  ///< of the driver, when the job began
  static constexpr int version = 84;       ///< of the job
  static constexpr int output = 85;        ///< number of the newest request for an output
  static constexpr int output_done = 86;
  static constexpr int half = 87;  ///< of the job
};
/// Of a move with an even number; one with an odd number has its own, `places` or `integers` behind.
struct SharedMove {
  static constexpr int end = 80, via = 81, begin = 82, places = 3;      ///< P variables
  static constexpr int kind = 80, speed = 81, ramp = 82, integers = 3;  ///< I variables
};
inline constexpr int kOutputNumber = 86, kOutputValue = 87;  ///< I variables

/// A move as the job takes it.
struct JobMove {
  enum Kind : int { joint = 1, line = 2, arc = 3, turn = 4 };
  Kind kind = joint;
  int speed = 1;                    ///< 0.01 % of the axes' speeds, 0.1 mm/s, or 0.1 degrees/s for turn
  int ramp = 100;                   ///< % of acceleration and deceleration, 20 to 100
  wire::Six end{}, via{}, begin{};  ///< rad
};
/// Lines and arcs are so slow that no axis exceeds its limit anywhere on them.
JobMove job_move(const forward::MoveOrder& order, const forward::MoveFrame& frame);

/// Pulses for a radian of each axis.
std::array<std::int32_t, 8> pulses_of(const wire::Six& q, const wire::Six& pulses) noexcept;
wire::Six radians_of(const std::array<std::int32_t, 8>& values, const wire::Six& pulses) noexcept;
/// T_base_tcp, m. Rx, Ry, Rz turn about the fixed axes x, y, z.
Pose pose_of(const HsesPosition& position) noexcept;

/// m, of the origin of the controller's base coordinates above the base of the description: at the second
/// axis. Recalled.
double base_height(const kinematics::Chain& chain);

/// The job, as the controller loads it.
std::string moves_job();

}  // namespace polyarm::yaskawa
