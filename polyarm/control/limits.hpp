#pragma once
/// Limits every command of a cycle before it reaches the hardware.
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pair.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/fault_event.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/joint_control/joint_limiters.hpp"

namespace polyarm::control {

/// A limit that changed a command: how often, and the last time.
struct Clamp {
  std::string interface;  ///< "arm/elbow_joint/position"
  controllers::Limit limit = controllers::Limit::none;
  double asked = 0, given = 0;
  std::uint64_t count = 0, cycle = 0;
};

/// The last check before the hardware: restricts each joint's command to its limits and soft limits. NaN and
/// infinity become the last position, or zero motion. Clamps are counted by interface and limit, and can be
/// read while the loop runs. A joint commanded by position or velocity and measured far outside its limits is
/// a fault; it is reported once when it gets there, so it can be moved back. While the loop is held,
/// positions keep their last commanded value, and velocities may only lead back to where the joint stood;
/// commands of a controller that ignores the stop have no effect. restrict(): control thread; build(): before
/// the loop runs; report(): any thread.
class CommandLimits {
 public:
  void build(const hardware::InterfaceTable& table, const std::vector<controllers::JointFacts>& joints,
             Nanoseconds period);
  /// Commands whose names begin with `prefix` change every `cycles` cycles. A change may be as large as the
  /// time since the last change allows, but at most that of `cycles` cycles. Call after build().
  void set_turns(const std::string& prefix, unsigned cycles);
  /// `still`: the loop is held, or in a fault and no controller is still slowing down. A joint that newly
  /// moved far outside its limits is a fault event.
  void restrict(std::span<double> commands, std::span<const double> states, std::uint64_t cycle, bool still,
                hardware::FaultEvents& faults) noexcept;
  /// Earlier commands of these interfaces no longer say where their joints are. Control thread.
  void forget(std::size_t first, std::size_t count) noexcept;
  /// Limits velocities to this share of the joints' limits, (0, 1]. Any thread.
  void set_share(double share) noexcept { share_.store(share, std::memory_order_relaxed); }
  /// Number of all clamps so far.
  std::uint64_t clamps() const noexcept { return clamps_.load(std::memory_order_relaxed); }
  /// The limits that changed commands, newest first.
  std::vector<Clamp> report() const;

 private:
  /// Positions with only position and velocity limits, which is the usual case. Stored by joint, so two are
  /// checked at a time.
  struct Plain {
    std::vector<double> lower, upper, step;
    std::vector<double> given;  // last command; NaN before the first
    std::vector<std::uint32_t> command;
    std::vector<std::int32_t> state;
    std::vector<unsigned> turns, since;  // cycles between changes, and since the last one
    std::vector<char> outside;
  };
  enum class Quantity : std::uint8_t { position, velocity, acceleration, effort };
  struct Full {
    std::uint32_t command;
    std::int32_t position, velocity;  // states; -1 if there is none
    Quantity quantity;
    controllers::LimiterSettings settings;
    double given, before;
    double stood;  // measured position when the loop came to a standstill
    bool outside = false;
    unsigned turns = 1, since = 1, span = 1;  // cycles; `span`: between before and given
  };
  struct Record {
    std::atomic<std::uint64_t> count{0}, cycle{0};
    std::atomic<double> asked{0}, given{0};
  };
  void add(const hardware::InterfaceTable& table, const controllers::JointFacts& joint, const char* quantity,
           Quantity kind);
  void one_plain(std::size_t i, double share, std::span<double> commands, std::span<const double> states,
                 std::uint64_t cycle, bool still, hardware::FaultEvents& faults) noexcept;
  void add_plain(const controllers::LimiterSettings& settings, std::uint32_t command, std::int32_t state);
  bool pair_is_fine(std::size_t i, Pair asked, Pair at, double share) const noexcept;
  std::size_t pass_pairs(std::size_t i, double share, const double* commands, const double* states) noexcept;
  void limit_plain(double share, std::span<double> commands, std::span<const double> states,
                   std::uint64_t cycle, bool still, hardware::FaultEvents& faults) noexcept;
  void one(Full& f, double share, std::span<double> commands, std::span<const double> states,
           std::uint64_t cycle, bool still, hardware::FaultEvents& faults) noexcept;
  void note(std::uint64_t cycle, std::uint32_t command, controllers::Limit limit, double asked,
            double given) noexcept;
  /// Reports a joint that was not far outside before.
  static void judge(std::uint32_t command, double measured, bool far_outside, auto& outside,
                    hardware::FaultEvents& faults) noexcept {
    if (far_outside && !outside)
      faults.push({hardware::StopCause::limits, -1, static_cast<std::int32_t>(command), -1, measured});
    outside = far_outside;
  }

  Plain plain_;
  bool plain_as_usual_ = false;  // all are measured, change every cycle, and were inside their limits
  std::vector<Full> full_;
  double dt_ = 1e-3;
  std::atomic<double> share_{1};
  bool still_ = false;
  std::vector<std::string> names_;     // of the limited commands
  std::vector<std::int32_t> place_;    // of each command in names_
  std::unique_ptr<Record[]> records_;  // kLimits per name
  std::atomic<std::uint64_t> clamps_{0};
};

}  // namespace polyarm::control
