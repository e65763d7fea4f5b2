#pragma once
/// Requests and replies of a controller of UFACTORY at its TCP port 502: the head of Modbus TCP with another
/// protocol number, a register, data. Integers are big-endian, floats little-endian. Radians, millimetres and
/// seconds, as on the wire.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/wire/bytes.hpp"

namespace polyarm::xarm {

using wire::Bytes;

inline constexpr int kCommandPort = 502;
inline constexpr std::uint16_t kPrivateProtocol = 2;  ///< 0 is Modbus TCP at the same port
/// The same from clients that send something at least every 30 s, with firmware 1.8.6 or newer.
inline constexpr std::uint16_t kHeartbeatProtocol = 3;
inline constexpr std::size_t kUxHead = 6;
inline constexpr std::size_t kLongestUx = 512;  ///< bytes behind the head
inline constexpr std::size_t kWireJoints = 7;   ///< in each message; an arm with fewer leaves the rest at 0

enum class Register : std::uint8_t {
  version = 1,
  serial_number = 2,
  check_verified = 3,
  reload_dynamics = 4,
  reports_current = 5,
  approximate_motion = 7,
  system_control = 10,
  motion_enable = 11,
  set_state = 12,
  get_state = 13,
  queue_length = 14,
  get_error = 15,
  clean_error = 16,
  clean_warning = 17,
  brake = 18,
  set_mode = 19,
  move_line = 21,
  move_line_blend = 22,
  move_joint = 23,
  move_joint_blend = 24,
  move_home = 25,
  sleep = 26,
  move_circle = 27,
  servo_joint = 29,
  servo_line = 30,
  tcp_jerk = 31,
  tcp_acceleration = 32,
  joint_jerk = 33,
  joint_acceleration = 34,
  tcp_offset = 35,
  tcp_load = 36,
  collision_sensitivity = 37,
  teach_sensitivity = 38,
  clean_settings = 39,
  save_settings = 40,
  tcp_pose = 41,
  joint_positions = 42,
  inverse = 43,
  forward = 44,
  is_joint_limit = 45,
  is_tcp_limit = 46,
  gravity = 51,
  reduced_state = 53,
  joint_torques = 55,
  collision_rebound = 60,
  world_offset = 73,
  counter_reset = 74,
  counter_plus = 75,
  self_collision = 77,
  joint_velocity = 81,
  line_velocity = 82,
  servo_error = 107,
  tool_timeout = 123,
  tool_write = 127,
  tool_read = 128,
  digital_in = 131,
  analog_in_1 = 132,
  analog_in_2 = 133,
  set_digital = 134,
  set_analog_1 = 135,
  set_analog_2 = 136,
  set_in_function = 137,
  set_out_function = 138,
  io_state = 139,
  power_version = 140,
  hardware_types = 141,
  feedback_type = 254,
};

enum class Mode : std::uint8_t {
  position,
  servo,
  joint_teach,
  cartesian_teach,
  joint_velocity,
  cartesian_velocity,
  online_joint,
  online_cartesian,
};

/// As reports and replies name it. A program sets 0 (ready), 3 or 4.
enum class State : std::uint8_t { ready, moving, standing, paused, stopped, reset, stopping };

/// Bits of a reply.
inline constexpr std::uint8_t kErrorBit = 0x40, kWarningBit = 0x20, kNotReadyBit = 0x10, kInvalidBit = 0x08;

struct UxRequest {
  std::uint16_t transaction = 0;
  std::uint16_t protocol = kPrivateProtocol;
  Register reg{};
  std::vector<std::uint8_t> data;
};
struct UxReply {
  std::uint16_t transaction = 0;
  Register reg{};
  std::uint8_t bits = 0;
  std::vector<std::uint8_t> data;
  std::uint16_t protocol = kPrivateProtocol;  ///< that of the request
};

std::vector<std::uint8_t> encode(const UxRequest& request);
std::vector<std::uint8_t> encode(const UxReply& reply);

/// One frame of the stream: head and body.
struct UxFrame {
  std::uint16_t transaction = 0, protocol = 0;
  std::vector<std::uint8_t> body;
};
/// Nothing if the frame is of another protocol, or too short.
std::optional<UxRequest> decode_request(const UxFrame& frame);
std::optional<UxReply> decode_reply(const UxFrame& frame);

/// Cuts a stream of bytes into frames.
class UxReader {
 public:
  /// False: a length that no frame has; the connection is of no use.
  bool feed(Bytes bytes);
  std::optional<UxFrame> next();

 private:
  bool length_is_wrong() const;
  std::size_t length() const;
  std::vector<std::uint8_t> buffer_;
};

/// Builds the data of a request or a reply.
class UxData {
 public:
  UxData& u8(std::uint64_t value);
  UxData& u16(std::uint64_t value);
  UxData& u32(std::uint64_t value);
  UxData& f32(double value);
  UxData& f32(std::span<const double> values);
  /// Filled with zeros, or cut, to `size`.
  UxData& text(const std::string& value, std::size_t size);
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  operator std::vector<std::uint8_t>() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// A little-endian float of a frame. `in` must have four bytes.
float float_at(Bytes in, std::size_t at) noexcept;
/// `count` floats, all finite; nothing if there are fewer, or one is not.
std::optional<std::vector<double>> floats(Bytes in, std::size_t count);

/// The oldest firmware that the driver takes.
inline constexpr int kLeastMajor = 1, kLeastMinor = 5;

/// What the text of the version says: "6,6,XI1304…,AC1302…,v1.12.10".
struct Version {
  int axes = 0, type = 0;  ///< 0: not said
  int major = 0, minor = 0, revision = 0;
  std::string text;
  std::string firmware() const;
};
Version parse_version(Bytes text);

}  // namespace polyarm::xarm
