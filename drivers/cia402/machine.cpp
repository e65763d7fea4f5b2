#include "drivers/cia402/machine.hpp"

#include <algorithm>
#include <numbers>

#include "polyarm/base/error.hpp"

namespace polyarm::cia402 {

namespace {
constexpr double kDegrees = 180 / std::numbers::pi;

/// A number is that of the node; without one it is the first drive.
constexpr wire::OrderKind kKinds[] = {
    {"silent", "the drive sends nothing any more; NUMBER: its node, here and below"},
    {"late", "its positions come one cycle late, 20 times"},
    {"duplicate", "it sends each frame twice"},
    {"over_current", "its motor takes too much current: emergency 0x2310, then fault"},
    {"under_voltage", "its supply is low: emergency 0x3220, then fault"},
    {"following_error", "its motor does not follow: emergency 0x8611, then fault"},
    {"encoder", "its encoder fails: fault without an emergency message, 0x7305 in object 0x603F"},
    {"quick_stop", "its quick-stop input is active"},
    {"torque_off", "its safe torque off is active"},
    {"no_enable", "it stays in \"switched on\""},
    {"mode", "it shows another mode"},
    {"limit", "it reports an active limit"},
    {"warning", "it reports a warning"},
    {"reset", "it restarts, as if by its button"},
    {"power_off", "its supply ends; power_on brings it back"},
    {"power_on", "its supply is back"},
    {"stopped", "it goes to the CANopen state \"stopped\""},
    {"no_heartbeat", "its heartbeats end, its positions come on"},
    {"sdo_silent", "it answers no SDO"},
    {"sdo_wrong", "it answers SDO with what does not fit"},
    {"wrong_device", "it is a device of another profile"},
    {"no_position_mode", "it has no cyclic synchronous position"},
    {"refuse_mapping", "it refuses to map objects to PDOs"},
    {"forget", "it takes the cycle time, and keeps its own"},
    {"unwatched", "it cannot watch the heartbeat of the master"},
    {"hides", "it has no list of its modes, and no cycle time (0x6502, 0x60C2)"},
    {"stays", "it stays operational when it misses the heartbeat of the master"},
    {"bus_off", "the adapter cannot send: every frame is refused, none comes"},
    {"cut", "the cable is cut: every frame is lost"},
    {"unplug", "the adapter is pulled; it does not come back"},
    {"garbage", "20 texts of the adapter that are no frames; NUMBER: how many"},
    {"other_master", "another master sends SYNC"},
    {"healthy", "all faults are over; drives in fault wait for their reset"},
};

struct OnSwitch {
  const char* name;
  bool DriveFaults::*on;
};
constexpr OnSwitch kSwitches[] = {
    {"silent", &DriveFaults::mute},
    {"duplicate", &DriveFaults::duplicate},
    {"quick_stop", &DriveFaults::quick_stop_input},
    {"torque_off", &DriveFaults::safe_torque_off},
    {"no_enable", &DriveFaults::never_enables},
    {"mode", &DriveFaults::other_mode},
    {"limit", &DriveFaults::limit},
    {"warning", &DriveFaults::warning},
    {"no_heartbeat", &DriveFaults::no_heartbeat},
    {"sdo_silent", &DriveFaults::sdo_mute},
    {"sdo_wrong", &DriveFaults::sdo_wrong},
    {"wrong_device", &DriveFaults::wrong_device},
    {"no_position_mode", &DriveFaults::no_position_mode},
    {"refuse_mapping", &DriveFaults::refuse_mapping},
    {"forget", &DriveFaults::forgetful},
    {"unwatched", &DriveFaults::unwatched},
    {"hides", &DriveFaults::hides},
    {"stays", &DriveFaults::stays_operational},
};
}  // namespace

Machine::Machine(const MachineOptions& options) {
  for (const FarDriveOptions& drive : options.drives) drives_.emplace_back(drive, options.tick);
  if (drives_.empty()) throw Error("bad-value", "a bus without a drive", "give at least one");
}

void Machine::take(const CanFrame& frame, FarDrive::Frames& out) {
  for (FarDrive& drive : drives_) drive.take(frame, out);
}

void Machine::tick(FarDrive::Frames& out) {
  for (FarDrive& drive : drives_) drive.tick(out);
}

std::span<const wire::OrderKind> Machine::order_kinds() {
  return kKinds;
}

FarDrive& Machine::drive(int node) {
  for (FarDrive& drive : drives_)
    if (drive.node() == node) return drive;
  throw Error("bad-value", "there is no drive with the node number " + std::to_string(node),
              "the first one has " + std::to_string(drives_.front().node()));
}

void Machine::heal(FarDrive::Frames& out) {
  for (FarDrive& drive : drives_) drive.heal(out);
}

void Machine::order(const wire::Order& order, FarDrive::Frames& out) {
  if (order.is("healthy")) return heal(out);
  for (const char* of_bus : {"bus_off", "cut", "unplug", "garbage", "other_master"})
    if (order.is(of_bus)) return;
  FarDrive& drive = this->drive(order.number_or(drives_.front().node()));
  for (const OnSwitch& one : kSwitches)
    if (order.is(one.name)) drive.faults.*one.on = true;
  if (order.is("late")) drive.faults.late = 20;
  if (order.is("over_current")) drive.fail(0x2310, false, out);
  if (order.is("under_voltage")) drive.fail(0x3220, false, out);
  if (order.is("following_error")) drive.fail(0x8611, true, out);
  if (order.is("encoder")) {
    drive.faults.no_emergency = true;
    drive.fail(0x7305, false, out);
  }
  if (order.is("reset")) drive.reset(out);
  if (order.is("power_off")) drive.switch_off();
  if (order.is("power_on")) drive.switch_on(out);
  if (order.is("stopped")) drive.stop_node();
}

std::vector<double> Machine::q() const {
  std::vector<double> out;
  for (const FarDrive& drive : drives_) out.push_back(drive.angle() * kDegrees);
  return out;
}

double Machine::largest_jump() const {
  double out = 0;
  for (const FarDrive& drive : drives_) out = std::max(out, drive.largest_jump());
  return out * kDegrees;
}

void Machine::forget_jumps() {
  for (FarDrive& drive : drives_) drive.forget_jumps();
}

}  // namespace polyarm::cia402
