/// What a link does while it is open: the thread that sends, takes and judges.
#include "drivers/cia402/link.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::cia402 {

namespace {
// For the answers of drives in this process: of those that answered in the last cycle, and of the others.
constexpr Nanoseconds kStepAnswer = 500'000'000, kStepLost = 20'000'000;
constexpr Nanoseconds kStopping = 3'000'000'000;
constexpr int kStillCycles = 3, kEnabledCycles = 2;
constexpr double kStill = 0.02;      // rad/s
constexpr int kMostResets = 60;      // cycles until a fault that does not go counts as one that stays
constexpr int kAskCode = 3;          // cycles until a drive in fault is asked for its code
constexpr int kPuzzled = 25;         // cycles until a fault without a code is named as such
constexpr int kUnexplained = 3;      // cycles until a drive that was switched off is named
constexpr double kOfCycle = 0.85;    // share of a cycle in which the answers must come
constexpr int kFramesInTurn = 1000;  // of a bus that never stops
constexpr std::uint16_t kCodeFollowing = 0x8611;

std::uint32_t bit(std::size_t joint) {
  return 1U << joint;
}
}  // namespace

void Link::command(bool move, const Joints& joints) noexcept {
  commands_.write({move, joints});
}

// --- the cycle --------------------------------------------------------------------------------------------

void Link::run() {
  now_ = due_ = realtime::monotonic_now();
  clock_changed_ = true;
  while (!quit_) {
    if (stepped_) {
      serve_step();
      continue;
    }
    listen_until(due_);
    if (quit_ || stepped_) continue;
    const Nanoseconds before = now_;
    now_ = realtime::monotonic_now();
    gap_ = now_ - before > Nanoseconds{settings_.heartbeat_ms} * 500'000 + settings_.cycle;
    due_ = std::max(due_ + settings_.cycle, now_);
    cycle();
  }
}

/// A cycle for each exchange().
void Link::serve_step() {
  wire::wait_readable(wake_.number(), kStepAnswer);
  calm(wake_.number());
  if (served_ == asked_) return;
  served_ = asked_;
  now_ += settings_.cycle;
  gap_ = false;
  cycle();
  ::eventfd_write(done_.number(), 1);
}

/// Nobody was silent while another clock ran.
void Link::keep_time() {
  if (!clock_changed_.exchange(false)) return;
  if (!stepped_) now_ = due_ = realtime::monotonic_now();
  for (Drive& drive : drives_) drive.alive = now_;
  beaten_at_ = commanded_at_ = began_at_ = ending_since_ = now_;
}

void Link::cycle() {
  keep_time();
  ++current_.cycle;
  blind_ = blind_ || gap_;
  guard();
  for (Drive& drive : drives_) drive.state_new = drive.feedback_new = false;
  take_command();
  steer();
  send_all();
  collect();
  if (std::all_of(drives_.begin(), drives_.end(), [](const Drive& drive) { return drive.state_new; }))
    blind_ = false;
  judge();
  publish();
}

/// After a hang the commands are old: the watchdog is asked first.
void Link::guard() {
  if (!armed_ || fault_) return;
  const std::lock_guard lock(watch_mutex_);
  if (!watchdog_.running()) return;
  watchdog::Health health = watchdog_.listen();
  if (health == watchdog::Health::fine) health = watchdog_.beat();
  if (health != watchdog::Health::fine)
    note(Cause::watchdog, 0, watchdog::sentence(health, watchdog_names()));
}

void Link::take_command() {
  if (renew_) {  // a new start
    renew_ = false;
    enabled_for_ = 0;
    commanded_ = false;
    troubled_.reset();
    began_at_ = now_;
    for (Drive& drive : drives_) {
      drive.resets = drive.puzzled = drive.code = 0;
      drive.target = drive.state.position;  // also of one that somebody else has enabled
      drive.emergency = {};
    }
  }
  const bool fresh = commands_.fetch();
  if (phase_ != Phase::streaming) return;
  commanded_ = commanded_ || fresh;
  if (fresh || !commanded_) commanded_at_ = now_;
}

// --- what is sent -----------------------------------------------------------------------------------------

void Link::steer() {
  const Wanted& wanted = commands_.value();
  const bool follows = phase_ == Phase::streaming && !brakes();
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    Drive& drive = drives_[j];
    if (brakes()) {
      drive.control = towards_standstill(drive.now);
    } else if (follows) {
      drive.control = control::kEnable;
      if (commanded_ && wanted.move) set_target(j, wanted.joints[j]);
    } else if (phase_ == Phase::starting) {
      steer_to_start(j);
    }
  }
}

void Link::set_target(std::size_t joint, double angle) {
  const double counts = std::round(settings_.joints[joint].scale.counts(angle));
  if (std::abs(counts) < 2147483647.0)
    drives_[joint].target = static_cast<std::int32_t>(counts);
  else
    note(Cause::out_of_range, static_cast<int>(joint));
}

/// Until a drive is enabled, its target is where it is measured.
void Link::steer_to_start(std::size_t joint) {
  Drive& drive = drives_[joint];
  if (drive.now != DriveState::enabled) drive.target = drive.state.position;
  drive.control = towards_enabled(drive.now);
  if (drive.now == DriveState::fault) steer_fault(joint);
}

/// A reset is an edge of its bit.
void Link::steer_fault(std::size_t joint) {
  Drive& drive = drives_[joint];
  const std::string whose = who(settings_.joints[joint]);
  if (settings_.fault_reset && drive.resets++ < kMostResets) {
    drive.control = drive.resets % 2 == 0 ? control::kFaultReset : control::kDisableVoltage;
    if (drive.resets == kMostResets / 2)
      bus_->send(upload_request(settings_.joints[joint].node, object::kErrorCode));
    return;
  }
  drive.control = control::kDisableVoltage;
  give_up_start(Cause::drive_fault, drive.emergency.code != 0 ? drive.emergency.code : drive.code, whose);
}

/// Targets first: the drives take them over at the SYNC.
void Link::send_all() {
  if (bus_lost_) return;
  const auto send = [&](const CanFrame& frame) { bus_trouble(bus_->send(frame)); };
  const Nanoseconds beat = Nanoseconds{settings_.heartbeat_ms} * 250'000;
  if (now_ - beaten_at_ >= beat || current_.cycle == 1) {
    beaten_at_ = now_;
    send(heartbeat(settings_.master, NmtState::operational));
  }
  const bool commands = phase_ != Phase::idle && !(phase_ == Phase::ending && stands_) && !blind_;
  for (std::size_t j = 0; commands && j < drives_.size() && !bus_lost_; ++j)
    send(command_pdo(settings_.joints[j].node, drives_[j].control, drives_[j].target));
  if (!bus_lost_) send(sync());
}

void Link::bus_trouble(BusState state) {
  switch (state) {
    case BusState::gone:
      bus_lost_ = true;
      return note(Cause::bus_gone);
    case BusState::failed:
      bus_lost_ = true;
      return note(Cause::bus_failed);
    case BusState::off:
      return note(Cause::bus_off);
    case BusState::ok:
    case BusState::nothing:
    case BusState::full:  // counted; the silence that follows is judged
      return;
  }
}

// --- what comes -------------------------------------------------------------------------------------------

std::optional<std::size_t> Link::joint_of(int node) const noexcept {
  for (std::size_t j = 0; j < settings_.joints.size(); ++j)
    if (settings_.joints[j].node == node) return j;
  return std::nullopt;
}

bool Link::all_here() const noexcept {
  return std::all_of(drives_.begin(), drives_.end(),
                     [](const Drive& drive) { return drive.state_new && drive.feedback_new; });
}

void Link::listen_until(Nanoseconds deadline) {
  for (int n = 0; n < kFramesInTurn && !quit_ && !stepped_; ++n) {
    CanFrame frame;
    if (bus_lost_) {
      wire::wait_readable(wake_.number(), std::max<Nanoseconds>(0, deadline - realtime::monotonic_now()));
      return;
    }
    const BusState state = bus_->receive(frame, deadline);
    if (state == BusState::nothing) return;
    if (state == BusState::ok)
      take(frame);
    else
      bus_trouble(state);
  }
}

/// Until all answers are here, or their time is over.
void Link::collect() {
  const auto expected = [](const Drive& drive) {
    return drive.lost > 0 || (drive.state_new && drive.feedback_new);
  };
  const Nanoseconds begin = realtime::monotonic_now();
  const auto share = static_cast<Nanoseconds>(kOfCycle * static_cast<double>(settings_.cycle));
  for (int n = 0; n < kFramesInTurn && !bus_lost_ && !all_here(); ++n) {
    const bool waits = !std::all_of(drives_.begin(), drives_.end(), expected);
    const Nanoseconds deadline = !stepped_ ? now_ + share : begin + (waits ? kStepAnswer : kStepLost);
    CanFrame frame;
    const BusState state = bus_->receive(frame, deadline);
    if (state == BusState::nothing) break;
    if (state == BusState::ok)
      take(frame);
    else
      bus_trouble(state);
  }
}

void Link::take(const CanFrame& frame) {
  if (frame.id == kNmt) return note(Cause::other_master, 0, "NMT");
  if (frame.id == kSync) return note(Cause::other_master, 0, "SYNC");
  if (take_pdo(frame) || take_heartbeat(frame)) return;
  if (const auto joint = joint_of(node_of(frame, kEmergency))) {
    if (const auto emergency = emergency_of(frame)) drives_[*joint].emergency = *emergency;
    return;
  }
  const auto joint = joint_of(node_of(frame, kSdoAnswer));
  if (!joint) return;
  const SdoAnswer answer = read_answer(frame);
  if (answer.kind == SdoKind::expedited && answer.object == object::kErrorCode && answer.size == 2)
    drives_[*joint].code = static_cast<std::uint16_t>(get(answer.data, 0, 2));
}

bool Link::take_pdo(const CanFrame& frame) {
  if (const auto joint = joint_of(node_of(frame, kTpdo1))) {
    const auto state = state_pdo(frame);
    if (!state) return true;  // a wrong length is a position that did not come
    Drive& drive = drives_[*joint];
    drive.state = *state;
    drive.now = state_of(state->statusword);
    drive.state_new = drive.seen = true;
    drive.lost = 0;
    return true;
  }
  if (const auto joint = joint_of(node_of(frame, kTpdo2))) {
    if (const auto feedback = feedback_pdo(frame)) {
      drives_[*joint].feedback = *feedback;
      drives_[*joint].feedback_new = true;
    }
    return true;
  }
  return false;
}

bool Link::take_heartbeat(const CanFrame& frame) {
  const int node = node_of(frame, kHeartbeat);
  if (node == 0) return false;
  if (node == settings_.master) return note(Cause::other_master, 0, "the heartbeat"), true;
  const auto joint = joint_of(node);
  if (!joint) return true;
  Drive& drive = drives_[*joint];
  drive.nmt = state_of_heartbeat(frame);
  drive.alive = now_;
  drive.restarted = drive.restarted || (drive.seen && drive.nmt == NmtState::boot_up);
  return true;
}

// --- judgement --------------------------------------------------------------------------------------------

void Link::note_drive(std::size_t joint, Cause cause, int detail) {
  note(cause, detail, who(settings_.joints[joint]));
}

void Link::judge() {
  count_lost();
  const bool runs = phase_ == Phase::streaming;
  for (std::size_t j = 0; runs && !fault_ && j < drives_.size(); ++j) judge_drive(j);
  for (std::size_t j = 0; !fault_ && j < drives_.size(); ++j) judge_network(j);
  if (!fault_) judge_silence();
  if (runs && !fault_ && commanded_ && now_ - commanded_at_ > settings_.loop_silence)
    note(Cause::loop_silent);
  if (phase_ == Phase::starting) judge_start();
  judge_stand();
}

void Link::count_lost() {
  for (Drive& drive : drives_) {
    if (drive.state_new || !drive.seen || gap_) continue;
    ++drive.lost;
    ++current_.lost;
  }
}

void Link::judge_silence() {
  const auto quiet = [](const Drive& drive) { return drive.lost > 0; };
  if (std::none_of(drives_.begin(), drives_.end(), quiet)) refused_before_ = bus_->refused();
  for (std::size_t j = 0; j < drives_.size() && !silent_; ++j) {
    if (!lost(drives_[j])) continue;
    silent_ = j;  // all others stop at once; its heartbeat may name the cause
    silent_since_ = now_;
  }
  // Before the arm moves, a drive may come back: this computer was only slow.
  const bool moves = phase_ == Phase::streaming || phase_ == Phase::ending;
  if (silent_ && !moves && drives_[*silent_].lost == 0) silent_.reset();
  if (silent_) return name_silence();
  judge_heartbeats();
}

void Link::name_silence() {
  const Nanoseconds patience = Nanoseconds{settings_.heartbeat_ms} * 1'000'000;
  if (bus_->refused() > refused_before_) return note(Cause::bus_off);
  const bool alive = drives_[*silent_].alive > silent_since_;
  if (!alive && now_ - silent_since_ <= patience) return;
  const bool all =
      std::all_of(drives_.begin(), drives_.end(), [](const Drive& drive) { return drive.lost > 0; });
  if (all && drives_.size() > 1) return note(Cause::all_silent);
  note_drive(*silent_, Cause::silent);
}

void Link::judge_heartbeats() {
  const Nanoseconds patience = Nanoseconds{settings_.heartbeat_ms} * 1'000'000 + 2 * settings_.cycle;
  for (std::size_t j = 0; j < drives_.size() && seen_all_ && !gap_; ++j)
    if (now_ - drives_[j].alive > patience) return note_drive(j, Cause::no_heartbeat);
}

/// What a heartbeat says since the first position came.
void Link::judge_network(std::size_t joint) {
  const Drive& drive = drives_[joint];
  if (drive.restarted) return note_drive(joint, Cause::restarted);
  if (!seen_all_ || drive.nmt == NmtState::operational || drive.nmt == NmtState::unknown) return;
  note_drive(joint, Cause::not_operational, static_cast<int>(drive.nmt));
}

/// While one drive is looked at, the others are stopped by this driver: their states say nothing.
void Link::judge_drive(std::size_t joint) {
  Drive& drive = drives_[joint];
  if (drive.emergency.code == kCodeFollowing) return note_drive(joint, Cause::following_error);
  if (drive.emergency.code != 0) return note_drive(joint, Cause::emergency, drive.emergency.code);
  if (!drive.state_new || silent_ || troubled_.value_or(joint) != joint) return;
  if (drive.now == DriveState::enabled) {
    if (drive.state.mode != kPositionMode) note_drive(joint, Cause::wrong_mode, drive.state.mode);
    return;
  }
  troubled_ = joint;  // all others stop at once; its emergency message may name the cause
  if (drive.now == DriveState::fault || drive.now == DriveState::fault_reaction) return judge_fault(joint);
  if (++drive.puzzled < kUnexplained) return;
  if (drive.now == DriveState::quick_stop) return note_drive(joint, Cause::quick_stop);
  note_drive(joint, Cause::switched_off, static_cast<int>(drive.now));
}

/// The emergency message may be late, or was lost: then the drive is asked.
void Link::judge_fault(std::size_t joint) {
  Drive& drive = drives_[joint];
  if (++drive.puzzled == kAskCode)
    bus_trouble(bus_->send(upload_request(settings_.joints[joint].node, object::kErrorCode)));
  if (drive.code == 0 && drive.puzzled < kPuzzled) return;
  const bool follows = drive.code == 0 && drive.state.statusword & status::kFollowingError;
  if (follows || drive.code == kCodeFollowing) return note_drive(joint, Cause::following_error);
  note_drive(joint, Cause::drive_fault, drive.code);
}

void Link::judge_start() {
  const bool all = std::all_of(drives_.begin(), drives_.end(), [](const Drive& drive) {
    return drive.now == DriveState::enabled && drive.state.mode == kPositionMode && drive.lost == 0;
  });
  enabled_for_ = all ? enabled_for_ + 1 : 0;
  if (enabled_for_ >= kEnabledCycles) {
    const std::lock_guard lock(mutex_);
    if (phase_ != Phase::starting || fault_) return;
    commands_.fetch();  // drops a command from before the start
    commanded_at_ = now_;
    for (Drive& drive : drives_) drive.emergency = {};
    phase_ = Phase::streaming;
    return changed_.notify_all();
  }
  if (now_ - began_at_ < settings_.start_timeout) return;
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    const Drive& drive = drives_[j];
    const std::string whose = who(settings_.joints[j]);
    if (drive.now != DriveState::enabled)
      return drive.emergency.code != 0
                 ? give_up_start(Cause::emergency, drive.emergency.code, whose)
                 : give_up_start(Cause::not_enabled, static_cast<int>(drive.now), whose);
    if (drive.state.mode != kPositionMode) return give_up_start(Cause::wrong_mode, drive.state.mode, whose);
  }
}

void Link::give_up_start(Cause cause, int detail, const std::string& text) {
  if (phase_ != Phase::starting) return;
  refuse(cause, detail, text);
  begin_stop();
}

/// The end: every drive that is reached has left "operation enabled" and stands.
void Link::judge_stand() {
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    Drive& drive = drives_[j];
    if (!drive.state_new) continue;
    const double most = std::max(
        2.0, kStill * seconds(settings_.cycle) * std::abs(settings_.joints[j].scale.counts_per_rad()));
    const double moved = std::abs(static_cast<double>(drive.state.position) - drive.was);
    drive.still = moved <= most ? drive.still + 1 : 0;
    drive.was = drive.state.position;
  }
  const std::lock_guard lock(mutex_);
  if ((phase_ == Phase::streaming || phase_ == Phase::starting) && fault_) {
    phase_ = Phase::ending;
    stands_ = false;
  }
  if (phase_ != Phase::ending || stands_) {
    ending_since_ = now_;
    return;
  }
  const bool all = std::all_of(drives_.begin(), drives_.end(), [&](const Drive& drive) {
    return lost(drive) || (drive.now != DriveState::enabled && drive.now != DriveState::fault_reaction &&
                           drive.still >= kStillCycles);
  });
  if (!all && !bus_lost_ && now_ - ending_since_ < kStopping) return;
  stood_ = all;
  stands_ = true;
  phase_ = Phase::idle;
  changed_.notify_all();
}

// --- what is measured -------------------------------------------------------------------------------------

void Link::measure(std::size_t j) {
  Drive& drive = drives_[j];
  const JointSettings& joint = settings_.joints[j];
  const double q = joint.scale.angle(drive.state.position);
  const double of_motor = joint.scale.direction / joint.scale.gear;
  constexpr double kOfRpm = 2 * std::numbers::pi / 60;
  switch (joint.velocity_unit) {
    case VelocityUnit::difference: {
      const auto cycles = static_cast<double>(current_.cycle - drive.measured_in);
      current_.dq[j] = drive.measured_in == 0 ? 0 : (q - current_.q[j]) / (cycles * seconds(settings_.cycle));
      break;
    }
    case VelocityUnit::counts:
      current_.dq[j] = drive.feedback.velocity / joint.scale.counts_per_rad();
      break;
    case VelocityUnit::rpm:
      current_.dq[j] = drive.feedback.velocity * kOfRpm * of_motor;
      break;
    case VelocityUnit::mrpm:
      current_.dq[j] = drive.feedback.velocity * kOfRpm * of_motor / 1000;
      break;
  }
  current_.q[j] = q;
  current_.effort[j] =
      drive.feedback.torque / 1000.0 * drive.rated_torque * joint.scale.gear * joint.scale.direction;
  drive.measured_in = current_.cycle;
}

void Link::publish() {
  current_.enabled = current_.limited = current_.warned = 0;
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    const Drive& drive = drives_[j];
    if (drive.state_new) measure(j);
    if (drive.now == DriveState::enabled) current_.enabled |= bit(j);
    if (drive.state.statusword & status::kLimit) current_.limited |= bit(j);
    if (drive.state.statusword & status::kWarning) current_.warned |= bit(j);
  }
  if (bus_) current_.refused = bus_->refused();
  samples_.write(current_);
  if (!seen_all_ && std::all_of(drives_.begin(), drives_.end(), [](const Drive& d) { return d.seen; })) {
    for (Drive& drive : drives_) {
      drive.alive = now_;
      drive.nmt = NmtState::unknown;  // what it was before
    }
    const std::lock_guard lock(mutex_);
    seen_all_ = true;
    changed_.notify_all();
  }
  begin_cycle();
}

}  // namespace polyarm::cia402
