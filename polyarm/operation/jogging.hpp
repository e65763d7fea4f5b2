#pragma once
/// Jogging of the robots of a cell: when it is allowed, which session has control, and which controllers are
/// replaced meanwhile.
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
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

/// The share of a wanted twist with which a base can still stop in time, 0 to 1.
struct BaseShare {
  double share = 1;
  std::string near;  ///< what holds it back; empty: nothing
};

/// Cell thread. A jog controller is created for a robot at its first jog request. Between two cycles it takes
/// the joint commands over from the controllers that hold them. It gives them back when no session is alive
/// and the robot is at rest (decision 0012).
class Jogging {
 public:
  /// Time after the last command of a session until the robot returns to its usual controllers, ns.
  static constexpr Nanoseconds kLinger = 300'000'000;

  Jogging(const CellSetup& setup, Machine& machine, const Arming& arming, const Motions& motions,
          const Programs& programs, Observer& observer);
  ~Jogging();

  /// Why the robot cannot be jogged now: "program-runs", "disarmed", "fault", "stopping", "not-active",
  /// "motion-held" or "moving"; empty if it can. A robot that only settles from its last motion can be
  /// jogged.
  std::optional<Problem> why_not(std::size_t robot) const;
  /// Throws the result of why_not() as an Error.
  void require_allowed(std::size_t robot) const;
  /// Advances the switch to the jog controller; true when the jog controller has the robot's joints. Call
  /// again until it returns true. Waits for a robot that settles. Throws the reason of a refusal: see
  /// why_not(); "moving" also if the robot does not come to rest.
  bool engage(std::size_t robot);

  /// Continues session `session` of the robot, or begins a new one (0), and returns its number. Throws
  /// Error("jogged") while another session is alive, Error("session-over") for a session that has ended.
  std::uint32_t session(std::size_t robot, std::uint32_t session);
  /// Sends a command under this session, which renews the session. Fills in the session's fields of the
  /// command.
  void send(std::size_t robot, std::uint32_t session, jog::JogCommand command);
  /// Estimates the velocity of a streamed target from earlier targets of the same session.
  void estimate(std::size_t robot, std::uint32_t session, jog::JogSetpoint& wish);
  /// The last pose that the session streamed; otherwise the TCP's present pose.
  Pose last_target(std::size_t robot, std::uint32_t session) const;
  /// Ends the session; 0 ends every session of the robot.
  void end(std::size_t robot, std::uint32_t session = 0);
  void end_all();
  jog::JogStatus status(std::size_t robot) const;
  std::uint32_t new_step() { return ++steps_; }

  /// What is near a robot that is jogged, for its controller: fill it, then publish_barriers(). Null: it is not
  /// jogged.
  jog::Barriers* draft_barriers(std::size_t robot);
  void publish_barriers(std::size_t robot);
  /// How to name what a barrier of a robot is for.
  using BarrierNames = std::function<std::string(std::size_t robot, std::int32_t which)>;
  void set_barrier_names(BarrierNames names) { barrier_names_ = std::move(names); }
  std::string barrier_name(std::size_t robot, std::int32_t which) const {
    return barrier_names_ ? barrier_names_(robot, which) : std::string();
  }

  /// How fast a base may be driven now, and what holds it back.
  using BaseGuard = std::function<BaseShare(std::size_t robot, double ahead, double turn)>;
  void set_base_guard(BaseGuard guard) { base_guard_ = std::move(guard); }
  /// `ahead`: m/s, `turn`: rad/s that are asked of the base of a robot.
  BaseShare base_share(std::size_t robot, double ahead, double turn) const {
    return base_guard_ ? base_guard_(robot, ahead, turn) : BaseShare{};
  }

  JogPhase state(std::size_t robot) const;
  /// True if a session is alive or a robot is not back with its usual controllers.
  bool engaged() const;
  bool engaged(std::size_t robot) const { return state(robot) != JogPhase::idle; }
  /// Call once each tick.
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
  BarrierNames barrier_names_;
  BaseGuard base_guard_;
};

}  // namespace polyarm::cell
