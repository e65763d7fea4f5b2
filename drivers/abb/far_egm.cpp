/// EGM of the simulated controller.
#include <arpa/inet.h>

#include <algorithm>
#include <cmath>

#include "drivers/abb/far_services.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::abb {

namespace {
constexpr int kLastPackets = 3;  // after EGM ended
constexpr const char* kOtherHost = "127.0.0.2";
}  // namespace

void FarEgm::open(const std::string& address) {
  std::string why;
  socket_ = wire::bind_udp(address, 0, why);
  stranger_ = wire::bind_udp(address.starts_with("127.") ? kOtherHost : address, 0, why);
  if (!socket_ || !stranger_) throw Error("no-port", why, "choose another address");
}

void FarEgm::send_to(const std::string& address, int port) {
  in_addr host{};
  if (::inet_pton(AF_INET, address.c_str(), &host) != 1 || port < 1 || port > 65535)
    throw Error("bad-value", "'" + address + ":" + std::to_string(port) + "' is no address for EGM",
                "write the address of the computer with the driver, for example 127.0.0.1:6510");
  target_ = {host.s_addr, htons(static_cast<std::uint16_t>(port))};
}

void FarEgm::serve() {
  std::array<std::uint8_t, bounds::kEgmDatagramBytes> bytes;
  wire::UdpAddress from;
  for (int i = 0; i < 256; ++i) {
    const wire::Received got = wire::receive_datagram(socket_.number(), bytes, &from);
    if (got.got != wire::Got::bytes) return;
    if (faults_.power_off || !(from == target_)) continue;
    const auto message = decode_sensor(Bytes(bytes).first(got.count));
    if (!message) continue;
    unanswered_ = std::max(0, unanswered_ - 1);  // the clock waits for an answer that is not taken, too
    if (faults_.deaf) continue;
    ++messages_;
    answers_ = true;
    machine_.take(*message);
  }
}

void FarEgm::begin_session() {
  sending_ = true;
  starts_ = machine_.starts();
  answers_ = renewed_ = false;
  unanswered_ = 0;
  sequence_ = 0;
  began_ = machine_.time();
  last_packets_ = kLastPackets;
  kept_.clear();
}

void FarEgm::cycle() {
  if (machine_.starts() != starts_) begin_session();
  machine_.step(machine_.options().rapid.sampling_ms / 1000.0);
  if (!sending_) return;
  send();
  const bool is = machine_.egm() == Machine::Egm::beginning || machine_.egm() == Machine::Egm::running;
  if (!is && --last_packets_ < 0) sending_ = answers_ = false;
}

EgmRobot FarEgm::packet() const {
  EgmRobot out;
  out.header.sequence = sequence_;
  out.header.time_ms =
      static_cast<std::uint32_t>(std::llround((machine_.time() - began_) * 1000)) * (faults_.slow ? 2 : 1);
  out.header.type = MessageType::data;
  EgmPosition at;
  at.joints.emplace().count = faults_.seven ? 7 : 6;
  std::copy(machine_.q().begin(), machine_.q().end(), at.joints->value.begin());
  const Pose flange = machine_.flange();
  const auto& [p, o] = std::pair{flange.position, flange.rotation};
  at.pose = EgmPose{{1000 * p.x, 1000 * p.y, 1000 * p.z}, {o.w, o.x, o.y, o.z}};
  at.external.emplace();
  if (!faults_.old) {
    const auto us = static_cast<std::uint64_t>(std::llround(machine_.time() * 1e6));
    at.time = EgmClock{us / 1'000'000, us % 1'000'000};
  }
  out.planned = at;
  std::copy(machine_.reference().begin(), machine_.reference().end(), out.planned->joints->value.begin());
  out.feedback = at;
  out.motors = machine_.motors() ? MotorState::on : MotorState::off;
  out.state = faults_.egm_error ? EgmState::error : machine_.egm_state();
  out.converged = machine_.converged();
  out.rapid = machine_.program_runs() ? RapidState::running : RapidState::stopped;
  if (!faults_.old) out.utilization = machine_.utilization();
  if (machine_.collided()) out.collision = true;
  return out;
}

void FarEgm::send_bytes(const std::vector<std::uint8_t>& bytes) {
  if (faults_.stranger) return void(wire::send_datagram(stranger_.number(), bytes, target_));
  wire::send_datagram(socket_.number(), bytes, target_);
  ++packets_;
  sent_sequence_ = sequence_ - 1;
  ++unanswered_;
}

void FarEgm::send() {
  if (std::exchange(faults_.restarted, false)) {
    sequence_ = 0;
    renewed_ = true;
  }
  std::vector<std::uint8_t> bytes = encode(packet());
  ++sequence_;
  if (faults_.silent || faults_.power_off) return;
  const bool broken = std::exchange(faults_.garbage, false);
  if (broken) bytes.resize(bytes.size() / 2);
  if (faults_.late > 0 || faults_.reorder > 0) {
    kept_.push_back(bytes);
    const bool late = faults_.late > 0;
    int& left = late ? faults_.late : faults_.reorder;
    if (--left > 0 && (late || kept_.size() < 2)) return;
    if (!late) std::reverse(kept_.begin(), kept_.end());
    for (const auto& one : kept_) send_bytes(one);
    unanswered_ = 1;  // an old packet behind a newer one gets no answer
    return kept_.clear();
  }
  for (const auto& one : kept_) send_bytes(one);
  kept_.clear();
  send_bytes(bytes);
  if (broken) --unanswered_;  // nobody answers it
  if (faults_.duplicate > 0 && faults_.duplicate-- > 0) wire::send_datagram(socket_.number(), bytes, target_);
}

}  // namespace polyarm::abb
