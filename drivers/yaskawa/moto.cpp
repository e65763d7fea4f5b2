#include "drivers/yaskawa/moto.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::yaskawa {

using Reader = wire::OrderedReader;
using Writer = wire::OrderedWriter;

namespace {

constexpr std::size_t kPrefix = 4;

void put(Writer& out, const Ten& values) {
  for (const float value : values) out.f32(value);
}

Ten ten(Reader& in) {
  Ten out;
  for (float& value : out) value = in.f32();
  return out;
}

bool finite(const Ten& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

bool good(const MotoPoint& p) {
  return std::isfinite(p.time) && finite(p.position) && finite(p.velocity);
}

std::vector<std::uint8_t> message(MotoType type, MotoComm comm, std::int32_t reply, const Writer& body,
                                  ByteOrder order) {
  return encode(Message{type, comm, reply, body.bytes()}, order);
}

}  // namespace

std::vector<std::uint8_t> encode(const Message& m, ByteOrder order) {
  Writer out(order);
  out.u32(kLeastMessage + m.body.size()).i32(static_cast<std::int32_t>(m.type));
  out.i32(static_cast<std::int32_t>(m.comm)).i32(m.reply).append(m.body);
  return out.bytes();
}

std::vector<std::uint8_t> encode(const MotoPoint& p, ByteOrder order) {
  Writer out(order);
  out.i32(p.group).i32(p.sequence).i32(p.valid).f32(p.time);
  put(out, p.position);
  put(out, p.velocity);
  put(out, p.acceleration);
  return message(MotoType::point, MotoComm::request, 0, out, order);
}

std::vector<std::uint8_t> encode(const MotoFeedback& f, ByteOrder order) {
  Writer out(order);
  out.i32(f.group).i32(f.valid).f32(f.time);
  put(out, f.position);
  put(out, f.velocity);
  put(out, f.acceleration);
  return message(MotoType::feedback, MotoComm::topic, 0, out, order);
}

std::vector<std::uint8_t> encode(const MotoStatus& s, ByteOrder order) {
  Writer out(order);
  out.i32(s.drives).i32(s.e_stopped).i32(s.alarm_code).i32(s.in_error).i32(s.in_motion).i32(s.mode);
  out.i32(s.motion_possible);
  return message(MotoType::robot_status, MotoComm::topic, 0, out, order);
}

std::vector<std::uint8_t> encode(const MotoControl& c, ByteOrder order) {
  Writer out(order);
  out.i32(c.group).i32(c.sequence).i32(static_cast<std::int32_t>(c.command));
  put(out, {});
  return message(MotoType::control, MotoComm::request, 0, out, order);
}

std::vector<std::uint8_t> encode(const MotoReply& r, ByteOrder order) {
  Writer out(order);
  out.i32(r.group).i32(r.sequence).i32(r.command).i32(static_cast<std::int32_t>(r.result)).i32(r.subcode);
  put(out, {});
  return message(MotoType::reply, MotoComm::reply, 1, out, order);
}

std::optional<MotoPoint> decode_point(const Message& m, ByteOrder order) {
  Reader in(m.body, order);
  MotoPoint out{in.i32(), in.i32(), in.i32(), in.f32(), {}, {}, {}};
  out.position = ten(in);
  out.velocity = ten(in);
  out.acceleration = ten(in);
  if (m.type != MotoType::point || !in.ok() || !good(out)) return std::nullopt;
  return out;
}

std::optional<std::vector<MotoPoint>> decode_points(const Message& m, ByteOrder order) {
  Reader in(m.body, order);
  const std::int32_t groups = in.i32(), sequence = in.i32();
  if (m.type != MotoType::point_ex || groups < 1 || groups > static_cast<int>(kMotoGroups))
    return std::nullopt;
  std::vector<MotoPoint> out;
  for (int i = 0; i < groups; ++i) {
    MotoPoint point{in.i32(), sequence, in.i32(), in.f32(), {}, {}, {}};
    point.position = ten(in);
    point.velocity = ten(in);
    point.acceleration = ten(in);
    if (!in.ok() || !good(point)) return std::nullopt;
    out.push_back(point);
  }
  return out;
}

std::optional<MotoFeedback> decode_feedback(const Message& m, ByteOrder order) {
  Reader in(m.body, order);
  MotoFeedback out{in.i32(), in.i32(), in.f32(), {}, {}, {}};
  out.position = ten(in);
  out.velocity = ten(in);
  out.acceleration = ten(in);
  const bool whole = in.ok() && finite(out.position) && finite(out.velocity);
  if (m.type != MotoType::feedback || !whole) return std::nullopt;
  return out;
}

std::optional<MotoStatus> decode_status(const Message& m, ByteOrder order) {
  Reader in(m.body, order);
  const MotoStatus out{in.i32(), in.i32(), in.i32(), in.i32(), in.i32(), in.i32(), in.i32()};
  if (m.type != MotoType::robot_status || !in.ok()) return std::nullopt;
  return out;
}

std::optional<MotoControl> decode_control(const Message& m, ByteOrder order) {
  Reader in(m.body, order);
  const MotoControl out{in.i32(), in.i32(), static_cast<MotoCommand>(in.i32())};
  if (m.type != MotoType::control || !in.ok()) return std::nullopt;
  return out;
}

std::optional<MotoReply> decode_reply(const Message& m, ByteOrder order) {
  Reader in(m.body, order);
  const MotoReply out{in.i32(), in.i32(), in.i32(), static_cast<MotoResult>(in.i32()), in.i32()};
  if (m.type != MotoType::reply || !in.ok()) return std::nullopt;
  return out;
}

std::vector<std::uint8_t> words(std::initializer_list<std::uint32_t> values, ByteOrder order) {
  Writer out(order);
  for (const std::uint32_t value : values) out.u32(value);
  return out.bytes();
}

std::optional<std::array<std::uint32_t, 2>> read_words(const Message& m, std::size_t count, ByteOrder order) {
  Reader in(m.body, order);
  std::array<std::uint32_t, 2> out{};
  for (std::size_t i = 0; i < count; ++i) out[i] = in.u32();
  if (!in.ok()) return std::nullopt;
  return out;
}

// --- reader -----------------------------------------------------------------------------------------------

std::size_t MotoReader::length() const {
  return Reader(Bytes(buffer_).first(kPrefix), order_.value_or(ByteOrder::little)).u32();
}

/// A length that is small in one order is huge in the other one.
bool MotoReader::find_order() {
  for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
    order_ = order;
    if (length() >= kLeastMessage && length() <= kLongestMessage) return true;
  }
  order_.reset();
  return false;
}

bool MotoReader::feed(Bytes bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  if (buffer_.size() < kPrefix) return true;
  if (!order_ && !find_order()) return false;
  return length() >= kLeastMessage && length() <= kLongestMessage;
}

std::optional<Message> MotoReader::next() {
  if (buffer_.size() < kPrefix || !order_) return std::nullopt;
  const std::size_t size = length();
  if (size < kLeastMessage || size > kLongestMessage || buffer_.size() < kPrefix + size) return std::nullopt;
  Reader in(Bytes(buffer_).subspan(kPrefix, size), *order_);
  Message out{static_cast<MotoType>(in.i32()), static_cast<MotoComm>(in.i32()), in.i32(), {}};
  const Bytes body = in.rest();
  out.body.assign(body.begin(), body.end());
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(kPrefix + size));
  return out;
}

// --- the driver's end -------------------------------------------------------------------------------------

bool MotoPort::fail(Cause cause, const std::string& text) {
  failure_ = {cause, text};
  socket_ = Descriptor();
  return false;
}

bool MotoPort::open(Nanoseconds timeout, std::optional<ByteOrder> order) {
  failure_ = {};
  heard_ = false;
  reader_ = MotoReader(order);
  std::string why;
  socket_ = wire::connect_tcp(host_, port_, timeout, why);
  return socket_ ? true : fail(Cause::unreachable, why);
}

bool MotoPort::send(std::span<const std::uint8_t> bytes) {
  if (!socket_) return false;
  return wire::send_frame(socket_.number(), bytes) || fail(heard_ ? Cause::closed : Cause::other_client);
}

bool MotoPort::receive() {
  if (!socket_) return false;
  std::array<std::uint8_t, 4096> buffer;
  for (int turn = 0; turn < 8; ++turn) {
    const wire::Received got = wire::receive(socket_.number(), buffer);
    if (got.got == wire::Got::nothing) return true;
    if (got.got != wire::Got::bytes) return fail(heard_ ? Cause::closed : Cause::other_client);
    heard_ = true;
    if (!reader_.feed(Bytes(buffer).first(got.count))) return fail(Cause::bad_data);
  }
  return true;
}

std::optional<Message> MotoPort::ask(std::span<const std::uint8_t> bytes, Nanoseconds timeout) {
  failure_ = {};
  if (!socket_) {
    fail(Cause::closed);
    return std::nullopt;
  }
  if (!send(bytes)) return std::nullopt;
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  for (;;) {
    if (!receive()) return std::nullopt;
    if (auto answer = next()) return answer;
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0) break;
    wire::wait_readable(socket_.number(), left);
  }
  fail(Cause::moto_silent);
  return std::nullopt;
}

std::optional<MotoReply> MotoPort::control(MotoCommand command, int group, Nanoseconds timeout) {
  const auto answer = ask(encode(MotoControl{group, ++sequence_, command}, order()), timeout);
  if (!answer) return std::nullopt;
  const auto reply = decode_reply(*answer, order());
  if (!reply) fail(Cause::bad_data);
  return reply;
}

}  // namespace polyarm::yaskawa
