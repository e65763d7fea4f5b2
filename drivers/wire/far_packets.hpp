#pragma once
/// The packets of a simulated controller, with the faults that a person orders for them. One thread; nothing
/// here waits.
#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "drivers/wire/bytes.hpp"
#include "drivers/wire/orders.hpp"
#include "drivers/wire/udp.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::wire {

/// What goes wrong on purpose.
struct PacketFaults {
  bool silent = false;    ///< nothing is sent
  bool deaf = false;      ///< what comes is not taken
  bool garbage = false;   ///< the next packet is broken
  bool stranger = false;  ///< packets come from another address
  int duplicate = 0;      ///< packets that are sent twice
  int reorder = 0;        ///< packets that are sent after the next one
  int late = 0;           ///< packets that are kept back, then sent together
  /// Those that a person ordered.
  void take(const Order& order) {
    order.switch_on({{"silent", &silent}, {"deaf", &deaf}, {"garbage", &garbage}, {"stranger", &stranger}});
    order.set_count({{"duplicate", &duplicate, 10}, {"reorder", &reorder, 10}, {"late", &late, 10}});
  }
};

/// Packets on their way out, which faults keep back, reorder and repeat.
class PacketQueue {
 public:
  using Packet = std::vector<std::uint8_t>;
  enum class Went : std::uint8_t {
    nowhere,   ///< it is kept back
    in_turn,   ///< behind those that were kept back
    together,  ///< with those that were kept back, as a fault wants it
  };
  /// Hands what goes out in this cycle to `send`, and what goes out twice to `again`.
  template <typename Send, typename Again>
  Went pass(Packet packet, PacketFaults& faults, Send send, Again again) {
    kept_.push_back(std::move(packet));
    const bool late = faults.late > 0;
    const bool disturbed = late || faults.reorder > 0;
    if (disturbed) {
      int& left = late ? faults.late : faults.reorder;
      if (--left > 0 && (late || kept_.size() < 2)) return Went::nowhere;
      if (!late) std::reverse(kept_.begin(), kept_.end());
    }
    for (const Packet& one : kept_) send(one);
    if (!disturbed && faults.duplicate > 0 && faults.duplicate-- > 0) again(kept_.back());
    kept_.clear();
    return disturbed ? Went::together : Went::in_turn;
  }
  void clear() { kept_.clear(); }

 private:
  std::vector<Packet> kept_;
};

/// Packets without an answer, after `packets` more of which the last may be broken.
inline int unanswered(PacketQueue::Went went, int before, int packets, bool broken) {
  if (went == PacketQueue::Went::nowhere) return before;
  if (went == PacketQueue::Went::together) return 1;  // an old packet behind a newer one gets no answer
  return before + packets - (broken ? 1 : 0);         // nor does a broken one
}

/// The socket of a simulated controller that sends to one computer and takes its answers.
class FarSocket {
 public:
  /// Throws Error("no-port").
  void open(const std::string& address) {
    std::string why;
    socket_ = bind_udp(address, 0, why);
    stranger_ = bind_udp(address.starts_with("127.") ? kOtherHost : address, 0, why);
    if (!socket_ || !stranger_) throw Error("no-port", why, "choose another address");
  }
  /// `what` and `example` are named in the Error("bad-value").
  void send_to(const std::string& address, int port, const std::string& what, int example) {
    const auto target = udp_address(address, port);
    if (!target)
      throw Error("bad-value", "'" + address + ":" + std::to_string(port) + "' is no address for " + what,
                  "write the address of the computer with the driver, for example 127.0.0.1:" +
                      std::to_string(example));
    target_ = *target;
  }
  void send_to(const UdpAddress& target) { target_ = target; }
  int descriptor() const { return socket_.number(); }

  struct Sent {
    PacketQueue::Went went;
    int packets = 0;  ///< that the computer may take for the controller's
  };
  Sent send(PacketQueue::Packet packet, PacketFaults& faults) {
    int packets = 0;
    const auto send = [&](const PacketQueue::Packet& one) {
      send_datagram((faults.stranger ? stranger_ : socket_).number(), one, target_);
      if (!faults.stranger) ++packets;
    };
    const auto again = [&](const PacketQueue::Packet& one) { send_datagram(socket_.number(), one, target_); };
    const PacketQueue::Went went = queue_.pass(std::move(packet), faults, send, again);
    return {went, packets};
  }
  /// What was kept back is never sent.
  void clear() { queue_.clear(); }

  /// Hands each datagram of the computer that has come to `take`.
  template <std::size_t kBytes, typename Take>
  void receive(Take take) {
    std::array<std::uint8_t, kBytes> bytes;
    UdpAddress from;
    for (int i = 0; i < kDatagramsInTurn; ++i) {
      const Received got = receive_datagram(socket_.number(), bytes, &from);
      if (got.got != Got::bytes) return;
      if (from == target_) take(Bytes(bytes).first(got.count));
    }
  }

 private:
  static constexpr int kDatagramsInTurn = 256;
  static constexpr const char* kOtherHost = "127.0.0.2";
  Descriptor socket_, stranger_;
  UdpAddress target_;
  PacketQueue queue_;
};

}  // namespace polyarm::wire
