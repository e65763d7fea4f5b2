#pragma once
/// One simulated servo drive: object dictionary, SDO server, PDOs, heartbeats, the state machine of CiA 402,
/// and a motor that follows its targets exactly. It implements the protocols independently of the driver, so
/// that an error of the driver cannot hide. Counts of the drive. One thread.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drivers/cia402/can_bus.hpp"

namespace polyarm::cia402 {

struct FarDriveOptions {
  int node = 1;
  double counts_per_rad = 4096 * 100 / 6.283185307179586;  ///< of the joint; negative: it turns against it
  double offset = 0;                                       ///< rad, of the joint where the drive counts 0
  double start = 0;                                        ///< rad
  std::uint32_t rated_torque = 500;                        ///< mN m
};

/// What a person orders; it stays until heal().
struct DriveFaults {
  bool mute = false, sdo_mute = false, sdo_wrong = false, duplicate = false, refuse_mapping = false,
       forgetful = false, wrong_device = false, no_position_mode = false, unwatched = false, hides = false,
       stays_operational = false;
  bool quick_stop_input = false, safe_torque_off = false, never_enables = false, broken = false,
       other_mode = false, no_heartbeat = false, limit = false, warning = false, no_emergency = false;
  int late = 0;  ///< SYNCs whose answers come one SYNC later
};

class FarDrive {
 public:
  using Frames = std::vector<CanFrame>;

  FarDrive(const FarDriveOptions& options, Nanoseconds tick);

  /// A frame on the bus; answers go to `out`.
  void take(const CanFrame& frame, Frames& out);
  /// A tick of its clock.
  void tick(Frames& out);

  // --- orders ---
  DriveFaults faults;
  /// An error of its own: the emergency message, then the state "fault".
  void fail(std::uint16_t code, bool following_error, Frames& out);
  void reset(Frames& out);
  void switch_off();
  void switch_on(Frames& out);
  void stop_node() { nmt_ = Nmt::stopped; }
  void heal(Frames& out);

  int node() const { return options_.node; }
  /// rad of the joint
  double angle() const { return options_.offset + position() / options_.counts_per_rad; }
  std::int32_t position() const;
  bool enabled() const { return state_ == State::enabled; }
  /// "operation enabled"
  const char* state_name() const;
  bool operational() const { return nmt_ == Nmt::operational; }
  /// The largest difference between a target and the one before, rad, since forget_jumps().
  double largest_jump() const { return jump_; }
  void forget_jumps() { jump_ = 0; }
  std::uint32_t value(std::uint16_t index, std::uint8_t sub = 0) const;
  /// Every value that was written to an object, in order; at most 1000.
  const std::vector<std::uint32_t>& written(std::uint16_t index, std::uint8_t sub = 0);

 private:
  enum class State { not_ready, disabled, ready, on, enabled, quick_stop, reaction, fault };
  enum class Nmt { booting, stopped, pre_operational, operational };
  struct Entry {
    std::uint32_t value = 0;
    std::uint8_t size = 0;
    bool writable = false, mappable = false;
  };
  struct Transfer {
    std::vector<std::uint8_t> bytes;
    std::size_t at = 0, announced = 0;
    std::uint16_t index = 0;
    std::uint8_t sub = 0;
    bool toggle = false, active = false, download = false;
  };
  static std::uint32_t key(std::uint16_t index, std::uint8_t sub) {
    return static_cast<std::uint32_t>(index) << 8 | sub;
  }
  void add(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value, bool writable,
           bool mappable = false);
  void fill();
  void add_pdos();
  void set(std::uint16_t index, std::uint32_t value, std::uint8_t sub = 0) {
    entries_[key(index, sub)].value = value;
  }
  std::int32_t signed_value(std::uint16_t index, std::uint8_t sub = 0) const;

  // SDO
  void serve_sdo(const CanFrame& frame, Frames& out);
  void upload(std::uint16_t index, std::uint8_t sub, Frames& out);
  void upload_segment(unsigned command, Frames& out);
  void download(const CanFrame& frame, Frames& out);
  void download_segment(const CanFrame& frame, Frames& out);
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, const std::vector<std::uint8_t>& bytes,
                      Frames& out);
  std::uint32_t check_mapping(std::uint16_t index, std::uint8_t sub, std::uint32_t value) const;
  void answer(std::vector<std::uint8_t> bytes, Frames& out);
  void abort(std::uint16_t index, std::uint8_t sub, std::uint32_t code, Frames& out);

  // PDO, NMT, heartbeat
  void on_sync(Frames& out);
  void on_nmt(unsigned command, Frames& out);
  void store_rpdo(const CanFrame& frame);
  void send_tpdos(Frames& out);
  void send(std::uint16_t id, std::vector<std::uint8_t> bytes, Frames& out);
  void send_emergency(std::uint16_t code, Frames& out);
  void watch_master(Frames& out);

  // CiA 402
  void apply_control(std::uint32_t word, Frames& out);
  void enter(State state);
  void latch_target();
  void move(Frames& out);
  std::uint32_t statusword() const;
  void refresh();

  FarDriveOptions options_;
  Nanoseconds tick_;
  std::map<std::uint32_t, Entry> entries_;
  std::map<std::uint32_t, std::vector<std::uint32_t>> log_;
  std::string name_ = "Polyarm simulated drive";
  Transfer transfer_;
  Nmt nmt_ = Nmt::pre_operational;
  State state_ = State::disabled;
  std::uint32_t control_ = 0;
  bool powered_ = true, following_error_ = false, master_seen_ = false, master_lost_ = false;
  Nanoseconds since_heartbeat_ = 0, since_master_ = 0;
  std::map<int, CanFrame> rpdos_;  ///< taken over at the SYNC
  Frames late_;
  double demand_ = 0, speed_ = 0, target_ = 0, jump_ = 0;  ///< counts, per tick
  int steps_ = 0;                                          ///< ticks until the target is reached
};

}  // namespace polyarm::cia402
