#pragma once
/// Robots of a cell that are led by others, as its file says (`teleop`).
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/teleop/settings.hpp"
#include "polyarm/teleop/teleop_states.hpp"

namespace polyarm::cell {

class CellData;
class Jogging;
class Machine;
class Observer;
struct CellSetup;

/// Cell thread. While the clutch of a pair is held, its follower is jogged after the leader's measured
/// motion: with the limits, guards, workspace and stops of jogging. Whatever ends that motion (a stop, a
/// leader that is gone, implausible or silent) ends it until the clutch is released and held again.
class Teleoperation {
 public:
  struct Owners {
    const CellSetup& setup;
    Machine& machine;
    CellData& data;
    Jogging& jogging;
    Observer& observer;
  };
  explicit Teleoperation(const Owners& cell);
  ~Teleoperation();

  /// Call when the loop is prepared and all data are loaded. Adds problems with their locations.
  void build(Problems& problems);
  void tick();

  std::size_t size() const { return pairs_.size(); }
  const teleop::PairSettings& settings(std::size_t pair) const;
  /// The index of the pair; of the only one without a name. Throws Error("unknown-pair" | "which-pair").
  std::size_t find(const std::optional<std::string>& name) const;
  /// Holds the clutch of a pair until `hold` ns from now; 0 releases it. Throws Error("other-clutch") for a
  /// pair with another clutch.
  void hold_key(std::size_t pair, Nanoseconds hold);

  struct State {
    teleop::TeleopPhase phase = teleop::TeleopPhase::blocked;
    std::string reason;    ///< why it is blocked
    std::string furthest;  ///< while it approaches: the joint furthest from the leader's pose
    double distance = 0;   ///< of that joint, rad or m
  };
  State state(std::size_t pair) const;

 private:
  struct Pair;
  State state_of(const Pair& pair) const;
  void see_leader(Pair& pair) const;
  bool clutch_held(Pair& pair, teleop::TeleopSeen& seen) const;
  void take_over(Pair& pair, teleop::TeleopSeen& seen) const;
  void judge_follower(Pair& pair, teleop::TeleopSeen& seen) const;
  void change(Pair& pair, teleop::TeleopPhase to) const;
  void send(Pair& pair) const;
  void grip(Pair& pair) const;
  void tick(Pair& pair) const;

  Owners cell_;
  std::vector<std::unique_ptr<Pair>> pairs_;
};

}  // namespace polyarm::cell
