#include "drivers/franka/far_fci.hpp"

#include <algorithm>

namespace polyarm::franka {

void FarFci::listen(const std::string& address, int port) {
  door_.listen(address, port);
  socket_.open(address);
}

FarFci::Client* FarFci::session() {
  for (const auto& client : door_.clients())
    if (client->connected && !client->gone) return client.get();
  return nullptr;
}

bool FarFci::reply(Client& client, const Frame& frame, Data data) {
  if (faults_.mute || faults_.power_off) return true;
  Data bytes = encode(Frame{frame.command, frame.id, std::move(data)});
  if (std::exchange(faults_.bad_reply, false)) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0xEE});
  return wire::send_frame(client.socket.number(), bytes);
}

bool FarFci::connect(Client& client, const Frame& frame) {
  if (frame.data.size() != 4 || client.connected) return false;
  const int version = frame.data[0] | frame.data[1] << 8, port = frame.data[2] | frame.data[3] << 8;
  const bool fits = version == spoken();
  Data data{static_cast<std::uint8_t>(fits ? 0 : 1), static_cast<std::uint8_t>(spoken()),
            static_cast<std::uint8_t>(spoken() >> 8)};
  if (!fits) return reply(client, frame, std::move(data));
  const auto target = wire::udp_address(wire::peer_address(client.socket.number()), port);
  if (session() || !target) return false;  // it takes one client
  if (!reply(client, frame, std::move(data))) return false;
  if (has_session_) machine_.leave();  // of a client that is gone
  socket_.send_to(*target);
  client.connected = has_session_ = true;
  answers_ = false;
  unanswered_ = 0;
  socket_.clear();
  return true;
}

/// False: the connection is of no use.
bool FarFci::take(Client& client, const Frame& frame) {
  ++requests_;
  if (frame.command == 0) return connect(client, frame);
  const auto request = request_of(frame.command, machine_.version());
  if (!client.connected || !request) return false;
  const Machine::Answer answer = machine_.answer(*request, frame.data, frame.id);
  Data data{byte_of(answer.status, *request, machine_.version())};
  if (*request == Request::get_cartesian_limit) data.resize(1 + 24 + 128 + 1);
  if (!reply(client, frame, std::move(data))) return false;
  report_end();  // of a motion that was stopped
  return true;
}

/// The second reply to the request of a motion.
void FarFci::report_end() {
  const auto end = machine_.take_end();
  Client* const client = session();
  if (!end || !client) return;
  const auto command = number_of(Request::move, machine_.version());
  reply(*client, Frame{*command, end->first, {}}, {byte_of(end->second, Request::move, machine_.version())});
}

void FarFci::take_commands() {
  socket_.receive<1024>([this](Bytes bytes) {
    if (faults_.power_off || !has_session_) return;
    const auto command = decode_command(bytes, machine_.version());
    if (!command) return;
    // The clock waits for an answer that is not taken, too.
    if (command->id == newest_) unanswered_ = 0;
    answers_ = true;
    if (faults_.deaf) return;
    if (faults_.drop > 0 && faults_.drop-- > 0) return;
    ++taken_;
    machine_.take(*command);
  });
}

void FarFci::serve() {
  door_.serve([this](Client& client) { client.gone = faults_.busy || faults_.power_off; },
              [this](Client& client, Bytes bytes) {
                if (!client.reader.feed(bytes)) return false;
                while (const auto frame = client.reader.next())
                  if (!take(client, *frame)) return false;
                return true;
              });
  take_commands();
  report_end();
  if (has_session_ && !session()) {
    has_session_ = answers_ = false;
    unanswered_ = 0;
    machine_.leave();
  }
}

void FarFci::cycle() {
  machine_.step();
  report_end();
  send_state();
}

void FarFci::send_state() {
  if (!has_session_ || faults_.silent || faults_.power_off) return;
  RobotState now = machine_.state();
  if (std::exchange(faults_.not_a_number, false)) now.q[3] = std::nan("");
  Data state = encode(now, machine_.version());
  if (std::exchange(faults_.garbage, false)) state.resize(state.size() / 2);
  const int packets = socket_.send(std::move(state), faults_).packets;
  if (packets == 0) return;
  sent_ += static_cast<std::uint64_t>(packets);
  newest_ = machine_.id();
  if (machine_.moves()) unanswered_ = 1;
}

void FarFci::descriptors(std::vector<int>& out) {
  out.push_back(door_.listener());
  out.push_back(socket_.descriptor());
  for (const auto& client : door_.clients()) out.push_back(client->socket.number());
}

}  // namespace polyarm::franka
