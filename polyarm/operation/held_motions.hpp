#pragma once
/// Motion that goes on while somebody holds a key: it begins, is renewed by heartbeats, and ends with the
/// key, or when no heartbeat comes. Doors map their clients and messages to it.
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

/// What has become of a held motion.
struct HeldEvent {
  enum class What {
    begun,      ///< it moves
    held_back,  ///< something holds it back, or nothing does any more (`why` is empty)
    over,       ///< it has ended after it had begun
    refused     ///< it has ended before it moved; `refusal` says why
  };
  std::uint64_t motion = 0;
  What what = What::begun;
  std::string robot;
  std::uint32_t session = 0;
  std::string why, text;  ///< one word for programs, a sentence for people
  std::string which;      ///< the joint or the zone of the workspace that holds it back; empty: neither does
  std::optional<Error> refusal{};
};

/// Cell thread.
class HeldMotions {
 public:
  /// A motion that nothing renews comes to rest after this time, s.
  static constexpr double kSilence = 0.12;

  HeldMotions(const JogOwners& cell, Worker& worker);
  ~HeldMotions();

  /// Joints, the TCP or a base move as the request says. Returns the number of the motion; throws Error with
  /// why there is none.
  std::uint64_t begin(const protocol::JogBegin& request);
  /// The robot goes to a place. The way is planned first; where there is none, the motion is refused and
  /// nothing moves. Then the joints go there, or the TCP in a straight line, and it is over when the robot
  /// stands there ("arrived").
  std::uint64_t go_to(const protocol::JogGoto& request);
  /// A heartbeat, which also looks at what holds the motion back. Of a motion that is over it does nothing.
  void renew(std::uint64_t motion);
  /// `why`: "released", "control" …
  void end(std::uint64_t motion, const std::string& why);
  void tick();
  std::vector<HeldEvent> take_events();

  /// The same motion as begin(), by an amount.
  protocol::JogMotion step(const protocol::JogStep& request) const;

 private:
  struct Motion;
  Motion& add(std::size_t robot);
  Motion* find(std::uint64_t motion) const;
  template <class Keys>
  protocol::JogMotion wish_of(std::size_t robot, const Keys& request, double amount, bool by) const;
  void drive(Motion& motion, const protocol::JogBegin& request);
  void push(const Motion& motion, double share) const;
  void take_plan(Motion& motion);
  void advance(Motion& motion);
  void start(Motion& motion);
  void follow(Motion& motion);
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
