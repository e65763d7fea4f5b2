#pragma once
/// The hand of a robot of Franka: its wire (TCP port 1338, states as datagrams) and the driver's end of it.
/// Version 3 of its interface. m, N, m/s. One thread at a time.
#include <optional>
#include <string>

#include "drivers/franka/port.hpp"
#include "polyarm/base/descriptor.hpp"

namespace polyarm::franka {

inline constexpr int kHandPort = 1338;
inline constexpr int kHandVersion = 3;
inline constexpr std::size_t kHandHead = 10, kHandState = 23;

enum class HandRequest : std::uint8_t { connect, homing, grasp, move, stop };
enum class HandStatus : std::uint16_t { success, failed, unsuccessful, aborted };

struct HandState {
  std::uint32_t id = 0;  ///< ms of its clock
  double width = 0, max_width = 0;
  bool grasped = false;
  int temperature = 0;  ///< degrees Celsius
};
Data encode(const HandState& state);
/// Nothing for another length, or numbers that are not finite.
std::optional<HandState> decode_hand_state(Bytes data);

struct HandOrder {
  HandRequest what = HandRequest::stop;
  double width = 0, speed = 0;             ///< of grasp and move
  double force = 0, inner = 0, outer = 0;  ///< of grasp
};
Data encode(const HandOrder& order);
/// Nothing for another length or numbers that are not finite.
std::optional<HandOrder> decode_hand_order(std::uint32_t command, Bytes data);

struct HandSettings {
  bool used = false;
  int port = kHandPort;
  double force = 40, speed = 0.1, open_width = 0.08;
};

/// NaN: nothing is wanted.
struct HandWish {
  double grip, width, homing;
  HandWish() noexcept;
};

class Hand {
 public:
  Hand(std::string host, HandSettings settings)
      : settings_(settings), port_(std::move(host), settings.port, kHandHead) {}
  /// Connects, and waits for the first state. False: see refusal().
  bool open(Nanoseconds timeout);
  void close();
  /// Drops all wishes.
  void forget() { wanted_ = done_ = HandWish(); }
  /// One exchange: takes states and replies, and orders what `wish` changed. Never waits. False: see
  /// refusal().
  bool serve(const HandWish& wish, Nanoseconds now, Nanoseconds timeout);
  /// Waits until a state with this id has come.
  void await_state(std::uint32_t id, Nanoseconds timeout);
  const HandState& state() const { return state_; }
  bool busy() const { return asked_.has_value(); }
  const Refusal& refusal() const { return refusal_; }

 private:
  bool refuse(Cause cause, int detail = 0, const std::string& text = {});
  bool refuse_port();
  bool take();
  bool take_reply(const Frame& frame);
  std::optional<HandOrder> next_order();
  bool order(const HandOrder& order, Nanoseconds now);

  HandSettings settings_;
  Port port_;
  Descriptor states_;
  std::uint32_t robot_host_ = 0;  // network byte order
  HandState state_;
  bool seen_ = false;
  HandWish wanted_, done_;
  struct Asked {
    std::uint32_t id;
    HandRequest what;
    bool stopped;
  };
  std::optional<Asked> asked_;
  std::optional<std::uint32_t> stop_;  ///< id of a stop without a reply yet
  Nanoseconds asked_at_ = 0;
  Nanoseconds heard_at_ = 0;  ///< of the newest state
  Refusal refusal_;
};

}  // namespace polyarm::franka
