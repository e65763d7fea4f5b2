#pragma once
/// Who moves the robots of a cell by hand, when that may be, and what gives way meanwhile.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/jog/jog_controller.hpp"

namespace polyarm::cell {

class Cell;

/// Cell thread. For each robot a jog controller is made when it is first asked for. It takes the robot's
/// commands over from whoever has them, between two cycles, and gives them back when nobody jogs any more and
/// the robot stands (decision 0012).
class Jogging {
 public:
  /// How long after the last command of a session its robot goes back to whoever had it.
  static constexpr Nanoseconds kLinger = 300'000'000;

  explicit Jogging(Cell& cell);
  ~Jogging();

  /// Why the robot may not be jogged now: "program-runs", "disarmed", "fault", "stopping", "not-active",
  /// "motion-held" or "moving"; empty: it may.
  std::optional<Problem> why_not(std::size_t robot) const;
  /// Throws that as an Error.
  void require_allowed(std::size_t robot) const;
  /// A step towards the robot's joints being this one's; true when they are. Throws what refuses it.
  bool engage(std::size_t robot);

  /// The session of `robot` that goes on as `session`, or a new one (0). Throws Error("jogged") while
  /// somebody else's is alive, Error("session-over") for one that was ended.
  std::uint32_t session(std::size_t robot, std::uint32_t session);
  /// Hands the command on under that session; fills in what belongs to it.
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

  /// Does anybody jog, or is a robot not back with those who had it?
  bool engaged() const;
  bool engaged(std::size_t robot) const;
  /// Once each tick.
  void tick(Nanoseconds now);

 private:
  struct Robot;
  Robot& robot(std::size_t i) const { return *robots_[i]; }
  void load(std::size_t i);
  bool alive(const Robot& robot) const;
  jog::JogController* controller(const Robot& robot) const;
  void give_back(Robot& robot);

  Cell& cell_;
  std::vector<std::unique_ptr<Robot>> robots_;
  std::uint32_t steps_ = 0;
  bool was_held_ = false;
};

}  // namespace polyarm::cell
