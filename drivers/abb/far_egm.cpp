/// EGM of the simulated controller.
#include <algorithm>
#include <cmath>

#include "drivers/abb/far_services.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::abb {

namespace {
constexpr int kLastPackets = 3;  // after EGM ended
}  // namespace

void FarEgm::serve() {
  socket_.receive<bounds::kEgmDatagramBytes>([this](Bytes bytes) {
    if (faults_.power_off) return;
    const auto message = decode_sensor(bytes);
    if (!message) return;
    unanswered_ = std::max(0, unanswered_ - 1);  // the clock waits for an answer that is not taken, too
    if (faults_.deaf) return;
    ++messages_;
    answers_ = true;
    machine_.take(*message);
  });
}

void FarEgm::begin_session() {
  sending_ = true;
  starts_ = machine_.starts();
  answers_ = renewed_ = false;
  unanswered_ = 0;
  sequence_ = 0;
  began_ = machine_.time();
  last_packets_ = kLastPackets;
  socket_.clear();
}

void FarEgm::cycle() {
  if (machine_.starts() != starts_) begin_session();
  machine_.step(machine_.options().rapid.sampling_ms / 1000.0);
  if (!sending_) return;
  send();
  const bool is = machine_.egm() == Machine::Egm::beginning || machine_.egm() == Machine::Egm::running;
  if (is || --last_packets_ >= 0) return;
  sending_ = answers_ = false;
  unanswered_ = 0;
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
  const auto [went, packets] = socket_.send(std::move(bytes), faults_);
  packets_ += static_cast<std::uint64_t>(packets);
  if (packets > 0) sent_sequence_ = sequence_ - 1;
  unanswered_ = wire::unanswered(went, unanswered_, packets, broken);
}

}  // namespace polyarm::abb
