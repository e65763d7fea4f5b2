/// What the link in forward mode does while it is open: the rounds in which it reads, judges and sends.
#include "drivers/xarm/forward_link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/wire/six_axes.hpp"

namespace polyarm::xarm {

using forward::MoveOrder;

namespace {

constexpr double kStandingWay = 1e-4;             // rad between two reports of a robot that stands
constexpr int kReadsOfRound = 16;                 // of the reports in one round
constexpr int kForeignReports = 5;                // of a robot that nobody here moves
constexpr int kEndAttempts = 3;                   // to tell the controller to stop
constexpr int kQueueFull = 11, kNoSolution = 14;  // warnings of a move that was not taken
constexpr Nanoseconds kNextReport = 2'000'000;    // for one, with a clock that waits
constexpr Nanoseconds kToStand = 3'000'000'000;
// Times of the reports, s.
constexpr double kSettling = 0.5005;                   // until reports show a state that was set
constexpr double kCoasting = 1.0005;                   // after the last move
constexpr double kTakingTool = 1.0005;                 // for a tool to count
constexpr double kSameTool = 0.005, kSameTurn = 0.02;  // m, rad between the TCP here and there

bool may_run(State state) {
  return state <= State::standing;
}

}  // namespace

void ForwardLink::round() {
  const bool fresh = take_reports();
  const Phase phase = phase_;
  if (!fault_ && heard_ != 0 && realtime::monotonic_now() - heard_ > settings_.silence)
    note(Cause::report_silent);
  if (phase == Phase::ending || (phase == Phase::active && fault_)) return end();
  if (phase == Phase::active && !beat()) return end();
  if (!fresh || fault_) return;
  if (phase == Phase::idle) return watch_idle();
  if (!read_panel()) return;
  count_moves();
  judge();
  if (!fault_) follow_moves(report());
  samples_.write(current_);
  if (!fault_) act();
  if (fault_) end();
}

/// A heartbeat in each round, because a round with late answers lasts longer than `poll`. False: the watchdog
/// is gone, or has stopped the robot.
bool ForwardLink::beat() {
  if (!watchdog_.running()) return true;
  watchdog::Health health = watchdog_.listen();
  if (health == watchdog::Health::fine) health = watchdog_.beat();
  if (health == watchdog::Health::fine) return true;
  note(Cause::watchdog, static_cast<int>(health), std::to_string(settings_.watchdog_ms));
  return false;
}

void ForwardLink::watch_idle() {
  if (read_panel()) samples_.write(current_);
}

// --- what the controller says ---------------------------------------------------------------------------

/// False: no new one came.
bool ForwardLink::take_reports() {
  if (!report_socket_) return false;
  if (settings_.times.stepped) wire::wait_readable(report_socket_.number(), kNextReport);
  std::array<std::uint8_t, 4096> buffer;
  bool well = true;
  for (int turn = 0; well && turn < kReadsOfRound; ++turn) {
    const wire::Received got = wire::receive(report_socket_.number(), buffer);
    if (got.got == wire::Got::nothing) break;
    well = got.got == wire::Got::bytes && report_reader_.feed(Bytes(buffer).first(got.count));
    if (!well) note(got.got == wire::Got::bytes ? Cause::bad_data : Cause::closed);
    if (got.count < buffer.size()) break;
  }
  std::optional<Report> newest;
  int reports = 0;
  while (const auto bytes = report_reader_.next()) {
    const auto report = decode_report(*bytes, ReportKind::real);
    if (!report) {
      note(Cause::bad_data);
      break;
    }
    newest = report;
    ++reports;
  }
  if (!well) report_socket_ = Descriptor();
  if (newest) take(*newest, reports);
  return newest.has_value();
}

void ForwardLink::take(const Report& report, int reports) {
  const Nanoseconds now = realtime::monotonic_now();
  const double since = settings_.times.stepped ? reports * seconds(settings_.period) : seconds(now - heard_);
  time_ = settings_.times.stepped
              ? static_cast<double>(current_.count + static_cast<std::uint64_t>(reports)) *
                    seconds(settings_.period)
              : seconds(now);
  Six q;
  std::copy_n(report.position.begin(), q.size(), q.begin());
  const bool moved = forward::largest_difference(q, current_.q) > kStandingWay * reports;
  still_reports_ = moved || report.state == State::moving ? 0 : still_reports_ + reports;
  if (current_.count > 0 && since > 1e-4)
    for (std::size_t i = 0; i < q.size(); ++i) current_.dq[i] = (q[i] - current_.q[i]) / since;
  const bool foreign = moved && queued_ == 0 && phase_ == Phase::active && time_ - moved_at_ > kCoasting;
  foreign_reports_ = foreign ? foreign_reports_ + 1 : 0;
  current_.q = q;
  current_.report = report;
  current_.count += static_cast<std::uint64_t>(reports);
  heard_ = now;
}

/// The cause of a failure of the panel ends the link. Returns false.
bool ForwardLink::note_panel() {
  const PanelPort::Why& why = panel_.failure();
  note(why.cause, why.detail, why.text);
  return false;
}

/// Moves at the controller, signals, and the codes if there are any.
bool ForwardLink::read_panel() {
  const auto reply = panel_.ask(Register::queue_length);
  if (!reply || !panel_.read_signals(current_.panel)) return note_panel();
  if (reply->data.size() < 2) return note(Cause::bad_data), false;
  queued_ = reply->data[0] << 8 | reply->data[1];
  bits_ = reply->bits;
  const bool codes = (bits_ & (kErrorBit | kWarningBit)) != 0;
  if (!codes) current_.panel.error = current_.panel.warning = 0;
  return !codes || panel_.read_codes(current_.panel) || note_panel();
}

/// The controller counts the moves that it has, not those that have ended. One that somebody stopped has
/// none.
void ForwardLink::count_moves() {
  if (queued_ > 0 || halt_ != Halt::none) moved_at_ = time_;
  const bool stopped = !paused_ && (bits_ & (kErrorBit | kNotReadyBit)) != 0;
  if (forgotten_ || stopped) return;
  if (put_ - queued_ < ended_) return note(Cause::moves);
  ended_ = put_ - queued_;
}

void ForwardLink::judge() {
  const State state = current_.report.state;
  if (current_.panel.error != 0) return note(cause_of_error(current_.panel.error), current_.panel.error);
  if (current_.report.mode != Mode::position)
    return note(Cause::mode_changed, static_cast<int>(current_.report.mode));
  if (foreign_reports_ >= kForeignReports) return note(Cause::moves);
  if (halt_ != Halt::none || time_ - changed_at_ < kSettling) return;
  if (state == State::paused && paused_) return;
  if (!may_run(state)) return judge_stop();
  paused_ = false;  // somebody went on: it is paused again
}

void ForwardLink::judge_stop() {
  const PanelPort::Why why = panel_.explain_stop(current_.panel);
  if (why.cause != Cause::not_ready) note(why.cause, why.detail, why.text);
}

// --- what is sent ---------------------------------------------------------------------------------------

void ForwardLink::act() {
  if (cycles_seen_ == 0) return;
  if (halt_ == Halt::none) find_order();
  steer_pause();
  if (!fault_ && !panel_.write(wanted_)) note_panel();
  if (ordered_ && !fault_) send_order();
  if (halt_ != Halt::none && !fault_) go_on_halting();
}

bool ForwardLink::set_state(unsigned state) {
  if (!panel_.set(Register::set_state, state)) return note_panel();
  changed_at_ = time_;
  return true;
}

/// A paused robot comes to rest on its path, and goes on when it is ready again. Nothing is paused without a
/// move.
void ForwardLink::steer_pause() {
  const auto share = moves_.slider();
  const bool wanted = share && !(*share > 0);
  const bool moves = queued_ > 0 || current_.report.state == State::moving;
  if (halt_ != Halt::none || wanted == paused_ || (wanted && !moves)) return;
  if (set_state(wanted ? static_cast<unsigned>(State::paused) : 0)) paused_ = wanted;
}

/// The state "stopped" empties the queue; the robot stands. Then the controller becomes ready again, without
/// a move.
void ForwardLink::go_on_halting() {
  const State state = current_.report.state;
  switch (halt_) {
    case Halt::none:
      return;
    case Halt::asked:
      forgotten_ = true;
      if (set_state(static_cast<unsigned>(State::stopped))) halt_ = Halt::stopping;
      return;
    case Halt::stopping:
      if (state == State::stopped && has_stopped() && set_state(0)) halt_ = Halt::starting;
      return;
    case Halt::starting:
      if (!may_run(state) || queued_ != 0) return;
      halted_ = halting_;
      paused_ = false;
      halt_ = Halt::none;
      return;
  }
}

void ForwardLink::send_order() {
  switch (order_.kind) {
    case MoveOrder::Kind::halt:
      halting_ = order_.number;
      halt_ = Halt::asked;
      break;
    case MoveOrder::Kind::tool:
      if (!send_tool()) return;
      break;
    case MoveOrder::Kind::move:
      if (!send_move()) return;
      break;
    case MoveOrder::Kind::nothing:
      break;
  }
  ordered_ = false;
}

bool ForwardLink::send_move() {
  const UxMoveRequest request = encode(ux_move(order_, moves_.frame()), forms_);
  const int warning = current_.panel.warning;
  const auto reply = panel_.ask(request.reg, request.data);
  if (!reply) return note_panel();
  if (reply->bits & (kErrorBit | kNotReadyBit)) {
    const PanelPort::Why why = panel_.explain_stop(current_.panel);
    note(why.cause, why.detail, why.text);
    return false;
  }
  if (reply->bits & kWarningBit && !panel_.read_codes(current_.panel)) return note_panel();
  const int code = current_.panel.warning;
  const bool refused = code != warning && code >= kQueueFull && code <= kNoSolution;
  if (refused || reply->bits & kInvalidBit) return note(Cause::moves_refused, code), false;
  put_ = order_.number;
  forgotten_ = false;
  moved_at_ = time_;
  return true;
}

/// The TCP of the cell becomes that of the controller, until somebody sets another one or switches it off.
/// Where the controller says that it is also shows a wrong model or mounting. False: not yet, or a failure.
bool ForwardLink::send_tool() {
  if (!tool_set_) {
    const auto reply = panel_.ask(Register::tcp_offset, UxData().f32(pose_values(order_.tool)));
    if (!reply) return note_panel();
    if (reply->bits & kInvalidBit)
      return note(Cause::request_refused, static_cast<int>(Register::tcp_offset)), false;
    tool_set_ = time_;
  }
  const auto reply = panel_.ask(Register::tcp_pose);
  if (!reply) return note_panel();
  const auto values = floats(reply->data, 6);
  if (!values) return note(Cause::bad_data), false;
  Six six;
  std::copy_n(values->begin(), six.size(), six.begin());
  const Pose there = pose_from(six), here = forward::tcp_at(current_.q, order_.tool, moves_.frame());
  const Vec3 way = there.position - here.position;
  const double turn = angle_between(there.rotation, here.rotation);
  if (norm(way) < kSameTool && turn < kSameTurn) {
    tool_set_.reset();
    return true;
  }
  if (time_ - *tool_set_ > kTakingTool)
    note(Cause::tool_differs, static_cast<int>(std::lround(1000 * norm(way))),
         fmt::format("x {:.0f}, y {:.0f}, z {:.0f} mm, turned by {:.1f} degrees", 1000 * way.x, 1000 * way.y,
                     1000 * way.z, turn * wire::kDegrees));
  return false;
}

// --- the end --------------------------------------------------------------------------------------------

/// Its queue is emptied, the robot stops. In another mode it has no moves of ours, and is somebody else's.
/// False: it was not reached.
bool ForwardLink::send_stop() {
  if (current_.report.mode != Mode::position) return true;
  if (!port_.is_open() && !port_.open(settings_.answer)) return false;
  return panel_.set(Register::set_state, static_cast<unsigned>(State::stopped));
}

/// Sends a stop to the controller, whatever ended the link.
void ForwardLink::end() {
  if (!stop_sent_) {
    stop_sent_ = send_stop();
    ending_since_ = realtime::monotonic_now();
    still_reports_ = 0;
    if (stop_sent_) watchdog_.disarm();
    if (stop_sent_ || ++end_attempts_ < kEndAttempts) return;
    watchdog_.abandon();  // it tries for some time
    gone_ = over_ = true;
    return;
  }
  if (!report_socket_ || has_stopped() || realtime::monotonic_now() - ending_since_ > kToStand) over_ = true;
}

}  // namespace polyarm::xarm
