#include "drivers/servo_bus/bus.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::servo_bus {

namespace {
// A late answer arrives within this time after its request has timed out.
constexpr Nanoseconds kSilence = 2'000'000, kLongestSettling = 10'000'000;

Outcome outcome_of(serial::Status status) {
  switch (status) {
    case serial::Status::ok:
      return Outcome::ok;
    case serial::Status::timeout:
      return Outcome::lost;
    case serial::Status::gone:
      return Outcome::gone;
    case serial::Status::failed:
      break;
  }
  return Outcome::failed;
}
}  // namespace

void ServoBus::open(const serial::PortOptions& options, Nanoseconds answer_timeout) {
  port_.close();  // else our own lock would make the port appear in use
  take(serial::Port(options), options.baud, answer_timeout);
}

void ServoBus::take(serial::Port port, int baud, Nanoseconds answer_timeout) noexcept {
  port_ = std::move(port);
  baud_ = baud;
  answer_timeout_ = answer_timeout;
  echo_ = protocol_->echo_looks_like_answer() ? Echo::unknown : Echo::no;
  unsettled_ = false;
  counters_ = {};
}

void ServoBus::set_baud(int baud) {
  port_.set_baud(baud);
  baud_ = baud;
}

Nanoseconds ServoBus::byte_time(std::size_t bytes) const noexcept {
  return static_cast<Nanoseconds>(bytes) * 10'000'000'000 / baud_;
}

/// Waits until the line is silent, so that a late answer is not mistaken for the next one.
void ServoBus::settle() noexcept {
  const Nanoseconds end = realtime::monotonic_now() + kLongestSettling;
  for (Nanoseconds now = end - kLongestSettling; now < end; now = realtime::monotonic_now()) {
    const serial::Transfer late = port_.read(in_, now + kSilence);
    if (!late) break;
    counters_.garbage += late.count;
  }
  unsettled_ = false;
}

std::size_t ServoBus::put_number(std::size_t at, std::uint16_t value) noexcept {
  for (std::size_t i = 0; i < protocol_->address_size(); ++i, value = static_cast<std::uint16_t>(value >> 8))
    parameters_[at++] = static_cast<std::uint8_t>(value);
  return at;
}

Outcome ServoBus::send(std::uint8_t id, Instruction instruction, std::size_t parameters) noexcept {
  if (unsettled_) settle();
  received_ = 0;
  if (const serial::Transfer flushed = port_.flush(); !flushed) return outcome_of(flushed.status);
  sent_ = protocol_->make(out_, id, instruction, Bytes(parameters_).first(parameters));
  if (sent_ == 0) return Outcome::failed;
  const Nanoseconds deadline = realtime::monotonic_now() + byte_time(sent_) + answer_timeout_;
  return outcome_of(port_.write(Bytes(out_).first(sent_), deadline).status);
}

/// Passes answers to `take` until it reports that all have arrived, or until the timeout.
template <typename Take>
Outcome ServoBus::collect(std::size_t longest, std::size_t expected, Take take) noexcept {
  const Nanoseconds deadline = realtime::monotonic_now() + byte_time(2 * sent_ + expected) + answer_timeout_;
  bool echoed = false, late = false;
  // An echo is as long as the instruction, which may be longer than any answer.
  const std::size_t bound = std::max(longest, sent_);
  std::size_t begin = 0;
  for (;;) {
    for (;;) {
      const Found found = protocol_->find(std::span(in_).subspan(begin, received_ - begin), bound);
      counters_.garbage += found.used - found.raw.size();
      begin += found.used;
      if (found.kind == Found::Kind::more) break;
      if (found.kind == Found::Kind::other) continue;
      const bool is_echo = echo_ != Echo::no && !echoed && found.raw.size() == sent_ &&
                           std::memcmp(found.raw.data(), out_.data(), sent_) == 0;
      if (is_echo) {
        echoed = true;
        ++counters_.echoes;
        continue;
      }
      if (!take(found)) continue;
      if (echo_ == Echo::unknown) echo_ = echoed ? Echo::yes : Echo::no;
      return Outcome::ok;
    }
    if (late) {  // a length corrupted to a larger value may hide a complete answer
      if (begin >= received_) break;
      ++begin;
      ++counters_.garbage;
      continue;
    }
    std::memmove(in_.data(), in_.data() + begin, received_ - begin);
    received_ -= std::exchange(begin, 0);
    if (received_ == in_.size()) received_ = 0;  // no answer is that long
    const serial::Transfer got = port_.read(std::span(in_).subspan(received_), deadline);
    received_ += got.count;
    if (got.status == serial::Status::timeout)
      late = true;
    else if (!got)
      return outcome_of(got.status);
    else if (realtime::monotonic_now() > deadline)
      late = true;  // a line that is never silent
  }
  unsettled_ = true;
  ++counters_.lost;
  return Outcome::lost;
}

Outcome ServoBus::receive(std::uint8_t id, std::span<std::uint8_t> into) noexcept {
  return collect(into.size(), into.size() + 12, [&](const Found& found) {
    if (found.id != id || found.data.size() != into.size()) {
      ++counters_.strangers;
      return false;
    }
    std::copy(found.data.begin(), found.data.end(), into.begin());
    return true;
  });
}

Outcome ServoBus::ping(std::uint8_t id) noexcept {
  // Reads one byte: unlike for a ping, its echo never looks like its answer.
  std::uint8_t own = 0;
  return read(id, family_.id.address, std::span(&own, 1));
}

Outcome ServoBus::read(std::uint8_t id, std::uint16_t address, std::span<std::uint8_t> into) noexcept {
  const std::size_t count = put_number(put_number(0, address), static_cast<std::uint16_t>(into.size()));
  if (const Outcome sent = send(id, Instruction::read, count); sent != Outcome::ok) return sent;
  return receive(id, into);
}

Outcome ServoBus::read(std::uint8_t id, const Register& reg, std::int32_t& value) noexcept {
  std::array<std::uint8_t, 4> bytes{};
  const Outcome outcome = read(id, reg.address, std::span(bytes).first(reg.size));
  if (outcome == Outcome::ok) value = decode(reg, bytes);
  return outcome;
}

Outcome ServoBus::write(std::uint8_t id, const Register& reg, std::int32_t value) noexcept {
  const std::size_t at = put_number(0, reg.address);
  encode(reg, value, std::span(parameters_).subspan(at));
  if (const Outcome sent = send(id, Instruction::write, at + reg.size); sent != Outcome::ok) return sent;
  return receive(id, {});
}

Outcome ServoBus::write_checked(std::uint8_t id, const Register& reg, std::int32_t value) noexcept {
  Outcome outcome = Outcome::lost;
  for (int attempt = 0; attempt < 3; ++attempt) {
    outcome = write(id, reg, value);
    if (outcome == Outcome::gone || outcome == Outcome::failed) return outcome;
    std::int32_t is = 0;
    outcome = read(id, reg, is);
    if (outcome == Outcome::ok && is == value) return Outcome::ok;
    if (outcome == Outcome::ok) outcome = Outcome::refused;
  }
  return outcome;
}

Outcome ServoBus::reboot(std::uint8_t id) noexcept {
  return send(id, Instruction::reboot, 0);  // some servos answer and others do not
}

Outcome ServoBus::sync_read(std::span<const std::uint8_t> ids, std::uint16_t address, std::uint16_t length,
                            std::span<std::uint8_t> into, std::span<Reply> replies, bool fast) noexcept {
  std::fill(replies.begin(), replies.end(), Reply{});
  std::size_t at = put_number(put_number(0, address), length);
  for (const std::uint8_t id : ids) parameters_[at++] = id;
  const Instruction instruction = fast ? Instruction::fast_sync_read : Instruction::sync_read;
  if (const Outcome sent = send(kBroadcast, instruction, at); sent != Outcome::ok) return sent;
  if (fast) return collect_fast(ids, length, into, replies);
  std::size_t left = ids.size();
  const Outcome outcome = collect(length, ids.size() * (length + 12u), [&](const Found& found) {
    const auto who = static_cast<std::size_t>(std::find(ids.begin(), ids.end(), found.id) - ids.begin());
    if (who == ids.size() || found.data.size() != length || replies[who].here) {
      ++counters_.strangers;
      return false;
    }
    replies[who] = {true, found.error};
    std::copy(found.data.begin(), found.data.end(), into.begin() + static_cast<std::ptrdiff_t>(who * length));
    return --left == 0;
  });
  return outcome == Outcome::lost ? Outcome::ok : outcome;
}

Outcome ServoBus::collect_fast(std::span<const std::uint8_t> ids, std::uint16_t length,
                               std::span<std::uint8_t> into, std::span<Reply> replies) noexcept {
  struct Target {
    std::span<const std::uint8_t> ids;
    std::uint16_t length;
    std::span<std::uint8_t> into;
    std::span<Reply> replies;
  } target{ids, length, into, replies};
  const auto take = [](void* context, std::uint8_t id, std::uint8_t error, Bytes data) {
    auto& t = *static_cast<Target*>(context);
    const auto who = static_cast<std::size_t>(std::find(t.ids.begin(), t.ids.end(), id) - t.ids.begin());
    if (who == t.ids.size()) return;
    t.replies[who] = {true, error};
    std::copy(data.begin(), data.end(), t.into.begin() + static_cast<std::ptrdiff_t>(who * t.length));
  };
  const std::size_t expected = 8 + ids.size() * (length + 4u);
  const Nanoseconds deadline = realtime::monotonic_now() + byte_time(2 * sent_ + expected) + answer_timeout_;
  for (;;) {
    if (protocol_->split_fast(Bytes(in_).first(received_), ids.size(), length, take, &target))
      return Outcome::ok;
    if (received_ == in_.size()) break;
    const serial::Transfer got = port_.read(std::span(in_).subspan(received_), deadline);
    received_ += got.count;
    if (got.status == serial::Status::timeout) break;
    if (!got) return outcome_of(got.status);
  }
  unsettled_ = true;
  ++counters_.lost;
  return Outcome::ok;  // the complete ones are in the replies
}

Outcome ServoBus::sync_write(std::span<const std::uint8_t> ids, const Register& reg,
                             std::span<const std::int32_t> values) noexcept {
  if (ids.empty()) return Outcome::ok;
  std::size_t at = put_number(put_number(0, reg.address), reg.size);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    parameters_[at++] = ids[i];
    encode(reg, values[i], std::span(parameters_).subspan(at));
    at += reg.size;
  }
  return send(kBroadcast, Instruction::sync_write, at);
}

}  // namespace polyarm::servo_bus
