/// RSI and EthernetKRL of the simulated controller.
#include "drivers/kuka/far_services.hpp"

#include <arpa/inet.h>

#include <algorithm>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::kuka {

namespace {
constexpr const char* kOtherHost = "127.0.0.2";
}

void FarRsi::open(const std::string& address) {
  std::string why;
  socket_ = wire::bind_udp(address, 0, why);
  stranger_ = wire::bind_udp(address.starts_with("127.") ? kOtherHost : address, 0, why);
  if (!socket_ || !stranger_) throw Error("no-port", why, "choose another address");
}

void FarRsi::send_to(const std::string& address, int port) {
  in_addr host{};
  if (::inet_pton(AF_INET, address.c_str(), &host) != 1 || port < 1 || port > 65535)
    throw Error("bad-value", "'" + address + ":" + std::to_string(port) + "' is no address for RSI",
                "write the address of the computer with the driver, for example 127.0.0.1:59152");
  target_ = {host.s_addr, htons(static_cast<std::uint16_t>(port))};
}

void FarRsi::serve() {
  std::array<std::uint8_t, bounds::kRsiDatagramBytes> bytes;
  wire::UdpAddress from;
  for (int i = 0; i < 256; ++i) {
    const wire::Received got = wire::receive_datagram(socket_.number(), bytes, &from);
    if (got.got != wire::Got::bytes) return;
    if (faults_.power_off || !(from == target_)) continue;
    const auto answer = decode_sensor({reinterpret_cast<const char*>(bytes.data()), got.count}, sen_type_);
    if (!answer) continue;
    // The clock waits for an answer that is not taken, too.
    unanswered_ = std::max(0, unanswered_ - 1);
    answers_ = true;
    if (faults_.deaf) continue;
    ++taken_;
    machine_.take(*answer);
  }
}

void FarRsi::cycle() {
  machine_.step();
  if (!machine_.rsi()) {
    answers_ = false;
    unanswered_ = 0;
    kept_.clear();
    return;
  }
  if (machine_.sessions() != session_) {
    session_ = machine_.sessions();
    answers_ = renewed_ = false;
    unanswered_ = 0;
    sent_clock_ = 0;
  }
  renewed_ = renewed_ || machine_.ipoc() < sent_clock_;
  send();
}

void FarRsi::send_text(const std::string& text) {
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  if (faults_.stranger) return void(wire::send_datagram(stranger_.number(), bytes, target_));
  wire::send_datagram(socket_.number(), bytes, target_);
  ++packets_;
  sent_clock_ = machine_.ipoc();
  ++unanswered_;
}

void FarRsi::send() {
  std::string text = encode(machine_.packet());
  if (faults_.silent || faults_.power_off) return;
  const bool broken = std::exchange(faults_.garbage, false);
  if (broken) text.resize(text.size() / 2);
  if (faults_.late > 0 || faults_.reorder > 0) {
    kept_.push_back(text);
    const bool late = faults_.late > 0;
    int& left = late ? faults_.late : faults_.reorder;
    if (--left > 0 && (late || kept_.size() < 2)) return;
    if (!late) std::reverse(kept_.begin(), kept_.end());
    for (const auto& one : kept_) send_text(one);
    unanswered_ = 1;  // an old packet behind a newer one gets no answer
    return kept_.clear();
  }
  for (const auto& one : kept_) send_text(one);
  kept_.clear();
  send_text(text);
  if (broken) --unanswered_;  // nobody answers it
  if (faults_.duplicate > 0 && faults_.duplicate-- > 0)
    wire::send_datagram(socket_.number(), {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()},
                        target_);
}

EkiResult FarEki::carry_out(const EkiRequest& request) {
  switch (request.what) {
    case EkiDo::state:
      return EkiResult::done;
    case EkiDo::start:
      return machine_.start();
    case EkiDo::stop:
      machine_.stop();
      return EkiResult::done;
    case EkiDo::drives_on:
      return machine_.drives_on();
    case EkiDo::speed_override:
      return machine_.set_override(request.value);
    case EkiDo::output:
      return machine_.set_output(request.number, request.value != 0);
    case EkiDo::begin:
      return moves_.begin(request.value);
    case EkiDo::move:
      return moves_.take(request);
    case EkiDo::halt:
      return moves_.halt(request.value, request.number);
    case EkiDo::tool:
      return request.move ? moves_.set_tool(request.value, *request.move) : EkiResult::not_ready;
    case EkiDo::end:
      return moves_.end();
  }
  return EkiResult::unknown;
}

/// False: the connection is of no use.
bool FarEki::take(Client& client, const std::string& text) {
  const auto request = decode_request(text);
  if (!request) return false;
  ++requests_;
  moves_.hear();
  const EkiResult result = carry_out(*request);
  if (faults_.mute || faults_.power_off) return true;
  EkiReply reply = machine_.reply();
  moves_.fill(reply.state);
  reply.id = request->id;
  reply.result = result;
  if (faults_.other_program) reply.identity.version = kProgramVersion + 1;
  return wire::send_frame(client.socket.number(),
                          faults_.nonsense ? "<Robot><Answer/>&</Robot>" : encode(reply));
}

/// The client that came first has the program to itself; what it left behind does not count.
bool FarEki::is_first(const Client& client) {
  for (const auto& one : door_.clients())
    if (!one->gone) return one.get() == &client;
  return false;
}

void FarEki::serve() {
  door_.serve([this](Client& client) { client.gone = faults_.busy || faults_.power_off; },
              [this](Client& client, wire::Bytes bytes) {
                if (!is_first(client)) return false;
                if (!client.reader.feed({reinterpret_cast<const char*>(bytes.data()), bytes.size()}))
                  return false;
                for (std::string text = client.reader.next(); !text.empty(); text = client.reader.next())
                  if (!take(client, text)) return false;
                return true;
              });
  for (std::size_t i = 1; i < door_.clients().size(); ++i) door_.clients()[i]->gone = true;
  door_.drop_gone();
  if (door_.clients().empty()) moves_.end();
}

void FarEki::descriptors(std::vector<int>& out) {
  out.push_back(door_.listener());
  for (const auto& client : door_.clients()) out.push_back(client->socket.number());
}

}  // namespace polyarm::kuka
