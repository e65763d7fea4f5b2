/// PDOs, NMT, heartbeats and the motor of a simulated drive.
#include "drivers/cia402/far_drive.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::cia402 {

namespace {
constexpr std::uint32_t kUnused = 0x8000'0000, kIdentifier = 0x7FF;
constexpr std::int32_t kPositionMode = 8;
}  // namespace

FarDrive::FarDrive(const FarDriveOptions& options, Nanoseconds tick) : options_(options), tick_(tick) {
  fill();
  demand_ = target_ = std::round((options.start - options.offset) * options.counts_per_rad);
  refresh();
}

std::int32_t FarDrive::position() const {
  return static_cast<std::int32_t>(std::lround(demand_));
}

const char* FarDrive::state_name() const {
  constexpr const char* kNames[] = {
      "not ready to switch on", "switch on disabled", "ready to switch on",    "switched on",
      "operation enabled",      "quick stop active",  "fault reaction active", "fault"};
  return kNames[static_cast<int>(state_)];
}

void FarDrive::send(std::uint16_t id, std::vector<std::uint8_t> bytes, Frames& out) {
  if (faults.mute || !powered_) return;
  const CanFrame frame = frame_of(id, bytes);
  out.push_back(frame);
  if (faults.duplicate) out.push_back(frame);
}

void FarDrive::send_emergency(std::uint16_t code, Frames& out) {
  if (faults.no_emergency) return;
  const auto error_register = static_cast<std::uint8_t>(code == 0 ? 0 : 1 | (code >> 12 == 2 ? 2 : 0));
  set(0x1001, error_register);
  send(static_cast<std::uint16_t>(0x80 + options_.node),
       {static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code >> 8), error_register, 0, 0, 0, 0, 0},
       out);
}

// --- the network ------------------------------------------------------------------------------------------

void FarDrive::take(const CanFrame& frame, Frames& out) {
  if (!powered_) return;
  const int node = options_.node;
  if (frame.id == 0 && frame.size == 2 && (frame.data[1] == 0 || frame.data[1] == node))
    return on_nmt(frame.data[0], out);
  if (frame.id == 0x80 && frame.size == 0) return on_sync(out);
  if (frame.id == 0x600 + node && nmt_ != Nmt::stopped) return serve_sdo(frame, out);
  const std::uint32_t watched = value(0x1016, 1);
  if (watched != 0 && frame.id == 0x700 + (watched >> 16 & 0x7F)) {
    master_seen_ = true;
    master_lost_ = false;
    since_master_ = 0;
    return;
  }
  if (nmt_ == Nmt::operational) store_rpdo(frame);
}

void FarDrive::on_nmt(unsigned command, Frames& out) {
  const bool was = nmt_ == Nmt::operational;
  if (command == 0x01) nmt_ = Nmt::operational;
  if (command == 0x02) nmt_ = Nmt::stopped;
  if (command == 0x80) nmt_ = Nmt::pre_operational;
  if (command == 0x81 || command == 0x82) return reset(out);
  // Without PDOs nobody commands it any more.
  if (was && nmt_ != Nmt::operational && state_ == State::enabled) enter(State::quick_stop);
}

void FarDrive::store_rpdo(const CanFrame& frame) {
  for (int k = 0; k < 4; ++k) {
    const std::uint32_t id = value(static_cast<std::uint16_t>(0x1400 + k), 1);
    if (!(id & kUnused) && (id & kIdentifier) == frame.id) rpdos_[k] = frame;
  }
}

/// What came before is taken over; then the answers go out.
void FarDrive::on_sync(Frames& out) {
  if (nmt_ != Nmt::operational) return;
  for (const auto& [k, frame] : rpdos_) {
    const auto mapping = static_cast<std::uint16_t>(0x1600 + k);
    std::size_t at = 0;
    for (std::uint8_t sub = 1; sub <= value(mapping, 0); ++sub) {
      const std::uint32_t entry = value(mapping, sub);
      const std::size_t size = (entry & 0xFF) / 8;
      if (at + size > frame.size) break;
      std::uint32_t number = 0;
      for (std::size_t b = 0; b < size; ++b)
        number |= static_cast<std::uint32_t>(frame.data[at + b]) << (8 * b);
      at += size;
      set(static_cast<std::uint16_t>(entry >> 16), number, static_cast<std::uint8_t>(entry >> 8));
    }
  }
  const bool commanded = !rpdos_.empty();
  rpdos_.clear();
  if (commanded) {
    apply_control(value(0x6040), out);
    latch_target();
  }
  refresh();
  send_tpdos(out);
}

void FarDrive::send_tpdos(Frames& out) {
  Frames now;
  for (int k = 0; k < 4; ++k) {
    const auto communication = static_cast<std::uint16_t>(0x1800 + k);
    const std::uint32_t id = value(communication, 1);
    if ((id & kUnused) || value(communication, 2) != 1) continue;
    const auto mapping = static_cast<std::uint16_t>(0x1A00 + k);
    std::vector<std::uint8_t> bytes;
    for (std::uint8_t sub = 1; sub <= value(mapping, 0); ++sub) {
      const std::uint32_t entry = value(mapping, sub);
      const std::uint32_t number =
          value(static_cast<std::uint16_t>(entry >> 16), static_cast<std::uint8_t>(entry >> 8));
      for (unsigned b = 0; b < (entry & 0xFF) / 8; ++b)
        bytes.push_back(static_cast<std::uint8_t>(number >> (8 * b)));
    }
    send(static_cast<std::uint16_t>(id & kIdentifier), std::move(bytes), now);
  }
  out.insert(out.end(), late_.begin(), late_.end());
  late_.clear();
  if (faults.late > 0) {
    --faults.late;
    late_ = std::move(now);
  } else {
    out.insert(out.end(), now.begin(), now.end());
  }
}

void FarDrive::watch_master(Frames& out) {
  const std::uint32_t watched = value(0x1016, 1);
  if (watched == 0 || !master_seen_ || master_lost_) return;
  since_master_ += tick_;
  if (since_master_ <= static_cast<Nanoseconds>(watched & 0xFFFF) * 1'000'000) return;
  master_lost_ = true;
  set(0x603F, 0x8130);
  send_emergency(0x8130, out);
  if (nmt_ == Nmt::operational && !faults.stays_operational) nmt_ = Nmt::pre_operational;
  if (state_ != State::enabled) return;
  switch (signed_value(0x6007)) {
    case 1:
      enter(State::reaction);
      break;
    case 2:
      enter(State::disabled);
      break;
    case 3:
      enter(State::quick_stop);
      break;
    default:
      break;
  }
}

void FarDrive::tick(Frames& out) {
  if (!powered_) return;
  watch_master(out);
  const auto every = static_cast<Nanoseconds>(value(0x1017)) * 1'000'000;
  since_heartbeat_ += tick_;
  if (every > 0 && since_heartbeat_ >= every && !faults.no_heartbeat) {
    since_heartbeat_ = 0;
    const std::uint8_t state = nmt_ == Nmt::operational ? 0x05 : nmt_ == Nmt::stopped ? 0x04 : 0x7F;
    send(static_cast<std::uint16_t>(0x700 + options_.node), {state}, out);
  }
  move(out);
  refresh();
}

// --- orders -----------------------------------------------------------------------------------------------

void FarDrive::fail(std::uint16_t code, bool following_error, Frames& out) {
  faults.broken = true;
  following_error_ = following_error;
  set(0x603F, code);
  enter(state_ == State::enabled || state_ == State::quick_stop ? State::reaction : State::fault);
  send_emergency(code, out);
}

void FarDrive::reset(Frames& out) {
  fill();
  rpdos_.clear();
  late_.clear();
  transfer_ = {};
  nmt_ = Nmt::pre_operational;
  control_ = 0;
  following_error_ = master_seen_ = master_lost_ = false;
  enter(State::disabled);
  speed_ = 0;
  send(static_cast<std::uint16_t>(0x700 + options_.node), {0x00}, out);
  refresh();
}

void FarDrive::switch_off() {
  powered_ = false;
  enter(State::disabled);
  speed_ = 0;
}

void FarDrive::switch_on(Frames& out) {
  if (powered_) return;
  powered_ = true;
  reset(out);
}

void FarDrive::heal(Frames& out) {
  faults = {};
  switch_on(out);
}

// --- CiA 402 ----------------------------------------------------------------------------------------------

void FarDrive::enter(State state) {
  if (state == State::enabled && state_ != State::quick_stop) {
    demand_ = target_ = position();
    steps_ = 0;
  }
  if (state == State::enabled) target_ = demand_, steps_ = 0, speed_ = 0;
  if (state != State::enabled && state != State::quick_stop && state != State::reaction) speed_ = 0;
  state_ = state;
}

/// Levels of the controlword's bits, as a drive without edges takes them.
void FarDrive::apply_control(std::uint32_t word, Frames& out) {
  const bool rises = (word & 0x80) && !(control_ & 0x80);
  control_ = word;
  if (state_ == State::fault) {
    if (!rises || faults.broken) return;
    following_error_ = false;
    set(0x603F, 0);
    send_emergency(0, out);
    return enter(State::disabled);
  }
  if (state_ == State::reaction || state_ == State::not_ready) return;
  const bool voltage = word & 2, no_quick_stop = word & 4, on = word & 1, enable = word & 8;
  if (!voltage) return enter(State::disabled);
  if (!no_quick_stop) {
    if (state_ == State::enabled) enter(State::quick_stop);
    if (state_ == State::ready || state_ == State::on) enter(State::disabled);
    return;
  }
  if (state_ == State::disabled) {
    if (!on && !faults.safe_torque_off) enter(State::ready);
    return;
  }
  if (state_ == State::quick_stop) {
    const bool stays = signed_value(0x605A) >= 5;
    if (on && enable && stays && !faults.quick_stop_input) enter(State::enabled);
    return;
  }
  if (!on) return enter(State::ready);
  if (state_ == State::ready) return enter(State::on);
  if (!enable) return enter(State::on);
  if (state_ == State::on && !faults.never_enables) enter(State::enabled);
}

/// The target of this SYNC is reached when the next one is due.
void FarDrive::latch_target() {
  if (state_ != State::enabled || signed_value(0x6060) != kPositionMode) return;
  const double target = signed_value(0x607A);
  jump_ = std::max(jump_, std::abs((target - target_) / options_.counts_per_rad));
  target_ = target;
  const double period = value(0x60C2, 1) * std::pow(10.0, static_cast<double>(signed_value(0x60C2, 2))) * 1e9;
  steps_ = std::max(1, static_cast<int>(std::lround(period / static_cast<double>(tick_))));
}

void FarDrive::move(Frames&) {
  if (faults.quick_stop_input && state_ == State::enabled) enter(State::quick_stop);
  if (faults.safe_torque_off && state_ != State::fault && state_ != State::disabled) enter(State::disabled);
  if (state_ == State::enabled) {
    const double before = demand_;
    demand_ = steps_ > 1 ? demand_ + (target_ - demand_) / steps_ : target_;
    if (steps_ > 0) --steps_;
    speed_ = demand_ - before;
    return;
  }
  if (state_ != State::quick_stop && state_ != State::reaction) return;
  const double dt = static_cast<double>(tick_) * 1e-9;
  const double slower = value(0x6085) * dt * dt;
  speed_ = std::abs(speed_) <= slower ? 0 : speed_ - std::copysign(slower, speed_);
  demand_ += speed_;
  if (speed_ != 0) return;
  demand_ = std::round(demand_);
  if (state_ == State::reaction) return enter(State::fault);
  if (signed_value(0x605A) < 5) enter(State::disabled);
}

std::uint32_t FarDrive::statusword() const {
  constexpr std::uint32_t kOfState[] = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08};
  std::uint32_t out = kOfState[static_cast<int>(state_)];
  out |= 1U << 9;                                                 // it takes commands of the bus
  if (!faults.safe_torque_off) out |= 1U << 4;                    // voltage
  if (state_ == State::disabled && control_ & 4) out |= 1U << 5;  // no quick stop is commanded
  if (faults.warning) out |= 1U << 7;
  if (faults.limit) out |= 1U << 11;
  if (state_ == State::enabled) out |= 1U << 12;  // it follows
  if (following_error_) out |= 1U << 13;
  return out;
}

/// The objects that it measures.
void FarDrive::refresh() {
  set(0x6041, statusword());
  set(0x6064, static_cast<std::uint32_t>(position()));
  const double per_second = 1e9 / static_cast<double>(tick_);
  set(0x606C, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(speed_ * per_second))));
  set(0x6061, faults.other_mode ? 1 : value(0x6060));
  set(0x6077, state_ == State::enabled ? 100 : 0);
  set(0x1000, faults.wrong_device ? 0x0003'0191 : 0x0002'0192);
  set(0x6502, faults.no_position_mode ? 0x25 : 0xA5);
}

}  // namespace polyarm::cia402
