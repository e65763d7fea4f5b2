#pragma once
/// Motion while somebody holds a key: it begins, is renewed by heartbeats, and ends when the key is released
/// or the heartbeats stop. Doors map their clients and messages to these motions.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/operation/jog_owners.hpp"
#include "polyarm/protocol/jog.hpp"

namespace polyarm::jog {
struct JogStatus;
}
namespace polyarm::protocol {
struct JogBegin;
struct JogGoto;
struct JogStep;
}  // namespace polyarm::protocol

namespace polyarm::cell {

class Worker;

/// An event of a held motion.
struct HeldEvent {
  enum class What {
    begun,      ///< the robot moves
    held_back,  ///< something holds it back; an empty `why` means that nothing does any more
    over,       ///< it ended after it had begun
    refused     ///< it ended before it moved; `refusal` says why
  };
  std::uint64_t motion = 0;
  What what = What::begun;
  std::string robot;
  std::uint32_t session = 0;
  std::string why, text;  ///< one word for programs; a sentence for people
  std::string which;      ///< joint or workspace zone that holds it back; empty if neither does
  std::optional<Error> refusal{};
};

/// Cell thread.
class HeldMotions {
 public:
  /// Time without a heartbeat after which a motion comes to rest, s.
  static constexpr double kSilence = 0.12;

  HeldMotions(const JogOwners& cell, Worker& worker);
  ~HeldMotions();

  /// Starts moving joints, the TCP or a base. Returns the number of the motion. Throws Error if it is
  /// refused.
  std::uint64_t begin(const protocol::JogBegin& request);
  /// Moves the robot to a target. The path is planned first; if planning fails, the motion is refused and
  /// nothing moves. Then the joints move to the target, or the TCP moves there in a straight line. The motion
  /// ends with "arrived" when the robot has come to rest at the target.
  std::uint64_t go_to(const protocol::JogGoto& request);
  /// A heartbeat; also checks what holds the motion back. Does nothing for a motion that has ended.
  void renew(std::uint64_t motion);
  /// `why`: "released", "control", …
  void end(std::uint64_t motion, const std::string& why);
  void tick();
  std::vector<HeldEvent> take_events();

  /// The same motion as begin(), by a fixed amount.
  protocol::JogMotion step(const protocol::JogStep& request) const;

 private:
  struct Motion;
  Motion& add(std::size_t robot);
  Motion* find(std::uint64_t motion) const;
  template <class Keys>
  protocol::JogMotion jog_motion_of(std::size_t robot, const Keys& request, double amount, bool by) const;
  void drive(Motion& motion, const protocol::JogBegin& request);
  void push(const Motion& motion, double share) const;
  void take_plan(Motion& motion);
  void advance(Motion& motion);
  void start(Motion& motion);
  void follow(Motion& motion);
  void follow_base(Motion& motion);
  void report_hold(Motion& motion, const jog::JogStatus& status);
  bool is_there(const Motion& motion, const jog::JogStatus& status) const;
  void finish(Motion& motion, const std::string& why, const std::string& text,
              const Error* refusal = nullptr);
  HeldEvent event(const Motion& motion, HeldEvent::What what) const;
  std::size_t robot_of(const std::optional<std::string>& name) const;

  JogOwners cell_;
  Worker& worker_;
  std::vector<std::unique_ptr<Motion>> all_;
  std::vector<HeldEvent> events_;
  std::uint64_t last_ = 0;
};

}  // namespace polyarm::cell
