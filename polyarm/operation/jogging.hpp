#pragma once
/// Motion of the robots of a cell by hand: when it is allowed, who jogs, and which controllers give way
/// meanwhile.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/jog/jog_controller.hpp"
#include "polyarm/machine/machine.hpp"
#include "polyarm/operation/jog_states.hpp"

namespace polyarm::cell {

class Arming;
class Motions;
class Programs;

/// Cell thread. For each robot a jog controller is made when it is first asked for. It takes the robot's
/// commands over from whichever controllers have them, between two cycles, and gives them back when nobody
/// jogs any more and the robot stands (decision 0012).
class Jogging {
 public:
  /// How long after the last command of a session its robot goes back to its usual controllers.
  static constexpr Nanoseconds kLinger = 300'000'000;

  Jogging(const CellSetup& setup, Machine& machine, const Arming& arming, const Motions& motions,
          const Programs& programs, Observer& observer);
  ~Jogging();

  /// Why the robot may not be jogged now: "program-runs", "disarmed", "fault", "stopping", "not-active",
  /// "motion-held" or "moving"; empty: it may. A robot that only settles from the motion before may.
  std::optional<Problem> why_not(std::size_t robot) const;
  /// Throws that as an Error.
  void require_allowed(std::size_t robot) const;
  /// A step towards the jog controller having the robot's joints; true when it has. A robot that settles from
  /// the motion before is waited for. Throws what refuses it: as why_not(), and "moving" where it does not
  /// come to rest.
  bool engage(std::size_t robot);

  /// The session of `robot` that goes on as `session`, or a new one (0). Throws Error("jogged") while another
  /// one is alive, Error("session-over") for one that was ended.
  std::uint32_t session(std::size_t robot, std::uint32_t session);
  /// Hands the command on under that session, which renews it; fills in what belongs to the session.
  void send(std::size_t robot, std::uint32_t session, jog::JogCommand command);
  /// Fills in the velocity of a target that is streamed, from those of the same session before.
  void estimate(std::size_t robot, std::uint32_t session, jog::JogWish& wish);
  /// The pose that the session has streamed last, else where the TCP is.
  Pose last_target(std::size_t robot, std::uint32_t session) const;
  /// Ends the session, or with 0 every one.
  void end(std::size_t robot, std::uint32_t session = 0);
  void end_all();
  jog::JogStatus status(std::size_t robot) const;
  std::uint32_t new_step() { return ++steps_; }

  JogPhase state(std::size_t robot) const;
  /// Somebody jogs, or a robot is not back with its usual controllers.
  bool engaged() const;
  bool engaged(std::size_t robot) const { return state(robot) != JogPhase::idle; }
  /// Once each tick.
  void tick();

 private:
  struct Robot;
  Robot& robot(std::size_t i) const { return *robots_[i]; }
  void load(std::size_t i);
  std::string mover_of(std::size_t i) const;
  bool has_come_to_rest(Robot& robot);
  bool alive(const Robot& robot) const;
  jog::JogController* controller(const Robot& robot) const;
  bool is_active(const Robot& robot) const;
  void take(Robot& robot, JogChange step);
  void begin_switch(Robot& robot);
  void begin_release(Robot& robot);
  bool advance(Robot& robot);
  void tick(Robot& robot);

  const CellSetup& setup_;
  Machine& machine_;
  const Arming& arming_;
  const Motions& motions_;
  const Programs& programs_;
  Observer& observer_;
  std::vector<std::unique_ptr<Robot>> robots_;
  std::uint32_t steps_ = 0;
  bool was_held_ = false;
};

}  // namespace polyarm::cell
