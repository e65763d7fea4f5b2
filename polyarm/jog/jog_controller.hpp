#pragma once
/// Motion by hand as a controller of the loop: commands of a person, each good for a short time.
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

/// What one who jogs asks for. The next command takes its place.
struct JogCommand {
  /// One press of a key, one stream: what a stop has ended does not go on under the same number. 0: none.
  std::uint32_t session = 0;
  /// Stops that had been asked for when the session began (StopLatch::count): a later one ends it.
  std::uint32_t stops = 0;
  Nanoseconds hold = 250'000'000;  ///< how long it is good for without another one
  /// Steps are by an amount, from where the joints or the TCP are (or the last step ends): joint_target and
  /// tcp_target whose `joints` and `twist` say how far. A step is begun once, when its number is new.
  bool by = false;
  std::uint32_t step = 0;
  JogWish wish;
};

/// What became of it.
struct JogStatus {
  Nanoseconds time = 0;
  std::uint32_t session = 0;          ///< that is followed now; 0: none
  std::uint32_t ended = 0;            ///< the newest that a stop has ended, or that is not good any more
  std::uint32_t step = 0;             ///< the newest step that is over
  JogHold step_hold = JogHold::none;  ///< what ended it before it was done
  std::int32_t step_which = -1;
  bool standing = true;
  JogHold hold = JogHold::none;
  std::int32_t which = -1;
  JogValues joints{};  ///< commanded, rad or m
  Pose tcp;            ///< commanded, in the world
  double tcp_speed = 0;
};

/// Moves all joints of one robot by hand. It starts where they are commanded to be (else measured), at rest,
/// slows down within limits when nothing new comes, and honours every stop; after one it moves for a new
/// session only. While the loop is held a new session may move (nothing else does).
class JogController : public controllers::Controller {
 public:
  /// The type under which it is listed.
  static constexpr const char* kType = "polyarm_controllers/JogController";

  /// `joints`: whole names, as in the chain's order. `chain` outlives it.
  JogController(const kinematics::Chain& chain, std::vector<controllers::JointFacts> joints,
                moves::Workspace workspace);

  /// Throws Error("no-jog") where joints take neither positions nor velocities.
  controllers::CallbackReturn on_configure(controllers::ControllerContext& context) override;
  controllers::CallbackReturn on_activate(const hardware::Cycle& cycle) noexcept override;
  void on_deactivate(const hardware::Cycle& cycle) noexcept override;
  controllers::ReturnType update(const hardware::Cycle& cycle,
                                 const controllers::Verdict& verdict) noexcept override;
  bool standing() const noexcept override { return standing_; }

  /// Cell thread.
  void send(const JogCommand& command) noexcept { inbox_.write(command); }
  /// The newest status; one thread asks.
  JogStatus status() noexcept {
    outbox_.fetch();
    return outbox_.value();
  }
  /// Any thread, signal handlers too: lets go of every session up to this number. The deadman's word.
  void let_go(std::uint32_t session) noexcept {
    std::uint32_t seen = let_go_.load(std::memory_order_relaxed);
    while (seen < session && !let_go_.compare_exchange_weak(seen, session, std::memory_order_release)) {
    }
  }
  /// Any thread: from the next cycle on.
  void set_limits(const JogLimits& limits) noexcept {
    joint_share_.store(limits.joint_share, std::memory_order_relaxed);
    tcp_speed_.store(limits.tcp_speed, std::memory_order_relaxed);
    tcp_turning_.store(limits.tcp_turning, std::memory_order_relaxed);
  }
  JogLimits limits() const noexcept { return {joint_share_.load(), tcp_speed_.load(), tcp_turning_.load()}; }

 private:
  struct Joint {
    int position = -1, velocity = -1;  // commands
    int measured = -1;                 // state
  };
  bool holds(const hardware::Cycle& cycle, const controllers::Verdict& verdict) noexcept;
  void begin_step() noexcept;
  JogWish wish_now(const hardware::Cycle& cycle) const noexcept;
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
  JogWish step_wish_;
  JogHold step_hold_ = JogHold::none;
  std::int32_t step_which_ = -1;
  Nanoseconds blocked_since_ = -1;
  bool standing_ = true;

  realtime::Latest<JogCommand> inbox_;
  realtime::Latest<JogStatus> outbox_;
  std::atomic<std::uint32_t> let_go_{0};
  std::atomic<double> joint_share_{1}, tcp_speed_{1e9}, tcp_turning_{1e9};
};

}  // namespace polyarm::jog
