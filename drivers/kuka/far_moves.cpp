#include "drivers/kuka/far_moves.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/kuka/forward_link.hpp"
#include "drivers/kuka/move_shape.hpp"
#include "drivers/wire/six_axes.hpp"

namespace polyarm::kuka {

using wire::scaled;

namespace {

constexpr double kSpeedUp = 0.2;  // s, of an axis to its full speed
constexpr double kPathSpeed = 3;  // m/s ($VEL_MA.CP)

forward::PlayedArm arm_of(Machine& machine, int& ended) {
  forward::PlayedArm out = forward::arm_in_degrees(machine, ended, kSpeedUp);
  out.q = [&machine, q = Six{}]() mutable -> const Six& {
    return q = scaled(machine.setpoint(), wire::kRadians);
  };
  out.refuse = [&machine] { machine.stop_with_message(); };
  return out;
}

forward::PlayedMove played(const EkiMove& move, int number) {
  using Kind = hardware::ForwardMove::Kind;
  forward::PlayedMove out;
  out.number = number;
  if (move.kind == EkiMove::ptp) {
    out.goal = scaled(move.end, wire::kRadians);
    out.share = std::clamp(move.speed, 1.0, 100.0) / 100;
    out.acceleration = std::clamp(move.acceleration, 1.0, 100.0) / 100;
    out.blend_share = std::min(move.blend, 100.0) / 100;
    return out;
  }
  out.kind = move.kind == EkiMove::lin ? Kind::line : Kind::arc;
  out.end = pose_of(move.end);
  out.via_point = pose_of(move.via).position;
  out.speed = std::clamp(move.speed, 1e-3, kPathSpeed);
  out.acceleration = std::max(move.acceleration, 1e-2);
  out.turn = move.turn * wire::kRadians;
  out.blend = move.blend / 1000;
  return out;
}

}  // namespace

FarMoves::FarMoves(Machine& machine) : machine_(machine), player_(arm_of(machine, ended_), kMoveSlots) {}

EkiResult FarMoves::begin(int watchdog_ms) {
  if (on_) return EkiResult::busy;
  const EkiResult ready = machine_.begin_moves();
  if (ready != EkiResult::done) return ready;
  player_.forget();
  player_.set_tool({});
  on_ = true;
  ending_ = false;
  ++session_;
  ended_ = halted_ = halting_ = 0;
  watchdog_ = std::max(watchdog_ms, 1) / 1000.0;
  silence_ = 0;
  return EkiResult::done;
}

EkiResult FarMoves::take(const EkiRequest& request) {
  if (!of_session(request.value) || !request.move || request.move->kind == EkiMove::none || halting_ != 0)
    return EkiResult::not_ready;
  return !refuse && player_.take(played(*request.move, request.number)) ? EkiResult::done : EkiResult::busy;
}

EkiResult FarMoves::set_tool(int session, const EkiMove& tool) {
  if (!of_session(session)) return EkiResult::not_ready;
  player_.set_tool(pose_of(tool.end));
  return EkiResult::done;
}

void FarMoves::stop() {
  player_.forget();
  machine_.stop_moves();
}

EkiResult FarMoves::halt(int session, int number) {
  if (!of_session(session)) return EkiResult::not_ready;
  stop();
  halting_ = number;
  return EkiResult::done;
}

/// A program that does not run cannot do what it is asked for: it is cancelled.
EkiResult FarMoves::end() {
  if (!on_) return EkiResult::done;
  stop();
  ending_ = true;
  if (machine_.program_runs()) return EkiResult::done;
  machine_.cancel_program();
  on_ = false;
  return EkiResult::done;
}

void FarMoves::step(double dt) {
  time_ += dt;
  if (!on_) return;
  silence_ += dt;
  if (silence_ > watchdog_) end();
  if (!machine_.program_runs()) {
    player_.interrupt();
    if (machine_.program_is_free()) on_ = false, player_.forget();
    return;
  }
  if (halting_ != 0 || ending_) {
    if (!machine_.still()) return;
    if (!confirms_not) halted_ = std::max(halted_, std::exchange(halting_, 0));
    if (ending_) on_ = false;
    return;
  }
  player_.change_pace(machine_.speed_override() / 100.0, dt);
  player_.step(dt);
}

void FarMoves::fill(EkiState& state) const {
  state.moves = on_;
  state.session = session_;
  state.ended = ended_;
  state.halted = halted_;
  state.time_ms = std::llround(1000 * time_) % (1LL << 31);
}

}  // namespace polyarm::kuka
