/// MotoROS of the simulated controller.
#include <algorithm>

#include "drivers/yaskawa/far_services.hpp"

namespace polyarm::yaskawa {

namespace {

constexpr double kStartTimeout = 5;  // s, as in MotoROS
constexpr std::uint32_t kOutputs = 10000, kOutputGroups = 1000;
constexpr std::size_t kMostKept = 1 << 16;

/// 10, 11 … 17, 20 …: the address of a bit; its number from 1. 0: none of the general signals.
int number_of(std::uint64_t address) {
  constexpr std::uint64_t kLast = 10 * (kMostSignals / 8) + 7;
  if (address < 10 || address > kLast || address % 10 > 7) return 0;
  return static_cast<int>((address / 10 - 1) * 8 + address % 10 + 1);
}

}  // namespace

void FarMoto::listen(const std::string& address, int motion, int state, int io) {
  motion_.listen(address, motion);
  state_.listen(address, state);
  io_.listen(address, io);
}

void FarMoto::descriptors(std::vector<int>& out) {
  for (auto* service : {&motion_, &state_, &io_}) {
    out.push_back(service->listener());
    for (const auto& client : service->clients()) out.push_back(client->socket.number());
  }
}

void FarMoto::drop_all() {
  for (auto* service : {&motion_, &state_, &io_}) service->drop_all();
}

/// One client may move the robot. A new one is closed while the robot moves, else the old one is.
void FarMoto::admit(Client& client) {
  client.reader = MotoReader(order_);
  if (faults_.power_off) client.gone = true;
}

void FarMoto::serve() {
  const auto admit_alone = [this](Client& client) {
    admit(client);
    if (faults_.other_client || (motion_.clients().size() > 1 && machine_.queued() > 0))
      client.gone = true;
    else
      for (auto& other : motion_.clients())
        if (other.get() != &client) other->gone = true;
  };
  motion_.serve(admit_alone, [this](Client& client, Bytes bytes) { return take_motion(client, bytes); });
  state_.serve([this](Client& client) { admit(client); }, [](Client&, Bytes) { return true; });
  io_.serve([this](Client& client) { admit(client); },
            [this](Client& client, Bytes bytes) { return take_io(client, bytes); });
}

void FarMoto::cycle() {
  const bool moved = !motion_.clients().empty();
  machine_.step();
  finish_starts();
  if (!moved) machine_.stop_motion();  // MotoROS ends its task of motion with the connection
  if (++since_state_ < state_cycles_) return;
  since_state_ = 0;
  if (faults_.silent || faults_.power_off) return;
  for (auto& client : state_.clients()) send_state(*client);
}

void FarMoto::send_state(Client& client) {
  MotoFeedback feedback = machine_.feedback();
  if (faults_.other_group) feedback.group = machine_.options().group + 1;
  auto bytes = encode(feedback, order_);
  if (std::exchange(faults_.nonsense, false)) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0xEE});
  const auto status = encode(machine_.status(), order_);
  bytes.insert(bytes.end(), status.begin(), status.end());
  client.kept.append(bytes.begin(), bytes.end());
  ++client.states;
  if (faults_.late > 0 && client.kept.size() < kMostKept) {
    --faults_.late;
    return;
  }
  const std::string out = std::exchange(client.kept, {});
  if (!wire::send_frame(client.socket.number(), out)) client.gone = true;
  ++states_;
  newest_ = client.states;
}

bool FarMoto::send(Client& client, std::span<const std::uint8_t> bytes) {
  return wire::send_frame(client.socket.number(), bytes);
}

bool FarMoto::reply(Client& client, const MotoReply& what) {
  if (faults_.mute) return true;
  auto bytes = encode(what, order_);
  if (std::exchange(faults_.bad_answer, false)) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0xEE});
  return send(client, bytes);
}

bool FarMoto::take_motion(Client& client, Bytes bytes) {
  if (faults_.power_off || !client.reader.feed(bytes)) return false;
  while (const auto message = client.reader.next()) {
    ++requests_;
    if (!answer_motion(client, *message)) return false;
  }
  return true;
}

bool FarMoto::answer_motion(Client& client, const Message& m) {
  const auto points =
      m.type == MotoType::point ? decode_point(m, order_).has_value() : m.type == MotoType::point_ex;
  if (m.type == MotoType::ping) return send(client, encode(Message{m.type, MotoComm::reply, 1, {}}, order_));
  if (m.type == MotoType::control) {
    const auto what = decode_control(m, order_);
    if (what) return control(client, *what);
  } else if (points) {
    const auto several = decode_points(m, order_);
    std::vector<MotoPoint> all = several.value_or(std::vector<MotoPoint>{});
    if (m.type == MotoType::point) all.push_back(*decode_point(m, order_));
    for (const MotoPoint& point : all) {
      if (all.size() > 1 && point.group != machine_.options().group) continue;
      const Machine::Answer answer = machine_.take(point);
      return reply(client,
                   {point.group, point.sequence, static_cast<int>(m.type), answer.result, answer.subcode});
    }
  }
  const bool known = m.type == MotoType::control || m.type == MotoType::point || m.type == MotoType::point_ex;
  const Invalid why = known ? Invalid::message_size : Invalid::message_type;
  return reply(client, {-1, -1, static_cast<int>(m.type), MotoResult::invalid, static_cast<int>(why)});
}

bool FarMoto::control(Client& client, const MotoControl& c) {
  MotoReply out{c.group, c.sequence, static_cast<int>(c.command), MotoResult::success, 0};
  const auto result = [&](bool well) { out.result = well ? MotoResult::success : MotoResult::failure; };
  switch (c.command) {
    case MotoCommand::check_ready:
      result(machine_.ready());
      if (!machine_.ready()) out.subcode = machine_.not_ready();
      break;
    case MotoCommand::check_queue:
      result(c.group == machine_.options().group);
      out.subcode = c.group == machine_.options().group ? machine_.queued() : -1;
      break;
    case MotoCommand::stop_motion:
      result(machine_.stop_motion());
      break;
    case MotoCommand::start_servos:
      result(machine_.servo(true));
      break;
    case MotoCommand::stop_servos:
      result(machine_.servo(false));
      break;
    case MotoCommand::reset_alarm:
      result(machine_.reset());
      break;
    case MotoCommand::start_trajectory:
      if (machine_.start_trajectory()) {
        client.starts = c;
        client.waited = 0;
        return true;
      }
      out.result = MotoResult::not_ready;
      out.subcode = machine_.not_ready();
      break;
    case MotoCommand::stop_trajectory:
    case MotoCommand::disconnect:
      result(machine_.stop_trajectory());
      if (c.command == MotoCommand::disconnect && out.result == MotoResult::success) {
        reply(client, out);
        return false;
      }
      break;
    default:
      out.result = MotoResult::invalid;
      out.subcode = static_cast<int>(Invalid::command);
  }
  return reply(client, out);
}

/// The answer to a start goes out when the job waits for MotoROS, or after its time.
void FarMoto::finish_starts() {
  for (auto& client : motion_.clients()) {
    if (!client->starts) continue;
    client->waited += machine_.period();
    if (!machine_.ready() && machine_.starting() && client->waited < kStartTimeout) continue;
    if (!machine_.ready() && client->waited < 2 * machine_.options().begin) continue;
    const MotoControl c = *std::exchange(client->starts, {});
    MotoReply out{c.group, c.sequence, static_cast<int>(c.command), MotoResult::success, 0};
    if (!machine_.ready()) {
      out.result = MotoResult::not_ready;
      out.subcode = machine_.not_ready();
    }
    if (!reply(*client, out)) client->gone = true;
  }
}

// --- signals ----------------------------------------------------------------------------------------------

bool FarMoto::take_io(Client& client, Bytes bytes) {
  if (faults_.power_off || !client.reader.feed(bytes)) return false;
  while (const auto message = client.reader.next())
    if (!answer_io(client, *message)) return false;
  return true;
}

bool FarMoto::answer_io(Client& client, const Message& m) {
  if (faults_.io_mute) return true;
  const bool writes = m.type == MotoType::write_bit || m.type == MotoType::write_group;
  const bool group = m.type == MotoType::read_group || m.type == MotoType::write_group;
  const bool bit = m.type == MotoType::read_bit || m.type == MotoType::write_bit;
  const auto body = read_words(m, writes ? 2 : 1, order_);
  if (!(group || bit) || !body) {
    const Invalid why = group || bit ? Invalid::message_size : Invalid::message_type;
    const auto out =
        words({static_cast<std::uint32_t>(MotoResult::invalid), static_cast<std::uint32_t>(why)}, order_);
    send(client, encode(Message{MotoType::reply, MotoComm::reply, 1, out}, order_));
    return group || bit;
  }
  const auto [address, value] = *body;
  const std::uint32_t outputs = group ? kOutputGroups : kOutputs;
  const bool is_output = address >= outputs;
  const std::uint32_t own = is_output ? address - outputs : address;
  const int first = number_of(group ? std::uint64_t{own} * 10 : own), count = group ? 8 : 1;
  IoResult result = IoResult::ok;
  std::uint32_t read = 0;
  if (first == 0 || (writes && !is_output) || (writes && faults_.locked_outputs))
    result = writes ? IoResult::write_address : IoResult::read_address;
  else if (writes && value > (group ? 255u : 1u))
    result = IoResult::write_value;
  else
    for (int i = 0; i < count; ++i) {
      if (writes) machine_.set_output(first + i, value >> i & 1);
      const bool on = is_output ? machine_.output(first + i) : machine_.input(first + i);
      read |= (on ? 1u : 0u) << i;
    }
  const auto code = static_cast<std::uint32_t>(result);
  const auto out = writes ? words({code}, order_) : words({read, code}, order_);
  const auto type = static_cast<MotoType>(static_cast<int>(m.type) + 1);
  return send(client, encode(Message{type, MotoComm::reply, result == IoResult::ok ? 1 : 2, out}, order_));
}

}  // namespace polyarm::yaskawa
