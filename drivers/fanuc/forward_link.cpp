/// What the link in forward mode does while it is open: the thread that reads, judges and sends.
#include "drivers/fanuc/forward_link.hpp"

#include <poll.h>

#include <algorithm>
#include <cmath>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::fanuc {

using hardware::ForwardMove;

namespace {

constexpr Nanoseconds kLook = 5'000'000;         // between two looks without an event
constexpr Nanoseconds kAskWhy = 100'000'000;     // between two questions for the alarm
constexpr int kStatusTurns = 4;  // of that many rounds one reads the status, the others an input
constexpr int kWhys = 4;         // requests for an alarm; after them the controller counts as without one
constexpr int kBegins = 100;     // of remote motion, one with each reading: the aborted program may still end
constexpr double kStill = 4e-5;  // rad between two readings, whose places are 0.001 degrees
constexpr int kStillReadings = 2;
constexpr int kRunning = 0, kOnHold = 2;  // ProgramStatus

}  // namespace

// --- control thread -------------------------------------------------------------------------------------

bool ForwardLink::accept(const ForwardMove& move) noexcept {
  if (!moves_.accept(move)) return false;
  wake();
  return true;
}

void ForwardLink::set_pace(double share) noexcept {
  if (pace_.exchange(share) != share) wake();
}

void ForwardLink::clear() noexcept {
  moves_.clear();
  wake();
}

hardware::ForwardFlow ForwardLink::flow() const noexcept {
  hardware::ForwardFlow out;
  const bool held = pace_.load() == 0;
  const bool seen = hold_seen_.load();
  out.idle = moves_.idle();
  out.done = moves_.done();
  const bool quiet = held ? seen && (!carries_out_.load() || paused_.load()) : out.idle;
  out.standing = at_rest_.load() && quiet;
  return out;
}

void ForwardLink::cycle(const Outputs& outputs) noexcept {
  outputs_.write(outputs);
  cycles_.fetch_add(1, std::memory_order_release);
}

bool ForwardLink::exchange(Nanoseconds timeout) noexcept {
  const std::uint64_t before = rounds_.load();
  const Nanoseconds end = realtime::monotonic_now() + timeout;
  round_wanted_ = true;
  wake();
  while (rounds_.load() == before) {
    if (rmi_gone_.load() || cause() != Cause::none) return false;
    if (!await(std::max<Nanoseconds>(end - realtime::monotonic_now(), 0))) return false;
  }
  fetch();
  return true;
}

// --- the thread -----------------------------------------------------------------------------------------

void ForwardLink::wait() {
  pollfd polled[2] = {{wake_.number(), POLLIN, 0}, {rmi_gone_ ? -1 : rmi_.descriptor(), POLLIN, 0}};
  const timespec time{0, static_cast<long>(kLook)};
  ::ppoll(polled, 2, &time, nullptr);
}

void ForwardLink::run() {
  while (!quit_) {
    wait();
    calm(wake_.number());
    const Nanoseconds now = realtime::monotonic_now();
    if (!rmi_gone_) take(now);
    take_wanted(now);
    land(now);
    act(now);
    judge(now);
    publish();
  }
}

void ForwardLink::take(Nanoseconds now) {
  if (rmi_.poll([&](const RmiMessage& message) { take_answer(message, now); })) return;
  rmi_gone_ = true;
  note(Cause::rmi_closed);
}

void ForwardLink::take_answer(const RmiMessage& message, Nanoseconds now) {
  if (message.name == "FRC_Terminate") return note(Cause::terminated);
  if (message.name == "FRC_SystemFault") return suspect();
  if (message.kind == RmiMessage::Kind::instruction) return take_instruction(message);
  const bool ours = message.name == asked_name_ || message.name == "Unknown";
  if (message.kind != RmiMessage::Kind::command || asked_ == Asked::nothing || !ours) return;
  const Asked what = std::exchange(asked_, Asked::nothing);
  if (what == Asked::initialize && message.error() != 0 && ++begins_ < kBegins) {
    begin_after_ = current_.count + 1;
    return;
  }
  const bool reads =
      what == Asked::status || what == Asked::joints || what == Asked::input || what == Asked::error;
  if (message.error() != 0 && !reads && what != Asked::abort) {
    if (message.error() != kRmiNotRunning && message.error() != kRmiHold && message.error() != kRmiNotPaused)
      refusal_ = {message.error(), asked_name_};
    return suspect();  // an alarm may be the reason
  }
  switch (what) {
    case Asked::status:
      return take_status(message);
    case Asked::joints:
      return take_joints(message, now);
    case Asked::error:
      return take_alarm(message);
    case Asked::input:
      if (message.error() != 0) return note(Cause::io_refused, message.error());
      current_.inputs[static_cast<std::size_t>(input_)] =
          message.number("PortValue") != 0 || message.text("PortValue") == "ON";
      input_ = (input_ + 1) % settings_.inputs.count;
      return;
    case Asked::output:
      current_.outputs[static_cast<std::size_t>(output_)] =
          wanted_.digital[static_cast<std::size_t>(output_)] > 0.5;
      return;
    case Asked::pause:
      paused_ = true;
      still_ = 0;
      return;
    case Asked::resume:
      paused_ = false;
      return;
    case Asked::abort:
      aborted_ = true;
      return;
    case Asked::initialize:
      aborted_ = paused_ = false;
      sequence_ = 1;
      begins_ = 0;
      begin_after_ = 0;
      moves_.forget();
      return;
    case Asked::pace:
      percent_ = percent_asked_;
      return;
    case Asked::tool_data:
      return;
    case Asked::tool:
      tool_ = tool_asked_;
      return;
    case Asked::configuration:
      configuration_ = configuration_of(message);
      configuration_known_ = true;
      return;
    case Asked::nothing:
      return;
  }
}

void ForwardLink::take_status(const RmiMessage& message) {
  current_.ready = message.number("ServoReady") != 0;
  current_.teach = message.number("TPMode") != 0;
  if (phase_ != Phase::active || fault_) return;
  if (current_.teach) return note(Cause::teach_mode);
  const int program = message.whole("ProgramStatus", 0, 10).value_or(kRunning);
  const bool ours = program == kRunning || (program == kOnHold && paused_) || aborted_;
  if (!current_.ready || !ours) suspect();
}

void ForwardLink::take_joints(const RmiMessage& message, Nanoseconds now) {
  constexpr const char* kKeys[] = {"JointAngle.J1", "JointAngle.J2", "JointAngle.J3",
                                   "JointAngle.J4", "JointAngle.J5", "JointAngle.J6"};
  Six joints;
  for (std::size_t i = 0; i < 6; ++i) joints[i] = message.number(kKeys[i], NAN);
  const Six q = radians_of(joints);
  if (!std::all_of(q.begin(), q.end(), [](double v) { return std::abs(v) < 1000; }))
    return note(Cause::bad_data, 0, "FRC_ReadJointAngles");
  const auto tag = static_cast<Nanoseconds>(message.number("TimeTag") * 1e6);
  const Nanoseconds at = settings_.stepped ? tag : now;  // TimeTag: ms
  if (current_.count > 0 && at > read_at_) {
    for (std::size_t i = 0; i < 6; ++i) current_.dq[i] = (q[i] - current_.q[i]) / seconds(at - read_at_);
    still_ = forward::largest_difference(q, current_.q) < kStill ? still_ + 1 : 0;
  }
  read_at_ = at;
  current_.q = q;
  ++current_.count;
  current_.moving = still_ < kStillReadings;
  current_.error = suspected_;
  round_ = Round::over;
  samples_.write(current_);
}

/// The cause of what was suspected.
void ForwardLink::take_alarm(const RmiMessage& message) {
  const std::string alarm = message.text("ErrorData");
  if (const Cause cause = cause_of_alarm(alarm); cause != Cause::none) return note(cause, 0, alarm);
  if (++errors_ < kWhys) return;
  if (refusal_.first != 0) return note(Cause::rmi_refused, refusal_.first, refusal_.second);
  note(Cause::program_stopped);
}

void ForwardLink::take_instruction(const RmiMessage& message) {
  const int sequence = message.whole("SequenceID", 0, 1 << 30).value_or(0);
  const auto& sent = moves_.sent();
  const bool ours =
      std::any_of(sent.begin(), sent.end(), [&](const auto& one) { return one.number == sequence; });
  if (!ours || fault_ || moves_.clearing()) return;
  if (const int error = message.error(); error != 0) {
    if (error == kRmiHold || error == kRmiNotRunning || suspected_) return suspect();
    return note(Cause::move_refused, error, message.name);
  }
  moves_.end_up_to(sequence);
}

void ForwardLink::take_wanted(Nanoseconds now) {
  moves_.collect();
  if (outputs_.fetch()) wanted_ = outputs_.value();
  if (const std::uint64_t cycles = cycles_.load(std::memory_order_acquire); cycles != cycles_seen_) {
    cycles_seen_ = cycles;
    cycled_at_ = now;
  }
}

void ForwardLink::land(Nanoseconds now) {
  if (const auto joint = moves_.land(current_.q, !current_.moving, seconds(now)))
    note(Cause::off_target, *joint);
}

void ForwardLink::ask(Asked what, const RmiLine& line, Nanoseconds now) {
  constexpr const char* kNames[] = {"",
                                    "FRC_GetStatus",
                                    "FRC_ReadJointAngles",
                                    "FRC_ReadDIN",
                                    "FRC_WriteDOUT",
                                    "FRC_Pause",
                                    "FRC_Continue",
                                    "FRC_Abort",
                                    "FRC_Initialize",
                                    "FRC_SetOverRide",
                                    "FRC_WriteUToolData",
                                    "FRC_SetUFrameUTool",
                                    "FRC_ReadCartesianPosition",
                                    "FRC_ReadError"};
  asked_ = what;
  asked_name_ = kNames[static_cast<std::size_t>(what)];
  asked_at_ = now;
  if (rmi_.send(line)) return;
  rmi_gone_ = true;
  note(Cause::rmi_closed);
}

/// One command at a time, the most urgent first; instructions go out while no command is open.
void ForwardLink::act(Nanoseconds now) {
  hold_seen_ = false;
  if (pace_.load() == 0) hold_seen_ = true;
  if (asked_ != Asked::nothing || rmi_gone_) return;
  if (fault_) {
    if (act_on_fault(now)) return;
  } else if (phase_ == Phase::active) {
    if (suspected_ && now - error_at_ > (settings_.stepped ? 0 : kAskWhy)) {
      error_at_ = now;
      return ask(Asked::error, RmiLine("Command", "FRC_ReadError").number("Count", 1), now);
    }
    if (act_on_outputs(now)) return;
    if (moves_.clearing() ? act_on_clear(now) : !suspected_ && (act_on_pace(now) || send_moves(now))) return;
  }
  read_on(now);
}

/// Whatever ended the link, nothing goes on by itself at the controller.
bool ForwardLink::act_on_fault(Nanoseconds now) {
  if (phase_ != Phase::active || aborted_) return false;
  ask(Asked::abort, {"Command", "FRC_Abort"}, now);
  return true;
}

/// Comes to rest on the path first; then the controller forgets its instructions.
bool ForwardLink::act_on_clear(Nanoseconds now) {
  if (moves_.sent().empty() && !aborted_) {
    moves_.forget();
    return false;
  }
  if (aborted_) {
    if (current_.count < begin_after_) return false;
    ask(Asked::initialize, RmiLine("Command", "FRC_Initialize").number("GroupMask", 1), now);
    return true;
  }
  if (paused_ && still_ < kStillReadings) return false;
  if (paused_)
    ask(Asked::abort, {"Command", "FRC_Abort"}, now);
  else
    ask(Asked::pause, {"Command", "FRC_Pause"}, now);
  return true;
}

bool ForwardLink::act_on_pace(Nanoseconds now) {
  const double pace = pace_.load();
  if (pace == 0) {
    if (moves_.sent().empty() || paused_) return false;
    ask(Asked::pause, {"Command", "FRC_Pause"}, now);
    return true;
  }
  percent_asked_ = std::clamp(static_cast<int>(std::lround(100 * pace)), 1, 100);
  if (percent_asked_ != percent_)
    ask(Asked::pace, RmiLine("Command", "FRC_SetOverRide").number("Value", percent_asked_), now);
  else if (paused_) {
    still_ = 0;  // from here on it may move, whatever the pace becomes
    ask(Asked::resume, {"Command", "FRC_Continue"}, now);
  } else
    return false;
  return true;
}

bool ForwardLink::act_on_outputs(Nanoseconds now) {
  for (int i = 0; i < settings_.outputs.count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double wanted = wanted_.digital[at];
    if (!std::isfinite(wanted) || (wanted > 0.5) == (current_.outputs[at] > 0.5)) continue;
    output_ = i;
    ask(Asked::output,
        RmiLine("Command", "FRC_WriteDOUT")
            .number("PortNumber", settings_.outputs.first + i)
            .text("PortValue", wanted > 0.5 ? "ON" : "OFF"),
        now);
    return true;
  }
  return false;
}

/// False: the move waits, or a command went out that it needs.
bool ForwardLink::ready_to_send(const ForwardMove& next, Nanoseconds now) {
  const Pose tool = tool_of(next, settings_.frame);
  const bool same_tool = tool_ && norm(tool_->position - tool.position) < 1e-6 &&
                         angle_between(tool_->rotation, tool.rotation) < 1e-6;
  const bool knows = next.kind != ForwardMove::Kind::arc || configuration_known_;
  if (same_tool && knows) return true;
  if (!moves_.sent().empty() || current_.moving) return false;
  if (!same_tool && tool_asked_ && norm(tool_asked_->position - tool.position) < 1e-6 &&
      angle_between(tool_asked_->rotation, tool.rotation) < 1e-6) {
    ask(Asked::tool,
        RmiLine("Command", "FRC_SetUFrameUTool")
            .number("UFrameNumber", 0)
            .number("UToolNumber", settings_.frame.tool)
            .number("Group", 1),
        now);
  } else if (!same_tool) {
    tool_asked_ = tool;
    ask(Asked::tool_data, tool_line(tool, settings_.frame), now);
  } else {
    ask(Asked::configuration, RmiLine("Command", "FRC_ReadCartesianPosition").number("Group", 1), now);
  }
  return false;
}

/// True if a command went out.
bool ForwardLink::send_moves(Nanoseconds now) {
  while (pace_.load() > 0 && moves_.may_send(static_cast<std::size_t>(settings_.window))) {
    const auto& waiting = moves_.waiting();
    const ForwardMove& next = waiting.front();
    if (!ready_to_send(next, now)) return asked_ != Asked::nothing;
    const bool joint = next.kind == ForwardMove::Kind::joint;
    const bool before_arc = joint && waiting.size() > 1 && waiting[1].kind == ForwardMove::Kind::arc;
    if (joint) configuration_known_ = false;
    if (!rmi_.send(instruction_of(next, settings_.frame, sequence_, before_arc, configuration_))) {
      rmi_gone_ = true;
      note(Cause::rmi_closed);
      return false;
    }
    moves_.send(sequence_++, current_.q);
    still_ = 0;
  }
  return false;
}

/// The next question of a round of readings: the status or an input, then the joints.
void ForwardLink::read_on(Nanoseconds now) {
  const bool own = !settings_.stepped || own_rounds_;
  if (round_ == Round::over) {
    round_ = Round::none;
    next_round_ = now + settings_.poll;
    publish();  // before anybody who waits for the round looks
    rounds_.fetch_add(1);
    begin_cycle();
  }
  if (round_ == Round::none) {
    if (own ? now < next_round_ : !round_wanted_.exchange(false)) return;
    round_ = Round::begun;
    if (turn_++ % kStatusTurns == 0 || settings_.inputs.count == 0)
      return ask(Asked::status, {"Command", "FRC_GetStatus"}, now);
    return ask(Asked::input,
               RmiLine("Command", "FRC_ReadDIN").number("PortNumber", settings_.inputs.first + input_), now);
  }
  round_ = Round::joints;
  ask(Asked::joints, RmiLine("Command", "FRC_ReadJointAngles").number("Group", 1), now);
}

void ForwardLink::judge(Nanoseconds now) {
  if (asked_ != Asked::nothing && now - asked_at_ > settings_.silence) {
    note(Cause::rmi_silent, 0, asked_name_);
    asked_ = Asked::nothing;  // the abort goes out: the controller may hear what it does not answer
  }
  if (phase_ != Phase::active || fault_) return;
  if (cycles_seen_ > 0 && now - cycled_at_ > settings_.loop_silence) note(Cause::loop_silent);
}

void ForwardLink::publish() {
  at_rest_ = still_ >= kStillReadings;
  carries_out_ = !moves_.sent().empty();
  changed_.notify_all();
}

}  // namespace polyarm::fanuc
