#include "drivers/yaskawa/hses.hpp"

#include <algorithm>

#include "drivers/wire/udp.hpp"
#include "drivers/yaskawa/moto.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::yaskawa {

using wire::ByteOrder;
using Reader = wire::OrderedReader;
using Writer = wire::OrderedWriter;

namespace {

constexpr const char* kMagic = "YERC";
constexpr const char* kReserved = "99999999";
constexpr int kSends = 3;  // of one request, within its timeout
constexpr std::size_t kAlarmTime = 16, kAlarmName = 32;

void head(Writer& out, std::size_t payload, std::uint8_t division, std::uint8_t answer, std::uint8_t id,
          std::uint32_t block) {
  out.text(kMagic).u16(kHsesHeader).u16(payload).u8(3).u8(division).u8(answer).u8(id).u32(block);
  out.text(kReserved);
}

struct Head {
  std::size_t payload = 0;
  std::uint8_t division = 0, answer = 0, id = 0;
  std::uint32_t block = 0;
};

/// Also false if the payload is not as long as it says.
bool read_head(Reader& in, Head& out) {
  const Bytes magic = in.take(4);
  if (!in.ok() || !std::equal(magic.begin(), magic.end(), kMagic)) return false;
  const std::size_t size = in.u16();
  out.payload = in.u16();
  in.u8();
  out.division = in.u8();
  out.answer = in.u8();
  out.id = in.u8();
  out.block = in.u32();
  in.take(8);
  return in.ok() && size == kHsesHeader && out.payload <= kHsesPayload && in.left() == out.payload + 8;
}

std::vector<std::uint8_t> copy(Bytes bytes) {
  return {bytes.begin(), bytes.end()};
}

/// Up to the first 0.
std::string text_of(Bytes bytes) {
  return {bytes.begin(), std::find(bytes.begin(), bytes.end(), 0)};
}

void fixed(Writer& out, std::string text, std::size_t size) {
  text.resize(size, '\0');
  out.text(text);
}

}  // namespace

std::vector<std::uint8_t> encode(const HsesRequest& r) {
  Writer out(ByteOrder::little);
  head(out, r.payload.size(), r.division, 0, r.id, 0);
  out.u16(r.command).u16(r.instance).u8(r.attribute).u8(r.service).u16(0).append(r.payload);
  return out.bytes();
}

std::vector<std::uint8_t> encode(const HsesReply& r) {
  Writer out(ByteOrder::little);
  head(out, r.payload.size(), r.division, 1, r.id, r.block);
  out.u8(r.service | 0x80u).u8(static_cast<std::uint8_t>(r.result)).u8(r.added != 0 ? 1 : 0).u8(0);
  out.u16(r.added).u16(0).append(r.payload);
  return out.bytes();
}

std::optional<HsesRequest> decode_hses_request(Bytes bytes) {
  Reader in(bytes, ByteOrder::little);
  Head head;
  if (!read_head(in, head) || head.answer != 0) return std::nullopt;
  HsesRequest out{head.division, head.id, 0, 0, 0, 0, {}};
  out.command = in.u16();
  out.instance = in.u16();
  out.attribute = in.u8();
  out.service = in.u8();
  in.u16();
  out.payload = copy(in.rest());
  return out;
}

std::optional<HsesReply> decode_hses_reply(Bytes bytes) {
  Reader in(bytes, ByteOrder::little);
  Head head;
  if (!read_head(in, head) || head.answer != 1) return std::nullopt;
  HsesReply out{head.division, head.id, head.block, 0, HsesResult::done, 0, {}};
  out.service = in.u8() & 0x7F;
  out.result = static_cast<HsesResult>(in.u8());
  const int words = in.u8();
  in.u8();
  const std::uint16_t added = in.u16();
  in.u16();
  out.added = words > 0 ? added : 0;
  out.payload = copy(in.rest());
  return out;
}

std::vector<std::uint8_t> encode(const HsesStatus& s) {
  const auto bits = [](std::initializer_list<bool> flags) {
    std::uint32_t out = 0, bit = 1;
    for (const bool flag : flags) out |= flag ? bit : 0, bit <<= 1;
    return out;
  };
  Writer out(ByteOrder::little);
  out.u32(bits({s.step, s.one_cycle, s.continuous, s.running, s.guarded, s.teach, s.play, s.remote}));
  out.u32(bits({false, s.pendant_hold, s.external_hold, s.command_hold, s.alarm, s.error, s.servo}));
  return out.bytes();
}

std::optional<HsesStatus> decode_status(Bytes payload) {
  Reader in(payload, ByteOrder::little);
  const std::uint32_t one = in.u32(), two = in.u32();
  if (!in.ok()) return std::nullopt;
  const auto bit = [](std::uint32_t word, int number) { return (word >> number & 1) != 0; };
  HsesStatus out;
  bool* const first[] = {&out.step,    &out.one_cycle, &out.continuous, &out.running,
                         &out.guarded, &out.teach,     &out.play,       &out.remote};
  for (int i = 0; i < 8; ++i) *first[i] = bit(one, i);
  bool* const second[] = {&out.pendant_hold, &out.external_hold, &out.command_hold,
                          &out.alarm,        &out.error,         &out.servo};
  for (int i = 0; i < 6; ++i) *second[i] = bit(two, i + 1);
  return out;
}

std::vector<std::uint8_t> encode(const HsesAlarm& alarm) {
  Writer out(ByteOrder::little);
  out.u32(alarm.code).u32(alarm.data).u32(alarm.type);
  fixed(out, alarm.time, kAlarmTime);
  fixed(out, alarm.name, kAlarmName);
  return out.bytes();
}

std::optional<HsesAlarm> decode_alarm(Bytes payload) {
  Reader in(payload, ByteOrder::little);
  HsesAlarm out{in.u32(), in.u32(), in.u32(), {}, {}};
  out.time = text_of(in.take(kAlarmTime));
  out.name = text_of(in.take(std::min(kAlarmName, in.left())));  // shorter from some controllers
  if (!in.ok()) return std::nullopt;
  return out;
}

std::vector<std::uint8_t> encode(const HsesPosition& p) {
  Writer out(ByteOrder::little);
  out.u32(p.type).u32(p.form).u32(p.tool).u32(p.user).u32(p.extended);
  for (const std::int32_t value : p.values) out.i32(value);
  return out.bytes();
}

std::optional<HsesPosition> decode_position(Bytes payload) {
  Reader in(payload, ByteOrder::little);
  HsesPosition out{in.u32(), in.u32(), in.u32(), in.u32(), in.u32(), {}};
  for (std::size_t i = 0; i < 6; ++i) out.values[i] = in.i32();
  if (!in.ok()) return std::nullopt;
  for (std::size_t i = 6; i < 8 && in.left() >= 4; ++i) out.values[i] = in.i32();
  return out;
}

bool Hses::open() {
  std::string why;
  socket_ = wire::connect_udp(host_, port_, why);
  if (!socket_) fail(Cause::unreachable, 0, why);
  return static_cast<bool>(socket_);
}

std::nullopt_t Hses::fail(Cause cause, int detail, const std::string& text) {
  failure_ = {cause, detail, text};
  return std::nullopt;
}

std::optional<std::vector<std::uint8_t>> Hses::ask(HsesCommand command, int instance, int attribute,
                                                   HsesService service, Bytes payload) {
  failure_ = {};
  if (!socket_) return fail(Cause::hses_silent);
  HsesRequest request{1,
                      ++id_,
                      static_cast<std::uint16_t>(command),
                      static_cast<std::uint16_t>(instance),
                      static_cast<std::uint8_t>(attribute),
                      static_cast<std::uint8_t>(service),
                      copy(payload)};
  const std::vector<std::uint8_t> bytes = encode(request);
  std::array<std::uint8_t, 2048> buffer;
  for (int send = 0; send < kSends; ++send) {
    wire::send_datagram(socket_.number(), bytes);
    const Nanoseconds deadline = realtime::monotonic_now() + timeout_ / kSends;
    for (;;) {
      const wire::Received got = wire::receive_datagram(socket_.number(), buffer);
      if (got.got == wire::Got::bytes) {
        const auto reply = decode_hses_reply(Bytes(buffer).first(got.count));
        if (!reply) return fail(Cause::hses_bad_data);
        if (reply->id != id_) continue;  // of a request that was sent twice
        if (reply->result == HsesResult::done) return reply->payload;
        return fail(Cause::hses_refused, reply->added != 0 ? reply->added : static_cast<int>(reply->result));
      }
      const Nanoseconds left = deadline - realtime::monotonic_now();
      if (left <= 0) break;
      if (got.got == wire::Got::nothing) wire::wait_readable(socket_.number(), left);
    }
  }
  return fail(Cause::hses_silent);
}

std::optional<HsesStatus> Hses::status() {
  const auto payload = ask(HsesCommand::status, 1, 0, HsesService::get_all);
  if (!payload) return std::nullopt;
  const auto out = decode_status(*payload);
  return out ? out : fail(Cause::hses_bad_data);
}

std::optional<HsesAlarm> Hses::alarm() {
  const auto payload = ask(HsesCommand::alarm, 1, 0, HsesService::get_all);
  if (!payload) return std::nullopt;
  const auto out = decode_alarm(*payload);
  return out ? out : fail(Cause::hses_bad_data);
}

std::optional<HsesPosition> Hses::position(int instance) {
  const auto payload = ask(HsesCommand::position, instance, 0, HsesService::get_all);
  if (!payload) return std::nullopt;
  const auto out = decode_position(*payload);
  return out ? out : fail(Cause::hses_bad_data);
}

std::optional<HsesPosition> Hses::pose() {
  constexpr int kFirstRobotInBase = 101;
  return position(kFirstRobotInBase);
}

std::optional<HsesPosition> Hses::pulses() {
  constexpr int kRobotOne = 1;
  return position(kRobotOne);
}

std::optional<std::vector<std::int32_t>> Hses::doubles(int first, int count) {
  const auto number = static_cast<std::uint32_t>(count);
  const auto payload =
      ask(HsesCommand::double_many, first, 0, HsesService::read_many, words({number}, ByteOrder::little));
  if (!payload) return std::nullopt;
  Reader in(*payload, ByteOrder::little);
  const bool counted = in.u32() == number;
  std::vector<std::int32_t> out;
  for (int i = 0; i < count; ++i) out.push_back(in.i32());
  if (!in.ok() || !counted) return fail(Cause::hses_bad_data);
  return out;
}

bool Hses::set_double(int number, std::int32_t value) {
  return set(HsesCommand::double_integer, number, 1, HsesService::set_one,
             words({static_cast<std::uint32_t>(value)}, ByteOrder::little));
}

bool Hses::set_integer(int number, int value) {
  Writer out(ByteOrder::little);
  out.u16(static_cast<std::uint16_t>(value));
  return set(HsesCommand::integer, number, 1, HsesService::set_one, out.bytes());
}

bool Hses::set_place(int number, const HsesPosition& place) {
  return set(HsesCommand::place, number, 0, HsesService::set_all, encode(place));
}

std::optional<std::uint8_t> Hses::signals(int byte) {
  const auto payload = ask(HsesCommand::io, byte, 1, HsesService::get_one);
  if (!payload) return std::nullopt;
  if (payload->empty()) return fail(Cause::hses_bad_data);
  return payload->front();
}

bool Hses::set_signals(int byte, std::uint8_t value) {
  return set(HsesCommand::io, byte, 1, HsesService::set_one, Bytes(&value, 1));
}

bool Hses::hold(bool on) {
  return set(HsesCommand::power, 1, 1, HsesService::set_one, words({on ? 1u : 2u}, ByteOrder::little));
}

bool Hses::servo(bool on) {
  return set(HsesCommand::power, 2, 1, HsesService::set_one, words({on ? 1u : 2u}, ByteOrder::little));
}

bool Hses::run_continuously() {
  return set(HsesCommand::cycle, 2, 1, HsesService::set_one, words({3}, ByteOrder::little));
}

bool Hses::select_job(const std::string& name) {
  Writer out(ByteOrder::little);
  fixed(out, name, 32);
  out.u32(0);
  return set(HsesCommand::select, 1, 0, HsesService::set_all, out.bytes());
}

bool Hses::start_job() {
  return set(HsesCommand::start, 1, 1, HsesService::set_one, words({1}, ByteOrder::little));
}

std::optional<std::string> Hses::job() {
  const auto payload = ask(HsesCommand::job, 1, 0, HsesService::get_all);
  if (!payload) return std::nullopt;
  if (payload->size() < 32) return fail(Cause::hses_bad_data);
  return text_of(Bytes(*payload).first(32));
}

std::optional<std::array<std::int32_t, 8>> Hses::torque() {
  const auto payload = ask(HsesCommand::torque, 1, 0, HsesService::get_all);
  if (!payload) return std::nullopt;
  Reader in(*payload, ByteOrder::little);
  std::array<std::int32_t, 8> out{};
  for (std::size_t i = 0; i < 6; ++i) out[i] = in.i32();
  if (!in.ok()) return fail(Cause::hses_bad_data);
  return out;
}

std::string Hses::system(int instance, int attribute) {
  const auto payload = ask(HsesCommand::system, instance, attribute, HsesService::get_one);
  return payload ? text_of(*payload) : std::string();
}

}  // namespace polyarm::yaskawa
