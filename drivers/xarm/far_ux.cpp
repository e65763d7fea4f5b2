#include "drivers/xarm/far_ux.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace polyarm::xarm {

namespace {

constexpr std::size_t kMostKept = 1 << 16;
constexpr std::size_t kModbusHead = 7;

}  // namespace

void FarUx::listen(const std::string& address, const FarPorts& ports) {
  commands_.listen(address, ports.command);
  normal_.listen(address, ports.normal);
  rich_.listen(address, ports.rich);
  real_.listen(address, ports.real);
}

FarPorts FarUx::ports() const {
  return {commands_.port(), normal_.port(), rich_.port(), real_.port()};
}

void FarUx::descriptors(std::vector<int>& out) {
  for (auto* service : {&commands_, &normal_, &rich_, &real_}) {
    out.push_back(service->listener());
    for (const auto& client : service->clients()) out.push_back(client->socket.number());
  }
}

void FarUx::drop_reports() {
  for (auto* service : {&normal_, &rich_, &real_}) service->drop_all();
}

void FarUx::drop_all() {
  drop_commands();
  drop_reports();
}

void FarUx::serve() {
  const auto arrived = [this](Client& client) { client.gone = faults_.power_off; };
  const auto ignore = [](Client&, Bytes) { return true; };
  commands_.serve(arrived, [this](Client& client, Bytes bytes) { return take(client, bytes); });
  for (auto* service : {&normal_, &rich_, &real_}) service->serve(arrived, ignore);
}

void FarUx::cycle() {
  machine_.step();
  send_kept();
  if (++since_real_ >= real_cycles_) {
    since_real_ = 0;
    if (!faults_.silent && !faults_.power_off)
      for (auto& client : real_.clients()) send_real(*client);
  }
  if (++since_slow_ < slow_cycles_) return;
  since_slow_ = 0;
  if (faults_.silent || faults_.power_off) return;
  send_slow(normal_, ReportKind::normal);
  send_slow(rich_, ReportKind::rich);
}

void FarUx::send_slow(wire::Service<Client>& service, ReportKind kind) {
  const auto bytes = encode(machine_.report(), machine_.slow_report(), kind);
  for (auto& client : service.clients())
    if (!wire::send_frame(client->socket.number(), bytes)) client->gone = true;
}

void FarUx::send_real(Client& client) {
  Report report = machine_.report();
  if (std::exchange(faults_.not_a_number, false))
    report.position[1] = std::numeric_limits<double>::quiet_NaN();
  auto bytes = encode(report, {}, ReportKind::real);
  if (std::exchange(faults_.nonsense, false)) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0xEE});
  if (std::exchange(faults_.short_report, false)) bytes[3] = 16;
  client.kept.append(bytes.begin(), bytes.end());
  ++client.reports;
  if (faults_.late > 0 && client.kept.size() < kMostKept) {
    --faults_.late;
    return;
  }
  const std::string out = std::exchange(client.kept, {});
  if (!wire::send_frame(client.socket.number(), out)) client.gone = true;
  ++reports_;
  newest_ = client.reports;
}

/// Answers that a fault kept back.
void FarUx::send_kept() {
  if (faults_.late_answers > 0 && --faults_.late_answers > 0) return;
  for (auto& client : commands_.clients()) {
    if (client->kept.empty()) continue;
    const std::string out = std::exchange(client->kept, {});
    if (!wire::send_frame(client->socket.number(), out)) client->gone = true;
  }
}

bool FarUx::send(Client& client, std::vector<std::uint8_t> bytes) {
  if (faults_.mute) return true;
  if (std::exchange(faults_.bad_answer, false)) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0xEE});
  if (faults_.late_answers > 0 && client.kept.size() < kMostKept) {
    client.kept.append(bytes.begin(), bytes.end());
    return true;
  }
  const bool sent = wire::send_frame(client.socket.number(), bytes);
  return sent && (!faults_.twice || wire::send_frame(client.socket.number(), bytes));
}

bool FarUx::take(Client& client, Bytes bytes) {
  if (faults_.power_off || !client.reader.feed(bytes)) return false;
  while (const auto frame = client.reader.next()) {
    ++requests_;
    if (!answer(client, *frame)) return false;
  }
  return true;
}

/// Modbus TCP at the same port has no registers here: each function gets the exception "illegal function".
bool FarUx::answer(Client& client, const UxFrame& frame) {
  if (frame.protocol == 0 && frame.body.size() >= 2) {
    const UxData out = UxData()
                           .u16(frame.transaction)
                           .u16(0)
                           .u16(kModbusHead - 4)
                           .u8(frame.body[0])
                           .u8(frame.body[1] | 0x80u)
                           .u8(1);
    return send(client, out);
  }
  const auto request = decode_request(frame);
  if (!request) return true;  // a heartbeat of a client has another protocol
  UxReply reply = machine_.answer(*request);
  if (std::exchange(faults_.other_register, false)) reply.reg = Register::reload_dynamics;
  return send(client, encode(reply));
}

}  // namespace polyarm::xarm
