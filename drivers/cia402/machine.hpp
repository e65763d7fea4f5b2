#pragma once
/// The simulated drives of one arm on their bus, whatever carries the frames. One thread.
#include <string>
#include <vector>

#include "drivers/cia402/far_drive.hpp"
#include "drivers/wire/orders.hpp"

namespace polyarm::cia402 {

struct MachineOptions {
  std::vector<FarDriveOptions> drives;
  Nanoseconds tick = 1'000'000;  ///< of their clocks
};

class Machine {
 public:
  explicit Machine(const MachineOptions& options);

  /// A frame of the master; the answers go to `out`.
  void take(const CanFrame& frame, FarDrive::Frames& out);
  void tick(FarDrive::Frames& out);
  /// A tick whose frames nobody gets.
  void tick() {
    FarDrive::Frames unheard;
    tick(unheard);
  }

  static std::span<const wire::OrderKind> order_kinds();
  /// Faults of drives. Throws Error("bad-value") for a node that is not here.
  void order(const wire::Order& order, FarDrive::Frames& out);
  void heal(FarDrive::Frames& out);

  std::vector<FarDrive>& drives() { return drives_; }
  /// Throws Error("bad-value").
  FarDrive& drive(int node);
  /// degrees, of the joints
  std::vector<double> q() const;
  /// degrees: the largest difference between two targets of a joint
  double largest_jump() const;
  void forget_jumps();

 private:
  std::vector<FarDrive> drives_;
};

}  // namespace polyarm::cia402
