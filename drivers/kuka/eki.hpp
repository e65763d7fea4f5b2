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

inline constexpr int kProgramVersion = 1;  ///< of our KRL program and its messages
inline constexpr std::size_t kMostSignals = bounds::kSignalsOfController;

/// The numbers are those of the KRL program.
enum class EkiDo : std::uint8_t { state, start, stop, drives_on, speed_override, output };
enum class EkiResult : std::uint8_t { done, unknown, mode, not_ready, busy };

struct EkiRequest {
  int id = 0;
  EkiDo what = EkiDo::state;
  int number = 0;  ///< of an output
  int value = 0;   ///< %, or 0 and 1
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
  std::optional<EkiReply> ask(EkiDo what, int number = 0, int value = 0);
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
