#pragma once
/// Messages of our KRL program for KUKA's EthernetKRL (EKI): XML over TCP, one answer to each request.
/// Degrees, as on the wire.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/kuka/words.hpp"
#include "drivers/wire/shaper.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::kuka {

using wire::Six;

inline constexpr int kProgramVersion = 2;  ///< of our KRL program and its messages
inline constexpr std::size_t kMostSignals = bounds::kSignalsOfController;

/// The numbers are those of the KRL program.
enum class EkiDo : std::uint8_t {
  state,
  start,  ///< RSI
  stop,
  drives_on,
  speed_override,
  output,
  begin,  ///< a session of moves; `value`: ms without a request until the program ends it
  move,   ///< `number` of the move, `value`: of the session
  halt,   ///< the robot stops, and its moves are forgotten; `number` of the halt
  tool,   ///< $TOOL becomes the end of the move
  end     ///< of the session: as a halt
};
enum class EkiResult : std::uint8_t { done, unknown, mode, not_ready, busy };

/// A move of our KRL program. Degrees, mm, m/s, m/s².
struct EkiMove {
  enum Kind : std::uint8_t { none, ptp, lin, circ };
  Kind kind = none;
  Six end{};                ///< axes of PTP, else X Y Z A B C of $TOOL in $ROBROOT
  Six via{};                ///< X Y Z A B C on the way of CIRC
  double speed = 0;         ///< % of each axis for PTP, else m/s
  double acceleration = 0;  ///< %, or m/s²
  double turn = 0;          ///< degrees/s; 0: the controller's highest
  double blend = 0;         ///< % of half of the way for PTP, else mm; 0: the robot stops at the end
};

struct EkiRequest {
  int id = 0;
  EkiDo what = EkiDo::state;
  int number = 0;  ///< of an output, a move or a halt
  int value = 0;   ///< %, or 0 and 1
  std::optional<EkiMove> move;
};

enum class OperatingMode : std::uint8_t { t1 = 1, t2, automatic, external };
/// $PRO_STATE1 of the robot interpreter.
enum class ProgramState : std::uint8_t { free = 1, reset, active, stopped, ended };

struct EkiState {
  OperatingMode mode = OperatingMode::external;
  bool emergency_stop = false, guard_stop = false, drives = false;
  bool message = false;  ///< a message stops the robot ($STOPMESS)
  ProgramState program = ProgramState::free;
  bool rsi = false;                       ///< RSI runs
  int rsi_return = 0;                     ///< of the RSI function that failed last; 0: none
  int speed_override = 100;               ///< %
  std::uint32_t inputs = 0, outputs = 0;  ///< a bit each, from 1
  Six axes{};
  // Moves: the program of forward mode.
  bool moves = false;          ///< a session is open
  int session = 0, ended = 0;  ///< number of the session, and of the newest move that ended
  int halted = 0;              ///< number of the newest halt that is done
  std::int64_t time_ms = 0;    ///< of the reading, by the controller's clock
};

/// What does not change while the link is open.
struct EkiIdentity {
  int version = kProgramVersion, axes = 6;
  std::string robot;
  int rsi = 5, cycle_ms = 4;      ///< version and cycle of RSI
  int late_limit = 25;            ///< late answers in a row, until RSI ends
  double correction_limit = 360;  ///< degrees of each axis away from where RSI began
  bool relative = false;          ///< corrections are for one cycle each
  Six lower{}, upper{};           ///< software limits, degrees
};

struct EkiReply {
  int id = 0;
  EkiResult result = EkiResult::done;
  EkiState state;
  EkiIdentity identity;
};

std::string encode(const EkiRequest& request);
std::string encode(const EkiReply& reply);

/// The messages of one direction of a connection, from bytes in any pieces. One thread.
class EkiReader {
 public:
  /// False: what came is no message, and the connection is of no use.
  bool feed(std::string_view bytes);
  /// The next whole message; empty without one.
  std::string next();

 private:
  bool find_end();
  std::string buffer_;
  std::size_t end_ = 0;
};

std::optional<EkiRequest> decode_request(std::string_view text) noexcept;
std::optional<EkiReply> decode_reply(std::string_view text);

/// The driver's end. Every call may wait; one thread at a time.
class Eki {
 public:
  Eki(std::string host, int port, Nanoseconds timeout)
      : host_(std::move(host)), port_(port), timeout_(timeout) {}
  bool open();
  void close();
  /// The answer; nothing: see failure(). A connection that failed stays closed.
  std::optional<EkiReply> ask(EkiDo what, int number = 0, int value = 0,
                              const std::optional<EkiMove>& move = std::nullopt);
  /// Address of this computer, as the controller sees it.
  std::string own_address() const;

  struct Failure {
    Cause cause = Cause::none;
    std::string text;
  };
  const Failure& failure() const { return failure_; }

 private:
  std::optional<EkiReply> fail(Cause cause, const std::string& text = {});
  std::optional<EkiReply> await_answer(Nanoseconds deadline);

  std::string host_;
  int port_;
  Nanoseconds timeout_;
  Descriptor socket_;
  EkiReader reader_;
  int id_ = 0;
  bool answered_ = false;  ///< this connection has had an answer
  Failure failure_;
};

}  // namespace polyarm::kuka
