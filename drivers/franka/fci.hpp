#pragma once
/// The Franka Control Interface: requests and replies on TCP port 1337, states and commands as datagrams
/// every millisecond. Numbers are little-endian, without padding. Layouts are those of libfranka-common in
/// the versions 5 (Panda) and 6 to 10 (Franka Research 3). SI units; matrices are column-major. Any thread.
#include <array>
#include <bitset>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/bytes.hpp"
#include "drivers/wire/shaper.hpp"

namespace polyarm::franka {

using wire::Bytes;
using wire::Seven;
using wire::Six;
using Matrix4 = std::array<double, 16>;
using Data = std::vector<std::uint8_t>;

inline constexpr int kRobotPort = 1337;
inline constexpr int kOldestVersion = 5, kNewestVersion = 10;
inline constexpr std::size_t kFciHead = 12;       ///< bytes before the data of a frame
inline constexpr std::size_t kMostFrame = 8'192;  ///< bytes of a frame that the driver may get
inline constexpr std::size_t kErrors = 41;        ///< flags of a state
using ErrorFlags = std::bitset<kErrors>;

/// Requests, in no version's order.
enum class Request : std::uint8_t {
  connect,
  move,
  stop_move,
  set_collision_behavior,
  set_joint_impedance,
  set_cartesian_impedance,
  set_guiding_mode,
  set_k_frame,   ///< EE_T_K
  set_ee_frame,  ///< NE_T_EE
  set_load,
  recover,  ///< automatic error recovery
  get_cartesian_limit,
  set_filters,
  load_model_library,
  get_robot_model,
};
const char* name(Request request);

/// What a reply says, in no version's order.
enum class Status : std::uint8_t {
  success,
  started,
  preempted,
  preempted_by_safety,
  refused_by_safety,
  not_possible,
  singular_start,
  invalid_argument,
  manual_recovery,
  reflex,
  user_stop,
  input_error,
  aborted,
  other_version,
  unknown,
};
const char* name(Status status);

/// The number of a request in a version; nothing where the version does not have it.
std::optional<std::uint32_t> number_of(Request request, int version);
std::optional<Request> request_of(std::uint32_t number, int version);
/// The byte of a status in replies to a request, and back. A status that the version does not have becomes
/// `aborted` or `not_possible`.
std::uint8_t byte_of(Status status, Request request, int version);
Status status_of(std::uint8_t byte, Request request, int version);

struct Frame {
  std::uint32_t command = 0;
  std::uint32_t id = 0;  ///< of the request; its replies have the same
  Data data;
};
Data encode(const Frame& frame);

/// Cuts frames out of a stream.
class FrameReader {
 public:
  /// `head`: 12 for the robot, 10 for the hand, whose command has two bytes.
  explicit FrameReader(std::size_t head = kFciHead) : head_(head) {}
  /// False, for good: a length that no frame has.
  bool feed(Bytes bytes);
  std::optional<Frame> next();

 private:
  std::uint32_t size_of_first() const;
  std::size_t head_;
  Data buffer_;
  bool broken_ = false;
};

// --- requests ---

enum class Generator : std::uint8_t { idle, joint_position, joint_velocity, pose, twist, none };
enum class Controller : std::uint8_t { joint_impedance, cartesian_impedance, external, other };

struct MoveRequest {
  Controller controller = Controller::joint_impedance;
  Generator generator = Generator::joint_position;
  std::array<double, 3> path_deviation{10, 3.12, 6.28};  ///< m, rad, rad of the elbow
  std::array<double, 3> goal_deviation{10, 3.12, 6.28};
};
Data encode(const MoveRequest& move, int version);
std::optional<MoveRequest> decode_move(Bytes data, int version);

/// Above the lower thresholds a contact is reported, above the upper ones a collision stops the robot. N m
/// for each joint; N and N m along x, y, z of the base.
struct CollisionBehavior {
  Seven lower_torque{}, upper_torque{};
  Six lower_force{}, upper_force{};
};
Data encode(const CollisionBehavior& behavior);
std::optional<CollisionBehavior> decode_collision(Bytes data);

/// A load at the flange, beside the end effector that Desk knows.
struct Load {
  double mass = 0;                  ///< kg
  std::array<double, 3> center{};   ///< m, in the flange
  std::array<double, 9> inertia{};  ///< kg m², about the centre
};
Data encode(const Load& load);
std::optional<Load> decode_load(Bytes data);
/// Numbers without a head, as impedances and frames are sent.
Data numbers(std::span<const double> values);
/// Nothing unless `data` are exactly as many finite numbers.
bool read_numbers(Bytes data, std::span<double> values);

// --- datagrams ---

enum class RobotMode : std::uint8_t { other, idle, move, guiding, reflex, user_stopped, recovery };
const char* name(RobotMode mode);

/// What the robot sends every millisecond, as far as anyone here uses it.
struct RobotState {
  std::uint64_t id = 0;  ///< ms of the controller's clock
  Matrix4 O_T_EE{}, O_T_EE_d{}, F_T_EE{}, EE_T_K{}, F_T_NE{}, NE_T_EE{};
  Load load;
  Seven tau_J{}, q{}, q_d{}, dq{}, dq_d{}, ddq_d{};
  Seven joint_contact{}, joint_collision{};
  Six cartesian_contact{}, cartesian_collision{};
  Seven tau_ext{};           ///< N m, estimated, filtered
  Six O_F_ext{}, K_F_ext{};  ///< N, N m on the stiffness frame: in axes of the base, in its own axes
  Generator generator = Generator::idle;
  Controller controller = Controller::other;
  ErrorFlags errors, reflex;  ///< now; what ended the last motion
  RobotMode mode = RobotMode::idle;
  double success_rate = 0;  ///< share of the last 100 commands that came in time
};
std::size_t state_bytes(int version);
Data encode(const RobotState& state, int version);
/// Nothing for another length, a mode that does not exist, or positions that are not finite. Real-time.
std::optional<RobotState> decode_state(Bytes data, int version) noexcept;

struct RobotCommand {
  std::uint64_t id = 0;  ///< of the state that it answers
  Seven q{};             ///< rad
  Seven dq{};            ///< rad/s
  bool finished = false;
};
std::size_t command_bytes(int version);
inline constexpr std::size_t kMostCommand = 371;
/// Writes command_bytes(version) bytes. Real-time.
void encode(const RobotCommand& command, int version, std::span<std::uint8_t, kMostCommand> out) noexcept;
/// Also the other kinds of commands, of which only the id and the end are read.
std::optional<RobotCommand> decode_command(Bytes data, int version) noexcept;

/// The rotation of a matrix, as x, y, z, w; position first. m. Real-time.
std::array<double, 7> pose_of(const Matrix4& matrix) noexcept;

}  // namespace polyarm::franka
