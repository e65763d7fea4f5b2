#pragma once
/// Jogging as a controller of the loop: each command of the operator is valid for a short time.
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/jog/jog_generator.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::jog {

/// Latest jog command; replaces the previous one.
struct JogCommand {
  /// Number of one key press or stream. A session that a stop has ended cannot continue. 0: no session.
  std::uint32_t session = 0;
  /// Number of stops when the session began (StopLatch::count): a later stop ends the session.
  std::uint32_t stops = 0;
  Nanoseconds hold = 250'000'000;  ///< validity without a further command
  /// True for a step: joint_target or tcp_target with `joints` or `twist` as an increment from the present
  /// position (or from the end of the last step). A step starts once, when its number is new.
  bool by = false;
  std::uint32_t step = 0;
  JogSetpoint wish;
};

/// State of the jog commands.
struct JogStatus {
  Nanoseconds time = 0;
  std::uint32_t session = 0;          ///< the active one; 0: none
  std::uint32_t ended = 0;            ///< the newest session that a stop has ended or that is no longer valid
  std::uint32_t step = 0;             ///< the newest step that has ended
  JogHold step_hold = JogHold::none;  ///< why it ended early
  std::int32_t step_which = -1;
  bool standing = true;
  JogHold hold = JogHold::none;
  std::int32_t which = -1;
  JogValues joints{};  ///< commanded, rad or m
  Pose tcp;            ///< commanded, in the world
  double tcp_speed = 0;
};

/// Jogs all joints of one robot. It starts at their commanded positions (measured without a command), at
/// rest. Without new commands it slows down within limits. It obeys every stop; after a stop it moves only
/// for a new session. While the loop is held a new session may move (nothing else does).
class JogController : public controllers::Controller {
 public:
  /// The type name in lists of controllers.
  static constexpr const char* kType = "polyarm_controllers/JogController";

  /// `joints`: full names, in the chain's order. `chain` must outlive this object.
  JogController(const kinematics::Chain& chain, std::vector<controllers::JointFacts> joints,
                moves::Workspace workspace);

  /// Throws Error("no-jog") if the joints have neither position nor velocity commands.
  controllers::CallbackReturn on_configure(controllers::ControllerContext& context) override;
  controllers::CallbackReturn on_activate(const hardware::Cycle& cycle) noexcept override;
  void on_deactivate(const hardware::Cycle& cycle) noexcept override;
  controllers::ReturnType update(const hardware::Cycle& cycle,
                                 const controllers::Verdict& verdict) noexcept override;
  bool standing() const noexcept override { return standing_; }

  /// Cell thread.
  void send(const JogCommand& command) noexcept { inbox_.write(command); }
  /// The newest status; only one thread may call it.
  JogStatus status() noexcept {
    outbox_.fetch();
    return outbox_.value();
  }
  /// Any thread, signal handlers too: ends every session up to this number. The dead-man check calls it.
  void release_now(std::uint32_t session) noexcept {
    std::uint32_t seen = release_now_.load(std::memory_order_relaxed);
    while (seen < session && !release_now_.compare_exchange_weak(seen, session, std::memory_order_release)) {
    }
  }
  /// Cell thread: what is near the robot now; fill draft_barriers(), then publish. Before the first, nothing.
  Barriers& draft_barriers() noexcept { return barriers_.draft(); }
  void publish_barriers() noexcept { barriers_.publish(); }
  /// Any thread; takes effect in the next cycle.
  void set_limits(const JogLimits& limits) noexcept {
    joint_share_.store(limits.joint_share, std::memory_order_relaxed);
    tcp_speed_.store(limits.tcp_speed, std::memory_order_relaxed);
    tcp_turning_.store(limits.tcp_turning, std::memory_order_relaxed);
    reduced_.store(limits.reduced, std::memory_order_relaxed);
  }
  JogLimits limits() const noexcept {
    return {joint_share_.load(), tcp_speed_.load(), tcp_turning_.load(), reduced_.load()};
  }

 private:
  struct Joint {
    int position = -1, velocity = -1;  // command interfaces
    int measured = -1;                 // state interface
  };
  bool holds(const hardware::Cycle& cycle, const controllers::Verdict& verdict) noexcept;
  void begin_step() noexcept;
  JogSetpoint setpoint_now(const hardware::Cycle& cycle) const noexcept;
  void write(const hardware::Cycle& cycle) noexcept;

  const kinematics::Chain& chain_;
  std::vector<controllers::JointFacts> facts_;
  moves::Workspace workspace_;
  std::vector<Joint> joints_;
  std::optional<JogGenerator> generator_;

  // control thread
  JogCommand command_;
  Nanoseconds received_ = 0;
  std::uint32_t session_ = 0, ended_ = 0, stops_ = 0, step_begun_ = 0, step_done_ = 0;
  JogSetpoint step_setpoint_;
  JogHold step_hold_ = JogHold::none;
  std::int32_t step_which_ = -1;
  Nanoseconds blocked_since_ = -1;
  bool standing_ = true;
  bool touching_ = false;

  realtime::Latest<JogCommand> inbox_;
  realtime::Latest<JogStatus> outbox_;
  realtime::Latest<Barriers> barriers_;
  std::atomic<std::uint32_t> release_now_{0};
  std::atomic<double> joint_share_{1}, tcp_speed_{1e9}, tcp_turning_{1e9};
  std::atomic<bool> reduced_{false};
};

}  // namespace polyarm::jog
