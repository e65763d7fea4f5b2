#include "drivers/franka/far_hand.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <cmath>

#include "drivers/wire/ordered_bytes.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::franka {

namespace {
constexpr double kStep = 0.001;        // s
constexpr double kMostSpeed = 0.1;     // m/s
constexpr double kHomingSpeed = 0.05;  // m/s
constexpr int kStateCycles = 10;
}  // namespace

void Fingers::finish(HandStatus status) {
  if (!running_) return;
  running_->status = status;
  end_ = std::exchange(running_, std::nullopt);
}

std::optional<HandStatus> Fingers::order(const HandOrder& order, std::uint32_t id, std::uint32_t command) {
  if (order.what == HandRequest::stop) {
    finish(HandStatus::aborted);
    return HandStatus::success;
  }
  const bool wrong = order.what != HandRequest::homing &&
                     (order.width < 0 || order.width > kMost || !(order.speed > 0) || order.force < 0);
  if (fails || wrong || running_) return HandStatus::failed;
  order_ = order;
  opening_ = true;
  if (order.what == HandRequest::homing) homed_ = false;
  if (order.what != HandRequest::grasp) grasped_ = false;
  running_ = End{id, command, HandStatus::success};
  return std::nullopt;
}

/// Homing opens, then closes; a grasp closes until the fingers meet a part, or each other.
void Fingers::step() {
  ++id_;
  if (!running_) return;
  const bool grasp = order_.what == HandRequest::grasp, homing = order_.what == HandRequest::homing;
  const double speed = homing ? kHomingSpeed : std::min(order_.speed, kMostSpeed);
  const double least = part_ <= width_ ? part_ : 0;
  const double goal = homing ? (opening_ ? kMost : least) : grasp ? least : std::max(order_.width, least);
  const double most = speed * kStep;
  width_ += std::clamp(goal - width_, -most, most);
  if (std::abs(goal - width_) > 1e-12) return;
  if (homing && std::exchange(opening_, false)) return;
  homed_ = true;
  if (!grasp) return finish(HandStatus::success);
  grasped_ = width_ >= order_.width - order_.inner && width_ <= order_.width + order_.outer;
  finish(grasped_ ? HandStatus::success : HandStatus::unsuccessful);
}

HandState Fingers::state() const {
  return {id_, width_, homed_ ? kMost : 0, grasped_, 30};
}

// --- its port ---------------------------------------------------------------------------------------------

void FarHand::listen(const std::string& address, int port) {
  door_.listen(address, port);
  std::string why;
  socket_ = wire::bind_udp(address, 0, why);
  if (!socket_) throw Error("no-port", why, "choose another address");
}

bool FarHand::reply(Client& client, std::uint32_t command, std::uint32_t id, const Data& data) {
  if (faults_.hand_mute || faults_.power_off) return true;
  wire::OrderedWriter out(wire::ByteOrder::little);
  out.u16(command).u32(id).u32(kHandHead + data.size()).append(data);
  return wire::send_frame(client.socket.number(), out.bytes());
}

bool FarHand::connect(Client& client, const Frame& frame) {
  if (frame.data.size() != 4) return false;
  const int spoken = faults_.hand_version > 0 ? faults_.hand_version : kHandVersion;
  const int version = frame.data[0] | frame.data[1] << 8, port = frame.data[2] | frame.data[3] << 8;
  const Data data{static_cast<std::uint8_t>(version == spoken ? 0 : 1), 0, static_cast<std::uint8_t>(spoken),
                  static_cast<std::uint8_t>(spoken >> 8)};
  if (!reply(client, frame.command, frame.id, data) || version != spoken) return version == spoken;
  in_addr host{};
  ::inet_pton(AF_INET, wire::peer_address(client.socket.number()).c_str(), &host);
  client.target = wire::UdpAddress{host.s_addr, htons(static_cast<std::uint16_t>(port))};
  return true;
}

bool FarHand::take(Client& client, const Frame& frame) {
  if (frame.command == static_cast<std::uint32_t>(HandRequest::connect)) return connect(client, frame);
  const auto order = decode_hand_order(frame.command, frame.data);
  if (!order || !client.target) return false;
  fingers_.fails = faults_.hand_fails;
  const auto status = fingers_.order(*order, frame.id, frame.command);
  if (!status) return true;
  return reply(
      client, frame.command, frame.id,
      {static_cast<std::uint8_t>(*status), static_cast<std::uint8_t>(static_cast<int>(*status) >> 8)});
}

void FarHand::serve() {
  door_.serve([this](Client& client) { client.gone = faults_.power_off || door_.clients().size() > 1; },
              [this](Client& client, Bytes bytes) {
                if (!client.reader.feed(bytes)) return false;
                while (const auto frame = client.reader.next())
                  if (!take(client, *frame)) return false;
                return true;
              });
}

void FarHand::cycle() {
  fingers_.step();
  const auto end = fingers_.take_end();
  for (auto& client : door_.clients()) {
    if (!client->target) continue;
    if (end) {
      const auto status = static_cast<std::uint16_t>(end->status);
      reply(*client, end->command, end->id,
            {static_cast<std::uint8_t>(status), static_cast<std::uint8_t>(status >> 8)});
    }
    if (since_ > 0 || faults_.hand_silent || faults_.power_off) continue;
    const HandState state = fingers_.state();
    wire::send_datagram(socket_.number(), encode(state), *client->target);
    newest_ = state.id;
  }
  since_ = (since_ + 1) % kStateCycles;
}

void FarHand::descriptors(std::vector<int>& out) {
  out.push_back(door_.listener());
  for (const auto& client : door_.clients()) out.push_back(client->socket.number());
}

}  // namespace polyarm::franka
