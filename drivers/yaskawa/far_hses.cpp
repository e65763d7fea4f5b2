/// The High-Speed Ethernet Server of the simulated controller.
#include <algorithm>
#include <array>

#include "drivers/yaskawa/far_services.hpp"
#include "drivers/yaskawa/inform.hpp"

namespace polyarm::yaskawa {

using Reader = wire::OrderedReader;
using Writer = wire::OrderedWriter;

namespace {

// Added status of refusals.
constexpr std::uint16_t kMoves = 0x2010, kAlarms = 0x2060, kServoOff = 0x2070, kWrongMode = 0x2080,
                        kHolds = 0x2020, kNoOperand = 0x1012, kNoJob = 0x4040, kBusyData = 0x2110,
                        kUndefined = 0xA000;
constexpr int kInputBytes = 1, kOutputBytes = 1001;  // numbers of the first bytes of signals
constexpr int kNetworkBytes = 2701, kNetworkBytesEnd = 2957;
constexpr std::uint32_t kManyDoubles = 118;
constexpr std::uint32_t kOn = 1;
constexpr std::uint16_t kMostVariables = 1000;

HsesReply refuse(HsesReply reply, std::uint16_t added) {
  reply.result = HsesResult::refused;
  reply.added = added;
  return reply;
}

HsesReply with(HsesReply reply, HsesResult result) {
  reply.result = result;
  return reply;
}

HsesReply with(HsesReply reply, std::vector<std::uint8_t> payload) {
  reply.payload = std::move(payload);
  return reply;
}

std::vector<std::uint8_t> values(const std::array<std::int32_t, 8>& all) {
  Writer out(ByteOrder::little);
  for (const std::int32_t one : all) out.i32(one);
  return out.bytes();
}

std::vector<std::uint8_t> fixed(std::string text, std::size_t size) {
  text.resize(size, '\0');
  return {text.begin(), text.end()};
}

/// Bytes of one variable; 0: no such command.
std::size_t size_of(std::uint16_t command) {
  switch (static_cast<HsesCommand>(command)) {
    case HsesCommand::register_:
      return 2;
    case HsesCommand::byte:
      return 1;
    case HsesCommand::integer:
      return 2;
    case HsesCommand::double_integer:
      return 4;
    case HsesCommand::real:
      return 4;
    case HsesCommand::text:
      return 16;
    case HsesCommand::place:
      return 52;
    default:
      return 0;
  }
}

bool is_get(std::uint8_t service) {
  return service == static_cast<std::uint8_t>(HsesService::get_all) ||
         service == static_cast<std::uint8_t>(HsesService::get_one);
}

/// Why the pendant would refuse a job.
std::uint16_t refusal(const HsesStatus& panel) {
  if (panel.alarm || panel.error) return kAlarms;
  if (panel.teach || !panel.remote) return kWrongMode;
  if (panel.holds()) return kHolds;
  return panel.servo ? kMoves : kServoOff;
}

}  // namespace

void FarHses::open(const std::string& address, int port) {
  std::string why;
  socket_ = wire::bind_udp(address, port, why);
  if (!socket_) throw Error("no-port", why, "choose another port, or end the program that uses it");
  port_ = wire::local_port(socket_.number());
}

void FarHses::serve() {
  std::array<std::uint8_t, 1024> bytes;
  wire::UdpAddress from;
  for (int i = 0; i < wire::kReadsInTurn; ++i) {
    const wire::Received got = wire::receive_datagram(socket_.number(), bytes, &from);
    if (got.got != wire::Got::bytes) return;
    const auto request = decode_hses_request(Bytes(bytes).first(got.count));
    if (!request || faults_.power_off || faults_.hses_mute) continue;
    ++requests_;
    auto out = encode(answer(*request));
    if (faults_.hses_lost > 0) {
      --faults_.hses_lost;
      continue;
    }
    if (faults_.hses_nonsense) std::fill(out.begin(), out.end(), std::uint8_t{0xEE});
    wire::send_datagram(socket_.number(), out, from);
    if (faults_.hses_twice) wire::send_datagram(socket_.number(), out, from);
  }
}

HsesReply FarHses::answer(const HsesRequest& r) {
  HsesReply reply{r.division, r.id, kLastBlock, r.service, HsesResult::done, 0, {}};
  if (faults_.hses_refuse) return refuse(reply, kUndefined);
  if (r.division != 1) return with(reply, HsesResult::unknown_command);
  if (r.command >= static_cast<std::uint16_t>(HsesCommand::reset) &&
      r.command <= static_cast<std::uint16_t>(HsesCommand::select))
    return act(r, reply);
  return read(r, reply);
}

HsesReply FarHses::read(const HsesRequest& r, HsesReply reply) {
  switch (static_cast<HsesCommand>(r.command)) {
    case HsesCommand::status:
      return with(reply, encode(machine_.panel()));
    case HsesCommand::alarm:
      if (r.instance < 1 || r.instance > 4) return with(reply, HsesResult::no_instance);
      return with(reply, encode(r.instance == 1 ? machine_.alarm() : HsesAlarm{}));
    case HsesCommand::alarm_history: {
      const std::size_t at = r.instance;
      const bool there = at >= 1 && at <= machine_.history().size();
      return with(reply, encode(there ? machine_.history()[at - 1] : HsesAlarm{}));
    }
    case HsesCommand::job: {
      auto out = fixed(machine_.job(), 32);
      const auto numbers = words({0, 0, 10000}, ByteOrder::little);  // line, step, override in 0.01 %
      out.insert(out.end(), numbers.begin(), numbers.end());
      return with(reply, out);
    }
    case HsesCommand::axis_names: {
      std::vector<std::uint8_t> out;
      for (const char* axis : {"S", "L", "U", "R", "B", "T", "", ""}) {
        const auto one = fixed(axis, 4);
        out.insert(out.end(), one.begin(), one.end());
      }
      return with(reply, out);
    }
    case HsesCommand::position:
      return position(r, reply);
    case HsesCommand::position_error:
      return with(reply, values(machine_.error()));
    case HsesCommand::torque:
      return with(reply, values(machine_.torque()));
    case HsesCommand::io:
      return io(r, reply);
    case HsesCommand::io_many:
      return many_io(r, reply);
    case HsesCommand::double_many:
      return many_doubles(r, reply);
    case HsesCommand::working_time:
      return with(reply, fixed("2026/01/01 08:00", 28));
    case HsesCommand::system:
      return system(r, reply);
    default:
      return variable(r, reply);
  }
}

HsesReply FarHses::position(const HsesRequest& r, HsesReply reply) {
  if (r.instance == 1) return with(reply, encode(machine_.pulses()));
  if (r.instance == 101) return with(reply, encode(machine_.pose()));
  return with(reply, HsesResult::no_instance);
}

/// 11: the first robot, 101: the application; version, model and parameters by attribute.
HsesReply FarHses::system(const HsesRequest& r, HsesReply reply) {
  if (r.instance != 11 && r.instance != 101) return with(reply, HsesResult::no_instance);
  const auto version = fixed(machine_.options().system, 24);
  const auto model = fixed(machine_.options().application, 16);
  const auto parameter = fixed("1.00", 8);
  if (r.attribute == 1) return with(reply, version);
  if (r.attribute == 2) return with(reply, model);
  if (r.attribute == 3) return with(reply, parameter);
  if (r.attribute != 0) return with(reply, HsesResult::wrong_element);
  std::vector<std::uint8_t> all = version;
  all.insert(all.end(), model.begin(), model.end());
  all.insert(all.end(), parameter.begin(), parameter.end());
  return with(reply, all);
}

/// Inputs that a network would set; a request may, too.
HsesReply FarHses::network(const HsesRequest& r, HsesReply reply) {
  const Variables::Key key{r.command, r.instance};
  if (is_get(r.service)) return with(reply, variables_.get(key, 1));
  if (r.payload.empty()) return refuse(reply, kNoOperand);
  variables_.set(key, {r.payload.front()});
  return reply;
}

HsesReply FarHses::io(const HsesRequest& r, HsesReply reply) {
  if (r.instance >= kNetworkBytes && r.instance < kNetworkBytesEnd) return network(r, reply);
  const bool output = r.instance >= kOutputBytes;
  const int first = 8 * (r.instance - (output ? kOutputBytes : kInputBytes)) + 1;
  if (first < 1 || first + 7 > kMostSignals) return with(reply, HsesResult::no_instance);
  if (!is_get(r.service)) return refuse(reply, kNoOperand);  // only network inputs may be written
  std::uint8_t value = 0;
  for (int i = 0; i < 8; ++i)
    if (output ? machine_.output(first + i) : machine_.input(first + i)) value |= 1 << i;
  return with(reply, std::vector<std::uint8_t>{value});
}

HsesReply FarHses::many_io(const HsesRequest& r, HsesReply reply) {
  const std::uint32_t count = Reader(r.payload, ByteOrder::little).u32();
  if (r.service != static_cast<std::uint8_t>(HsesService::read_many)) return refuse(reply, kNoOperand);
  if (count < 1 || count > 474) return refuse(reply, kNoOperand);
  std::vector<std::uint8_t> out = words({count}, ByteOrder::little);
  for (std::uint32_t i = 0; i < count; ++i) {
    HsesRequest one = r;
    one.instance = static_cast<std::uint16_t>(r.instance + i);
    one.service = static_cast<std::uint8_t>(HsesService::get_one);
    const HsesReply answer = io(one, reply);
    if (answer.result != HsesResult::done) return answer;
    out.push_back(answer.payload.front());
  }
  return with(reply, out);
}

HsesReply FarHses::many_doubles(const HsesRequest& r, HsesReply reply) {
  const std::uint32_t count = Reader(r.payload, ByteOrder::little).u32();
  const bool reads = r.service == static_cast<std::uint8_t>(HsesService::read_many);
  if (!reads || count < 1 || count > kManyDoubles || r.instance + count > kMostVariables)
    return refuse(reply, kNoOperand);
  std::vector<std::uint8_t> out = words({count}, ByteOrder::little);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto one = variables_.get(
        {static_cast<std::uint16_t>(HsesCommand::double_integer), static_cast<std::uint16_t>(r.instance + i)},
        4);
    out.insert(out.end(), one.begin(), one.end());
  }
  return with(reply, out);
}

HsesReply FarHses::variable(const HsesRequest& r, HsesReply reply) {
  const std::size_t size = size_of(r.command);
  if (size == 0) return with(reply, HsesResult::unknown_command);
  if (r.instance >= kMostVariables) return with(reply, HsesResult::no_instance);
  const Variables::Key key{r.command, r.instance};
  if (is_get(r.service)) return with(reply, variables_.get(key, size));
  if (r.payload.size() != size) return refuse(reply, kNoOperand);
  if (faults_.locked_places && r.command == static_cast<std::uint16_t>(HsesCommand::place))
    return refuse(reply, kBusyData);
  variables_.set(key, r.payload);
  return reply;
}

HsesReply FarHses::act(const HsesRequest& r, HsesReply reply) {
  Reader in(r.payload, ByteOrder::little);
  const HsesStatus panel = machine_.panel();
  switch (static_cast<HsesCommand>(r.command)) {
    case HsesCommand::reset:
      return machine_.reset() ? reply : refuse(reply, kAlarms);
    case HsesCommand::power: {
      const bool on = in.u32() == kOn;
      if (!in.ok()) return refuse(reply, kNoOperand);
      if (r.instance == 1) machine_.hold(3, on);
      if (r.instance == 2 && !machine_.servo(on)) return refuse(reply, on ? refusal(panel) : kMoves);
      return r.instance >= 1 && r.instance <= 3 ? reply : with(reply, HsesResult::no_instance);
    }
    case HsesCommand::cycle: {
      const std::uint32_t mode = in.u32();
      if (mode < 1 || mode > 3) return refuse(reply, kNoOperand);
      machine_.cycle_mode = static_cast<int>(mode);
      return reply;
    }
    case HsesCommand::message:
      return reply;
    case HsesCommand::start:
      return machine_.start_job() ? reply : refuse(reply, refusal(panel));
    case HsesCommand::select: {
      const Bytes name = in.take(std::min<std::size_t>(32, in.left()));
      const std::string text(name.begin(), std::find(name.begin(), name.end(), 0));
      if (text.empty() || (faults_.no_job && text == kMovesJob)) return refuse(reply, kNoJob);
      return machine_.select_job(text) ? reply : refuse(reply, kMoves);
    }
    default:
      return with(reply, HsesResult::unknown_command);
  }
}

}  // namespace polyarm::yaskawa
