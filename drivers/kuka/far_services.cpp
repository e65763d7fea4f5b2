/// RSI and EthernetKRL of the simulated controller.
#include "drivers/kuka/far_services.hpp"

#include <algorithm>

#include "polyarm/base/bounds.hpp"

namespace polyarm::kuka {

void FarRsi::serve() {
  socket_.receive<bounds::kRsiDatagramBytes>([this](wire::Bytes bytes) {
    if (faults_.power_off) return;
    const auto answer = decode_sensor({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, sen_type_);
    if (!answer) return;
    // The clock waits for an answer that is not taken, too.
    unanswered_ = std::max(0, unanswered_ - 1);
    answers_ = true;
    if (faults_.deaf) return;
    ++taken_;
    machine_.take(*answer);
  });
}

void FarRsi::cycle() {
  machine_.step();
  if (!machine_.rsi()) {
    answers_ = false;
    unanswered_ = 0;
    socket_.clear();
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

void FarRsi::send() {
  std::string text = encode(machine_.packet());
  if (faults_.silent || faults_.power_off) return;
  const bool broken = std::exchange(faults_.garbage, false);
  if (broken) text.resize(text.size() / 2);
  const auto [went, packets] = socket_.send({text.begin(), text.end()}, faults_);
  packets_ += static_cast<std::uint64_t>(packets);
  if (packets > 0) sent_clock_ = machine_.ipoc();
  unanswered_ = wire::unanswered(went, unanswered_, packets, broken);
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
