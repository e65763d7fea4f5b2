#pragma once
/// "Simple messages" of MotoROS, the program of ROS-Industrial on a controller of Yaskawa: a length, three
/// words, a body, over TCP. A controller sends in the byte order of its own processor; its first message
/// shows which one. Radians and seconds, as on the wire.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/ordered_bytes.hpp"
#include "drivers/wire/tcp.hpp"
#include "drivers/yaskawa/words.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::yaskawa {

using wire::ByteOrder;
using wire::Bytes;

inline constexpr int kMotionPort = 50240, kStatePort = 50241, kIoPort = 50242;
inline constexpr std::size_t kMotoAxes = 10, kMotoGroups = 4;
/// Of a message without its length: the head alone, and a point for all groups.
inline constexpr std::size_t kLeastMessage = 12, kLongestMessage = bounds::kMotoMessageBytes;
static_assert(kLongestMessage == 12 + 8 + kMotoGroups * 132);

enum class MotoType : std::int32_t {
  ping = 1,
  robot_status = 13,
  point = 14,  ///< JOINT_TRAJ_PT_FULL
  feedback = 15,
  control = 2001,
  reply = 2002,
  read_bit = 2003,
  read_bit_reply = 2004,
  write_bit = 2005,
  write_bit_reply = 2006,
  read_group = 2007,
  read_group_reply = 2008,
  write_group = 2009,
  write_group_reply = 2010,
  io_reply = 2011,
  read_register = 2012,
  write_register = 2013,
  point_ex = 2016,  ///< a point of several groups
  feedback_ex = 2017,
  select_tool = 2018,
};
enum class MotoComm : std::int32_t { invalid, topic, request, reply };
enum class MotoCommand : std::int32_t {
  check_ready = 200101,
  check_queue = 200102,
  stop_motion = 200111,
  start_servos = 200112,
  stop_servos = 200113,
  reset_alarm = 200114,
  start_trajectory = 200121,
  stop_trajectory = 200122,
  disconnect = 200130,
};
enum class MotoResult : std::int32_t { success, busy, failure, invalid, alarm, not_ready, mp_failure };
/// Subcodes of MotoResult::invalid.
enum class Invalid : std::int32_t {
  unspecified = 3000,
  message_size,
  message_header,
  message_type,
  group,
  sequence,
  command,
  data = 3010,
  start_position,
  position,
  speed,
  acceleration,
  insufficient,
  time,
  tool,
};
/// Subcodes of MotoResult::not_ready, and of a check that found it.
enum class NotReady : std::int32_t {
  unspecified = 5000,
  alarm,
  error,
  e_stop,
  not_play,
  not_remote,
  servo_off,
  hold,
  not_started,
  waiting_ros,
  skill_send,
  pfl_active,
  increment_error,
};
/// Results of signals.
enum class IoResult : std::int32_t {
  ok = 0,
  read_address = 1001,
  write_address,
  write_value,
  read_failed,
  write_failed
};

using Ten = std::array<float, kMotoAxes>;

struct Message {
  MotoType type = MotoType::ping;
  MotoComm comm = MotoComm::request;
  std::int32_t reply = 0;  ///< 1: success, 2: failure
  std::vector<std::uint8_t> body;
};
struct MotoPoint {
  std::int32_t group = 0;
  std::int32_t sequence = 0;  ///< 0: begins a trajectory where the robot stands
  std::int32_t valid = 7;     ///< time 1, position 2, velocity 4, acceleration 8
  float time = 0;
  Ten position{}, velocity{}, acceleration{};
};
struct MotoFeedback {
  std::int32_t group = 0, valid = 2;
  float time = 0;
  Ten position{}, velocity{}, acceleration{};
};
/// -1: unknown.
struct MotoStatus {
  std::int32_t drives = 0, e_stopped = 0, alarm_code = 0, in_error = 0, in_motion = 0;
  std::int32_t mode = 0;  ///< 1: teach, 2: play
  std::int32_t motion_possible = 0;
};
struct MotoControl {
  std::int32_t group = 0, sequence = 0;
  MotoCommand command = MotoCommand::check_ready;
};
struct MotoReply {
  std::int32_t group = 0, sequence = 0;
  std::int32_t command = 0;  ///< of the control message; the type of any other message
  MotoResult result = MotoResult::success;
  std::int32_t subcode = 0;
};

/// With its length.
std::vector<std::uint8_t> encode(const Message& message, ByteOrder order);
std::vector<std::uint8_t> encode(const MotoPoint& point, ByteOrder order);
std::vector<std::uint8_t> encode(const MotoFeedback& feedback, ByteOrder order);
std::vector<std::uint8_t> encode(const MotoStatus& status, ByteOrder order);
std::vector<std::uint8_t> encode(const MotoControl& control, ByteOrder order);
std::vector<std::uint8_t> encode(const MotoReply& reply, ByteOrder order);
/// Nothing if the body is too short, or has a number that is not finite where one is needed.
std::optional<MotoPoint> decode_point(const Message& message, ByteOrder order);
/// The points of `point_ex`, at most kMotoGroups.
std::optional<std::vector<MotoPoint>> decode_points(const Message& message, ByteOrder order);
std::optional<MotoFeedback> decode_feedback(const Message& message, ByteOrder order);
std::optional<MotoStatus> decode_status(const Message& message, ByteOrder order);
std::optional<MotoControl> decode_control(const Message& message, ByteOrder order);
std::optional<MotoReply> decode_reply(const Message& message, ByteOrder order);
/// A body of plain words.
std::vector<std::uint8_t> words(std::initializer_list<std::uint32_t> values, ByteOrder order);
/// The first `count` words of a body; nothing if it is shorter.
std::optional<std::array<std::uint32_t, 2>> read_words(const Message& message, std::size_t count,
                                                       ByteOrder order);

/// The messages of one direction of a connection, from bytes in any pieces. One thread.
class MotoReader {
 public:
  /// `order`: unknown, if the first message shall show it.
  explicit MotoReader(std::optional<ByteOrder> order = std::nullopt) : order_(order) {}
  /// False: what came is no such message, and the connection is of no use.
  bool feed(Bytes bytes);
  std::optional<Message> next();
  std::optional<ByteOrder> order() const { return order_; }

 private:
  bool find_order();
  std::size_t length() const;
  std::optional<ByteOrder> order_;
  std::vector<std::uint8_t> buffer_;
};

/// The driver's end of one port of MotoROS. One thread at a time.
class MotoPort {
 public:
  MotoPort(std::string host, int port) : host_(std::move(host)), port_(port) {}
  /// Waits for the connection. False: see failure().
  bool open(Nanoseconds timeout, std::optional<ByteOrder> order);
  void close() { socket_ = Descriptor(); }
  bool is_open() const { return static_cast<bool>(socket_); }
  int descriptor() const { return socket_.number(); }
  ByteOrder order() const { return reader_.order().value_or(ByteOrder::little); }
  bool knows_order() const { return reader_.order().has_value(); }

  /// Nothing waits. False: the connection is of no use, and failure() says why.
  bool send(std::span<const std::uint8_t> bytes);
  bool receive();
  std::optional<Message> next() { return reader_.next(); }

  /// The answer to a message; waits for it. Nothing: see failure().
  std::optional<Message> ask(std::span<const std::uint8_t> bytes, Nanoseconds timeout);
  std::optional<MotoReply> control(MotoCommand command, int group, Nanoseconds timeout);

  struct Failure {
    Cause cause = Cause::none;
    std::string text;
  };
  const Failure& failure() const { return failure_; }

 private:
  bool fail(Cause cause, const std::string& text = {});
  std::string host_;
  int port_;
  Descriptor socket_;
  MotoReader reader_;
  bool heard_ = false;  ///< something came over this connection
  std::int32_t sequence_ = 0;
  Failure failure_;
};

/// The address of a signal: general input or output N, from 1.
constexpr std::uint32_t input_address(int number) {
  return static_cast<std::uint32_t>((1 + (number - 1) / 8) * 10 + (number - 1) % 8);
}
constexpr std::uint32_t output_address(int number) {
  return 10000 + input_address(number);
}
inline constexpr int kMostSignals = bounds::kSignalsOfController;

}  // namespace polyarm::yaskawa
