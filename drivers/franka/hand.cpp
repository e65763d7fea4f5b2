#include "drivers/franka/hand.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "drivers/wire/ordered_bytes.hpp"
#include "drivers/wire/udp.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::franka {

namespace {

using wire::ByteOrder;
using wire::OrderedReader;
using wire::OrderedWriter;

constexpr Nanoseconds kMotion = 30'000'000'000;  // for homing, the longest of them
constexpr double kEmpty = 0.001;                 // m: fingers that are closer hold nothing

const char* words_of(HandRequest what) {
  switch (what) {
    case HandRequest::homing:
      return "find its range";
    case HandRequest::grasp:
      return "grasp";
    case HandRequest::move:
      return "move";
    default:
      return "stop";
  }
}

}  // namespace

HandWish::HandWish() noexcept {
  grip = width = homing = std::numeric_limits<double>::quiet_NaN();
}

Data encode(const HandState& state) {
  OrderedWriter out(ByteOrder::little);
  out.u32(state.id).f64(state.width).f64(state.max_width).u8(state.grasped);
  out.u16(static_cast<std::uint64_t>(state.temperature));
  return out.bytes();
}

std::optional<HandState> decode_hand_state(Bytes data) {
  if (data.size() != kHandState) return std::nullopt;
  OrderedReader in(data, ByteOrder::little);
  HandState out;
  out.id = in.u32();
  out.width = in.f64();
  out.max_width = in.f64();
  out.grasped = in.u8() != 0;
  out.temperature = in.u16();
  if (!std::isfinite(out.width) || !std::isfinite(out.max_width)) return std::nullopt;
  return out;
}

Data encode(const HandOrder& order) {
  OrderedWriter out(ByteOrder::little);
  if (order.what == HandRequest::grasp)
    out.f64(order.width).f64(order.inner).f64(order.outer).f64(order.speed).f64(order.force);
  if (order.what == HandRequest::move) out.f64(order.width).f64(order.speed);
  return out.bytes();
}

std::optional<HandOrder> decode_hand_order(std::uint32_t command, Bytes data) {
  if (command > static_cast<std::uint32_t>(HandRequest::stop)) return std::nullopt;
  HandOrder out;
  out.what = static_cast<HandRequest>(command);
  std::array<double, 5> all{};
  if (out.what == HandRequest::grasp) {
    if (!read_numbers(data, all)) return std::nullopt;
    out.width = all[0], out.inner = all[1], out.outer = all[2], out.speed = all[3], out.force = all[4];
    return out;
  }
  if (out.what == HandRequest::move) {
    if (!read_numbers(data, std::span(all).first(2))) return std::nullopt;
    out.width = all[0], out.speed = all[1];
    return out;
  }
  if (!data.empty()) return std::nullopt;
  return out;
}

// --- the driver's end -------------------------------------------------------------------------------------

bool Hand::refuse(Cause cause, int detail, const std::string& text) {
  refusal_ = {cause, detail, text};
  return false;
}

bool Hand::refuse_port() {
  const Port::Failure& failure = port_.failure();
  if (failure.cause == Cause::unreachable) return refuse(Cause::hand_unreachable, 0, failure.text);
  if (failure.cause == Cause::bad_data) return refuse(Cause::bad_data);
  return refuse(Cause::hand_silent);
}

bool Hand::open(Nanoseconds timeout) {
  close();
  refusal_ = {};
  if (!port_.open(timeout)) return refuse_port();
  in_addr peer{};
  ::inet_pton(AF_INET, port_.peer_address().c_str(), &peer);
  robot_host_ = peer.s_addr;
  std::string why;
  states_ = wire::bind_udp(port_.own_address(), 0, why);
  if (!states_) return refuse(Cause::hand_unreachable, 0, why);
  const int udp = wire::local_port(states_.number());
  OrderedWriter data(ByteOrder::little);
  data.u16(kHandVersion).u16(static_cast<std::uint64_t>(udp));
  const auto reply = port_.ask(static_cast<std::uint32_t>(HandRequest::connect), data.bytes(), timeout);
  if (!reply) return refuse_port();
  if (reply->data.size() != 4) return refuse(Cause::bad_data);
  if (reply->data[0] != 0) return refuse(Cause::hand_version, reply->data[2] | reply->data[3] << 8);
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  while (take() && !seen_) {
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0) return refuse(Cause::hand_silent);
    wire::wait_readable(states_.number(), left);
  }
  return seen_;
}

void Hand::close() {
  port_.close();
  states_ = Descriptor();
  seen_ = false;
  asked_.reset();
  stop_.reset();
  forget();
}

/// States and replies that have come.
bool Hand::take() {
  std::array<std::uint8_t, 64> bytes;
  wire::UdpAddress from;
  for (int i = 0; i < 64; ++i) {
    const wire::Received got = wire::receive_datagram(states_.number(), bytes, &from);
    if (got.got != wire::Got::bytes) break;
    if (from.host != robot_host_) continue;
    const auto state = decode_hand_state(Bytes(bytes).first(got.count));
    if (!state) return refuse(Cause::bad_data);
    // Behind a later one; the difference also holds when the 32 bits overflow.
    if (seen_ && static_cast<std::int32_t>(state->id - state_.id) < 0) continue;
    state_ = *state;
    seen_ = true;
    heard_at_ = realtime::monotonic_now();
  }
  if (!port_.receive()) return refuse_port();
  while (const auto frame = port_.next())
    if (!take_reply(*frame)) return false;
  return true;
}

bool Hand::take_reply(const Frame& frame) {
  if (frame.data.size() < 2) return refuse(Cause::bad_data);
  if (stop_ && frame.id == *stop_) {
    stop_.reset();
    return true;
  }
  if (!asked_ || frame.id != asked_->id) return true;
  const auto status = static_cast<HandStatus>(frame.data[0] | frame.data[1] << 8);
  const Asked asked = *asked_;
  asked_.reset();
  const bool well = status == HandStatus::success || status == HandStatus::unsuccessful || asked.stopped;
  return well || refuse(Cause::hand_failed, static_cast<int>(status), words_of(asked.what));
}

/// What changed last is wanted; a value that is NaN wants nothing.
std::optional<HandOrder> Hand::next_order() {
  const auto changed = [](double wanted, double& done) {
    if (!std::isfinite(wanted) || wanted == done) return false;
    done = wanted;
    return true;
  };
  const double most = state_.max_width > 0 ? state_.max_width : settings_.open_width;
  HandOrder out;
  out.speed = settings_.speed;
  if (changed(wanted_.homing, done_.homing) && wanted_.homing > 0.5) {
    out.what = HandRequest::homing;
    return out;
  }
  if (changed(wanted_.grip, done_.grip)) {
    done_.width = wanted_.width;  // a width that was wanted before is done with
    out.what = wanted_.grip > 0.5 ? HandRequest::grasp : HandRequest::move;
    out.width = wanted_.grip > 0.5 ? most / 2 : std::min(settings_.open_width, most);
    out.force = settings_.force;
    out.inner = most / 2 - kEmpty;
    out.outer = most / 2;
    return out;
  }
  if (!changed(wanted_.width, done_.width)) return std::nullopt;
  out.what = HandRequest::move;
  out.width = std::clamp(wanted_.width, 0.0, most);
  return out;
}

bool Hand::order(const HandOrder& order, Nanoseconds now) {
  const auto id = port_.send(static_cast<std::uint32_t>(order.what), encode(order));
  if (!id) return refuse(Cause::hand_silent);
  if (order.what == HandRequest::stop)
    stop_ = id;
  else
    asked_ = Asked{*id, order.what, false};
  asked_at_ = now;
  return true;
}

bool Hand::serve(const HandWish& wish, Nanoseconds now, Nanoseconds timeout) {
  if (refusal_.cause != Cause::none || !take()) return false;
  wanted_ = wish;
  if (now - heard_at_ > timeout) return refuse(Cause::hand_silent);
  const bool waits = asked_ || stop_;
  if (waits && now - asked_at_ > (stop_ ? timeout : kMotion)) return refuse(Cause::hand_silent);
  if (stop_) return true;
  if (asked_) {
    const HandWish before = done_;
    const bool other = next_order().has_value();
    done_ = before;  // it is ordered once the hand has stopped
    if (!other || asked_->stopped) return true;
    asked_->stopped = true;
    return order({HandRequest::stop}, now);
  }
  const auto next = next_order();
  return !next || order(*next, now);
}

void Hand::await_state(std::uint32_t id, Nanoseconds timeout) {
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  while (take() && state_.id < id) {
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0) return;
    wire::wait_readable(states_.number(), left);
  }
}

}  // namespace polyarm::franka
