#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/interface_table.hpp"

namespace polyarm::control {

/// Which limit took hold of a command, and how often; for the "why" of every clamp.
struct Clamp {
  std::uint64_t cycle = 0;
  std::int32_t command = -1;  ///< index of the command interface
  double asked = 0, given = 0;
};

/// The last word before the wire: position commands stay inside the joint's limits and change no faster than
/// its velocity limit, velocity commands stay inside it, what is no number becomes the last command given. A
/// joint that stands outside its limits may move inwards only. Control thread; building: before the loop
/// runs.
class CommandLimits {
 public:
  void build(const hardware::InterfaceTable& table, const std::vector<controllers::JointFacts>& joints,
             Nanoseconds period);
  void restrict(std::span<double> commands, std::span<const double> states, std::uint64_t cycle) noexcept;
  std::uint64_t clamps() const noexcept { return clamps_; }
  const Clamp& last() const noexcept { return last_; }

 private:
  struct Position {
    std::uint32_t command;
    std::int32_t state;
    double lower, upper, step;
    double given;  // last command, NaN before the first
  };
  struct Velocity {
    std::uint32_t command;
    double limit;
    double given;
  };
  void note(std::uint64_t cycle, std::uint32_t command, double asked, double given) noexcept;

  std::vector<Position> positions_;
  std::vector<Velocity> velocities_;
  std::uint64_t clamps_ = 0;
  Clamp last_;
};

}  // namespace polyarm::control
