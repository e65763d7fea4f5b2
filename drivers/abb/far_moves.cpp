#include "drivers/abb/far_moves.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "drivers/wire/six_axes.hpp"

namespace polyarm::abb {

using wire::scaled;

namespace {

constexpr double kSpeedUp = 0.2;    // s, of a joint to its full speed
constexpr double kPathSpeed = 7;    // m/s
constexpr double kClientLeft = 60;  // s without a request, until a client without a session is dropped
constexpr int kUnreachable = 1074;  // our number of an error that a move ends with
constexpr std::size_t kMostBytes = 64 * kMoveRequestBytes;

forward::PlayedArm arm_of(Machine& machine, int& ended, std::function<void()> refuse) {
  forward::PlayedArm out = forward::arm_in_degrees(machine, ended, kSpeedUp);
  out.q = [&machine, q = Six{}]() mutable -> const Six& { return q = scaled(machine.q(), wire::kRadians); };
  out.refuse = std::move(refuse);
  return out;
}

forward::PlayedMove played(const RapidMove& move, int number) {
  using Kind = hardware::ForwardMove::Kind;
  forward::PlayedMove out;
  out.number = number;
  out.blend = move.zone / 1000;
  if (move.kind == RapidMove::joints) {
    for (std::size_t i = 0; i < 6; ++i) out.goal[i] = move.end[i] * wire::kRadians;
    out.joint_time = std::max(move.time, 0.02);
    out.acceleration = std::clamp(move.acceleration, 20.0, 100.0) / 100;
    return out;
  }
  out.kind = move.kind == RapidMove::line ? Kind::line : Kind::arc;
  out.end = pose_of(move.end);
  out.via_point = Vec3{move.via[0] / 1000, move.via[1] / 1000, move.via[2] / 1000};
  out.speed = std::clamp(move.speed / 1000, 1e-3, kPathSpeed);
  out.acceleration = std::max(move.acceleration, 0.1);
  if (move.turn < kFullTurn) out.turn = std::max(move.turn, 1e-2) * wire::kRadians;
  return out;
}

}  // namespace

FarMoves::FarMoves(Machine& machine, const MoveFaults& faults)
    : machine_(machine),
      faults_(faults),
      player_(arm_of(machine, ended_, [this] { fail(); }), kMoveSlots + 2) {}

void FarMoves::fail() {
  error_ = kUnreachable;
  stop(false);
}

void FarMoves::stop(bool closing) {
  player_.forget();
  if (!std::exchange(stopping_, true)) machine_.brake_moves();
  closing_ = closing_ || closing;
}

void FarMoves::finish() {
  if (!faults_.confirms_not) halted_ = halt_;
  if (std::exchange(closing_, false)) session_ = 0;
  stopping_ = false;
  machine_.end_cycle();  // as ExitCycle
}

void FarMoves::leave() {
  if (session_ > 0) stop(true);
}

void FarMoves::restart() {
  player_.forget();
  session_ = 0;
  stopping_ = closing_ = false;
}

MoveResult FarMoves::begin(int watchdog_ms) {
  if (session_ > 0 || stopping_) return MoveResult::busy;
  player_.forget();
  player_.set_tool({});
  session_ = ++sessions_;
  ended_ = halt_ = halted_ = error_ = 0;
  pace_ = 100;
  watchdog_ = watchdog_ms / 1000.0;
  return MoveResult::done;
}

MoveResult FarMoves::take(const MoveRequest& request) {
  if (stopping_ || error_ != 0) return MoveResult::no_session;
  if (request.move.kind == RapidMove::none) return MoveResult::unknown;
  if (faults_.refuse) return MoveResult::full;
  if (faults_.fails) return fail(), MoveResult::done;
  return player_.take(played(request.move, request.number)) ? MoveResult::done : MoveResult::full;
}

MoveResult FarMoves::result_of(const MoveRequest& request) {
  if (request.what == MoveDo::state) return MoveResult::done;
  if (request.what == MoveDo::begin) return begin(request.value);
  if (request.what == MoveDo::end) {
    if (session_ > 0) stop(true);
    return MoveResult::done;
  }
  if (!is_open() || request.value != session_) return MoveResult::no_session;
  switch (request.what) {
    case MoveDo::move:
      return take(request);
    case MoveDo::halt:
      halt_ = request.number;
      stop(false);
      return MoveResult::done;
    case MoveDo::tool:
      player_.set_tool(pose_of(request.move.end));
      load_ = request.load;
      return MoveResult::done;
    case MoveDo::pace:
      pace_ = std::clamp(request.number, 0, 100);
      return MoveResult::done;
    default:
      return MoveResult::unknown;
  }
}

MoveReply FarMoves::carry_out(const MoveRequest& request) {
  silence_ = 0;
  MoveReply out;
  out.id = request.id;
  out.result = faults_.other_version ? MoveResult::version : result_of(request);
  out.version = kMovesVersion + (faults_.other_version ? 1 : 0);
  out.session = session_;
  out.ended = ended_;
  out.halted = halted_;
  out.time_ms = static_cast<int>(std::llround(1000 * time_) % kMovesClock);
  out.error = error_;
  out.pace = pace_;
  out.joints = machine_.q();
  out.flange = frame_of(machine_.tool0());
  if (faults_.other_base) out.flange[2] += 250;
  return out;
}

/// While the program is stopped, nothing of it is done; its clocks go on.
void FarMoves::step(double dt) {
  time_ += dt;
  silence_ += dt;
  if (!machine_.may_move()) return player_.interrupt();
  if (session_ > 0 && silence_ > watchdog_) leave();
  if (stopping_) {
    if (machine_.still()) finish();
    return;
  }
  player_.change_pace(pace_ / 100.0, dt);
  player_.step(dt);
}

// --- the port -------------------------------------------------------------------------------------------

void FarMovePort::descriptors(std::vector<int>& out) {
  out.push_back(door_.listener());
  for (const auto& client : door_.clients()) out.push_back(client->socket.number());
}

void FarMovePort::drop() {
  door_.drop_all();
  moves_.leave();
}

/// The others wait until it is gone.
bool FarMovePort::is_first(const Client& client) {
  for (const auto& one : door_.clients())
    if (!one->gone) return one.get() == &client;
  return false;
}

/// False: the connection is of no use.
bool FarMovePort::take(Client& client) {
  while (client.bytes.size() >= kMoveRequestBytes) {
    if (faults_.slow_stop && moves_.slows_down()) return true;
    const auto request = decode_move_request(wire::Bytes(client.bytes).first(kMoveRequestBytes));
    client.bytes.erase(client.bytes.begin(), client.bytes.begin() + kMoveRequestBytes);
    if (!request) return false;
    ++requests_;
    MoveReply reply = moves_.carry_out(*request);
    if (faults_.mute) continue;
    std::vector<std::uint8_t> bytes = encode(reply);
    if (faults_.nonsense) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0xFF});
    if (!wire::send_frame(client.socket.number(), bytes)) return false;
  }
  return true;
}

/// A program that does not run reads nothing: what came waits.
void FarMovePort::serve() {
  door_.serve([](Client&) {},
              [](Client& client, wire::Bytes bytes) {
                client.bytes.insert(client.bytes.end(), bytes.begin(), bytes.end());
                return client.bytes.size() <= kMostBytes;
              });
  follow_program();
  if (!machine_.may_move()) return;
  for (const auto& client : door_.clients())
    if (is_first(*client)) client->gone = !take(*client);
  door_.drop_gone();
  if (door_.clients().empty()) moves_.leave();
}

void FarMovePort::follow_program() {
  if (machine_.starts() == starts_) return;
  starts_ = machine_.starts();
  moves_.restart();
}

void FarMovePort::step(double dt) {
  follow_program();
  moves_.step(dt);
}

}  // namespace polyarm::abb
