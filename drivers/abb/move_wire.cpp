#include "drivers/abb/move_wire.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "drivers/wire/tcp.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

using hardware::ForwardMove;

namespace {

constexpr double kFarthest = 1e5;                             // degrees or mm, of a place
constexpr double kFastest = 1e5;                              // mm/s, degrees/s
constexpr double kLeastZone = 0.3, kLeastAcceleration = 0.1;  // mm; m/s², the least of PathAccLim
constexpr double kLeastTime = 0.02;                           // s, of a joint move

/// Big-endian numbers; what is out of range makes the message useless.
class Numbers {
 public:
  explicit Numbers(Bytes bytes) noexcept : in_(bytes) {}
  int whole(int least, int most) noexcept {
    const std::int32_t value = in_.i32();
    fine_ = fine_ && value >= least && value <= most;
    return value;
  }
  double real(double least, double most) noexcept {
    const double value = in_.f32();
    fine_ = fine_ && value >= least && value <= most;  // false for NaN
    return value;
  }
  template <std::size_t N>
  void reals(std::array<double, N>& out, double most) noexcept {
    for (double& one : out) one = real(-most, most);
  }
  /// The quaternion is a unit one, nearly.
  void frame(Frame& out) noexcept {
    reals(out, kFarthest);
    const double size = std::hypot(std::hypot(out[3], out[4]), std::hypot(out[5], out[6]));
    fine_ = fine_ && std::abs(size - 1) < 1e-3;
  }
  bool fine() const noexcept { return fine_ && in_.ok() && in_.left() == 0; }

 private:
  wire::Reader in_;
  bool fine_ = true;
};

template <std::size_t N>
void put(wire::Writer& out, const std::array<double, N>& values) {
  for (const double value : values) out.f32(static_cast<float>(value));
}

/// s, for the joint that turns most: a trapezoid of speed, or a triangle.
double time_of(const ForwardMove& move, const Six& from, const forward::MoveFrame& frame) {
  const double way = forward::largest_difference(forward::end_of(move), from);
  const auto [speed, acceleration] = forward::joint_speeds(move, from, frame);
  if (!(way > 1e-9) || !std::isfinite(speed) || !std::isfinite(acceleration)) return kLeastTime;
  const double reached = way * acceleration;
  const double time =
      reached > speed * speed ? way / speed + speed / acceleration : 2 * std::sqrt(way / acceleration);
  return std::max(time, kLeastTime);
}

}  // namespace

std::vector<std::uint8_t> encode(const MoveRequest& request) {
  wire::Writer out;
  const RapidMove& m = request.move;
  out.i32(kMovesVersion).i32(request.id).i32(static_cast<int>(request.what));
  out.i32(request.number).i32(request.value).i32(m.kind);
  put(out, m.end);
  put(out, request.what == MoveDo::tool ? request.load.centre : m.via);
  for (const double value : {m.time, m.speed, m.turn, m.acceleration, m.zone, request.load.mass})
    out.f32(static_cast<float>(value));
  return out.bytes();
}

std::optional<MoveRequest> decode_move_request(Bytes bytes) noexcept {
  Numbers in(bytes);
  MoveRequest out;
  RapidMove& m = out.move;
  in.whole(kMovesVersion, kMovesVersion);
  out.id = in.whole(0, kMostWhole);
  out.what = static_cast<MoveDo>(in.whole(0, static_cast<int>(MoveDo::end)));
  out.number = in.whole(0, kMostWhole);
  out.value = in.whole(0, kMostWhole);
  m.kind = static_cast<RapidMove::Kind>(in.whole(RapidMove::none, RapidMove::arc));
  if (m.kind == RapidMove::joints)
    in.reals(m.end, kFarthest);
  else
    in.frame(m.end);
  in.reals(m.via, kFarthest);
  m.time = in.real(0, 3600);
  m.speed = in.real(0, kFastest);
  m.turn = in.real(0, kFastest);
  m.acceleration = in.real(0, kFastest);
  m.zone = in.real(0, kFarthest);
  out.load.mass = in.real(0, 5000);
  if (out.what == MoveDo::tool) out.load.centre = m.via;
  return in.fine() ? std::optional(out) : std::nullopt;
}

std::vector<std::uint8_t> encode(const MoveReply& reply) {
  wire::Writer out;
  for (const int value : {reply.version, reply.id, static_cast<int>(reply.result), reply.session, reply.ended,
                          reply.halted, reply.time_ms, reply.error, reply.pace})
    out.i32(value);
  put(out, reply.joints);
  put(out, reply.flange);
  return out.bytes();
}

std::optional<MoveReply> decode_move_reply(Bytes bytes) noexcept {
  Numbers in(bytes);
  MoveReply out;
  out.version = in.whole(0, 1000);
  out.id = in.whole(0, kMostWhole);
  out.result = static_cast<MoveResult>(in.whole(0, static_cast<int>(MoveResult::busy)));
  out.session = in.whole(0, kMostWhole);
  out.ended = in.whole(0, kMostWhole);
  out.halted = in.whole(0, kMostWhole);
  out.time_ms = in.whole(0, kMovesClock);
  out.error = in.whole(0, kMostWhole);
  out.pace = in.whole(0, 100);
  in.reals(out.joints, 36'000);
  in.frame(out.flange);
  return in.fine() ? std::optional(out) : std::nullopt;
}

// --- moves of the runtime -------------------------------------------------------------------------------

Frame frame_of(const Pose& pose) {
  const auto& [p, r] = std::pair{pose.position, pose.rotation};
  return {1000 * p.x, 1000 * p.y, 1000 * p.z, r.w, r.x, r.y, r.z};
}

Pose pose_of(const Frame& f) {
  return {{f[0] / 1000, f[1] / 1000, f[2] / 1000}, normalized(Quaternion{f[4], f[5], f[6], f[3]})};
}

RapidMove rapid_move(const forward::MoveOrder& order, const forward::MoveFrame& frame) {
  RapidMove out;
  const ForwardMove& move = order.move;
  const double blend = 1000 * forward::blend_of(move, order.from, order.next ? &*order.next : nullptr, frame);
  out.zone = blend < kLeastZone ? 0 : blend;
  if (move.kind == ForwardMove::Kind::joint) {
    out.kind = RapidMove::joints;
    const Six end = forward::end_of(move);
    for (std::size_t i = 0; i < end.size(); ++i) out.end[i] = end[i] * wire::kDegrees;
    out.end[6] = 0;
    out.time = time_of(move, order.from, frame);
    out.acceleration = std::clamp(std::floor(100 * move.acceleration + 1e-3), 20.0, 100.0);
    return out;
  }
  const forward::CartesianWay way = forward::cartesian_way(move, order.from, frame);
  const Pose base = inverse(frame.base);
  out.kind = way.arc ? RapidMove::arc : RapidMove::line;
  out.end = frame_of(base * move.at);
  if (way.arc) {
    // In the middle: MoveC refuses a point that is near one of the ends.
    out.via = {1000 * way.middle.x, 1000 * way.middle.y, 1000 * way.middle.z};
    out.angle = way.angle * wire::kDegrees;
  }
  out.speed = 1000 * std::max(way.speed, 1e-3);
  out.turn = kFullTurn;
  if (!(way.speed > 0)) {  // the TCP only turns
    out.turn = std::max(way.turn, 1e-3) / std::max(move.duration, 0.01) * wire::kDegrees;
    out.speed = 1000;
  }
  out.acceleration = std::max(move.acceleration * frame.line_acceleration, kLeastAcceleration);
  return out;
}

// --- the driver's end -----------------------------------------------------------------------------------

bool MovePort::fail(Cause cause, const std::string& text) {
  failure_ = {cause, text};
  close();
  return false;
}

bool MovePort::open(Nanoseconds timeout) {
  failure_ = {};
  received_.clear();
  std::string why;
  socket_ = wire::connect_tcp(host_, port_, timeout, why);
  return socket_ ? true : fail(Cause::moves_unreachable, why);
}

bool MovePort::send(MoveRequest request) {
  if (!socket_) return failure_.cause != Cause::none ? false : fail(Cause::moves_closed);
  id_ = id_ % kMostWhole + 1;
  request.id = id_;
  return wire::send_frame(socket_.number(), encode(request)) || fail(Cause::moves_closed);
}

/// Answers to earlier requests are passed over.
std::optional<MoveReply> MovePort::await_reply(Nanoseconds timeout) {
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  std::array<std::uint8_t, 1024> buffer;
  while (socket_) {
    while (received_.size() >= kMoveReplyBytes) {
      const auto reply = decode_move_reply(Bytes(received_).first(kMoveReplyBytes));
      received_.erase(received_.begin(), received_.begin() + kMoveReplyBytes);
      if (!reply || reply->id > id_) {
        fail(Cause::moves_bad_data);
        return std::nullopt;
      }
      if (reply->id == id_) return reply;
    }
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0) return std::nullopt;
    if (!wire::wait_readable(socket_.number(), left)) continue;
    const wire::Received got = wire::receive(socket_.number(), buffer);
    if (got.got == wire::Got::nothing) continue;
    if (got.got != wire::Got::bytes) {
      fail(Cause::moves_closed);
      return std::nullopt;
    }
    received_.insert(received_.end(), buffer.begin(),
                     buffer.begin() + static_cast<std::ptrdiff_t>(got.count));
  }
  return std::nullopt;
}

}  // namespace polyarm::abb
