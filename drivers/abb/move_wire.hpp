#pragma once
/// Messages of our RAPID program PolyarmMoves, over TCP: one answer to each request, both of a fixed size,
/// big-endian. Millimetres, degrees, seconds, as the controller has them; numbers have single precision.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/abb/words.hpp"
#include "drivers/forward/move_queue.hpp"
#include "drivers/wire/bytes.hpp"
#include "drivers/wire/shaper.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::abb {

using wire::Bytes;
using wire::Six;

inline constexpr int kMovesVersion = 1;  ///< of the program and its messages
inline constexpr int kMovesPort = 54700;
inline constexpr std::size_t kMoveRequestBytes = 88, kMoveReplyBytes = 88;
/// Whole numbers above are not exact in RAPID's num.
inline constexpr int kMostWhole = 8'000'000;
/// The program's clock goes from 0 to this, then begins anew. ms
inline constexpr int kMovesClock = 1'000'000;
/// degrees/s of a line whose way, not its turn, decides about its time.
inline constexpr double kFullTurn = 1000;
/// Moves that the program holds at a time, with the one under way.
inline constexpr std::size_t kMoveSlots = 6;

/// The numbers are those of the RAPID program.
enum class MoveDo : std::uint8_t {
  state,
  begin,  ///< a session; `value`: ms without a request until the program stops the robot and ends it
  move,   ///< `number` of the move; `value`, from here on: of the session
  halt,   ///< the robot stops, and its moves are forgotten; `number` of the halt
  tool,   ///< `end` becomes the TCP in tool0, with the load
  pace,   ///< `number`: per cent of the speed of all moves; 0: the robot comes to rest on its path
  end     ///< of the session: as a halt
};
enum class MoveResult : std::uint8_t { done, unknown, version, no_session, full, busy };

/// A frame as x, y, z (mm) and a quaternion, the real part first.
using Frame = std::array<double, 7>;

/// A move of the program.
struct RapidMove {
  enum Kind : std::uint8_t { none, joints, line, arc };
  Kind kind = none;
  Frame end{0, 0, 0, 1, 0, 0, 0};  ///< six angles of joints, or the TCP in wobj0
  std::array<double, 3> via{};     ///< mm, a point on an arc
  double angle = 0;                ///< degrees, of an arc; the program does not get it
  double time = 0;                 ///< s, of a joint move
  double speed = 0, turn = 0;      ///< mm/s and degrees/s of a line or an arc
  double acceleration = 0;         ///< % of the controller's for joints, else m/s²
  double zone = 0;                 ///< mm; 0: fine
};
struct RapidLoad {
  double mass = 0;                 ///< kg
  std::array<double, 3> centre{};  ///< mm, of mass, in tool0
};

struct MoveRequest {
  int id = 0;
  MoveDo what = MoveDo::state;
  int number = 0, value = 0;
  RapidMove move;  ///< of `move`; its end is the frame of `tool`
  RapidLoad load;  ///< of `tool`
};

struct MoveReply {
  int id = 0;
  MoveResult result = MoveResult::done;
  int version = kMovesVersion;
  int session = 0;            ///< number of the session; 0: none is open
  int ended = 0, halted = 0;  ///< numbers of the newest move that ended and of the newest halt that is done
  int time_ms = 0;            ///< of the reading
  int error = 0;              ///< number of the error that a move ended with; 0: none
  int pace = 100;             ///< %
  Six joints{};               ///< degrees
  Frame flange{0, 0, 0, 1, 0, 0, 0};  ///< of tool0 in wobj0
};

std::vector<std::uint8_t> encode(const MoveRequest& request);
std::vector<std::uint8_t> encode(const MoveReply& reply);
/// Of a message of exactly kMoveRequestBytes or kMoveReplyBytes; nothing if it has a number that is not
/// finite or out of its range. Allocates nothing.
std::optional<MoveRequest> decode_move_request(Bytes bytes) noexcept;
std::optional<MoveReply> decode_move_reply(Bytes bytes) noexcept;

Frame frame_of(const Pose& pose);
Pose pose_of(const Frame& frame);
/// What the program gets for a move of the runtime.
RapidMove rapid_move(const forward::MoveOrder& order, const forward::MoveFrame& frame);

/// The driver's end. Every call may wait; one thread at a time.
class MovePort {
 public:
  struct Failure {
    Cause cause = Cause::none;
    std::string text;
  };
  MovePort(std::string host, int port) : host_(std::move(host)), port_(port) {}
  bool open(Nanoseconds timeout);
  void close() { socket_ = Descriptor(); }
  bool is_open() const { return static_cast<bool>(socket_); }
  /// False: see failure(). A connection that failed is closed.
  bool send(MoveRequest request);
  /// The answer to what was sent last; nothing in time, if failure() has no cause, or a failure.
  std::optional<MoveReply> await_reply(Nanoseconds timeout);
  const Failure& failure() const { return failure_; }

 private:
  bool fail(Cause cause, const std::string& text = {});

  std::string host_;
  int port_;
  Descriptor socket_;
  std::vector<std::uint8_t> received_;
  int id_ = 0;
  Failure failure_;
};

}  // namespace polyarm::abb
