#include "drivers/cia402/sdo.hpp"

#include <algorithm>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::cia402 {

/// Answers to an earlier request may still come: those of other objects are passed over.
SdoDone SdoClient::await(int node, SdoAnswer& answer, const Object* object) {
  const Nanoseconds end = realtime::monotonic_now() + timeout_;
  for (;;) {
    CanFrame frame;
    const BusState state = bus_.receive(frame, end);
    if (state == BusState::nothing) return {SdoResult::silent};
    if (state != BusState::ok) return {SdoResult::bus, 0, 0, state};
    if (node_of(frame, kSdoAnswer) != node) {
      if (other_) other_(frame);
      // A bus that is never quiet does not prolong the wait.
      if (realtime::monotonic_now() >= end) return {SdoResult::silent};
      continue;
    }
    answer = read_answer(frame);
    const bool of_object = answer.kind != SdoKind::segment && answer.kind != SdoKind::segment_ok;
    if (object && of_object && !(answer.object == *object)) continue;
    if (object && !of_object) continue;
    if (answer.kind == SdoKind::aborted) return {SdoResult::aborted, answer.code};
    return {};
  }
}

SdoDone SdoClient::give_up(int node, Object object, std::uint32_t code) {
  bus_.send(sdo_abort(node, object, code));
  return {SdoResult::wrong, code};
}

SdoDone SdoClient::upload(int node, Object object, std::span<std::uint8_t> into) {
  if (const BusState state = bus_.send(upload_request(node, object)); state != BusState::ok)
    return {SdoResult::bus, 0, 0, state};
  SdoAnswer answer;
  if (const SdoDone done = await(node, answer, &object); !done) return done;
  if (answer.kind == SdoKind::announced) return upload_segments(node, object, into, answer.size);
  if (answer.kind != SdoKind::expedited || answer.size > into.size())
    return give_up(node, object, kUnknownCommand);
  std::copy_n(answer.data.begin(), answer.size, into.begin());
  return {SdoResult::ok, 0, answer.size};
}

SdoDone SdoClient::upload_segments(int node, Object object, std::span<std::uint8_t> into,
                                   std::uint32_t announced) {
  if (announced > into.size()) return give_up(node, object, kOutOfMemory);
  std::size_t size = 0;
  for (bool toggle = false;; toggle = !toggle) {
    if (const BusState state = bus_.send(upload_segment_request(node, toggle)); state != BusState::ok)
      return {SdoResult::bus, 0, 0, state};
    SdoAnswer answer;
    if (const SdoDone done = await(node, answer, nullptr); !done) return done;
    if (answer.kind != SdoKind::segment) return give_up(node, object, kUnknownCommand);
    if (answer.toggle != toggle) return give_up(node, object, kWrongToggle);
    // An empty segment that is not the last would keep this waiting for ever.
    if (answer.size > into.size() - size || (answer.size == 0 && !answer.last))
      return give_up(node, object, kOutOfMemory);
    std::copy_n(answer.data.begin(), answer.size, into.begin() + static_cast<std::ptrdiff_t>(size));
    size += answer.size;
    if (!answer.last) continue;
    if (announced != 0 && announced != size) return {SdoResult::wrong};
    return {SdoResult::ok, 0, size};
  }
}

SdoDone SdoClient::download(int node, Object object, std::span<const std::uint8_t> bytes) {
  const bool short_one = bytes.size() <= 4;
  const CanFrame first = short_one
                             ? download_request(node, object, bytes)
                             : download_announcement(node, object, static_cast<std::uint32_t>(bytes.size()));
  if (const BusState state = bus_.send(first); state != BusState::ok) return {SdoResult::bus, 0, 0, state};
  SdoAnswer answer;
  if (const SdoDone done = await(node, answer, &object); !done) return done;
  if (answer.kind != SdoKind::written) return give_up(node, object, kUnknownCommand);
  if (short_one) return {};
  bool toggle = false;
  for (std::size_t at = 0; at < bytes.size(); at += 7, toggle = !toggle) {
    const auto part = bytes.subspan(at, std::min<std::size_t>(7, bytes.size() - at));
    const bool last = at + part.size() == bytes.size();
    if (const BusState state = bus_.send(download_segment(node, toggle, last, part)); state != BusState::ok)
      return {SdoResult::bus, 0, 0, state};
    if (const SdoDone done = await(node, answer, nullptr); !done) return done;
    if (answer.kind != SdoKind::segment_ok) return give_up(node, object, kUnknownCommand);
    if (answer.toggle != toggle) return give_up(node, object, kWrongToggle);
  }
  return {};
}

SdoDone SdoClient::read(int node, Object object, std::size_t size, std::uint64_t& value) {
  std::array<std::uint8_t, 8> bytes{};
  const SdoDone done = upload(node, object, bytes);
  if (!done) return done;
  if (done.size != size) return {SdoResult::wrong, 0, done.size};
  value = get(bytes, 0, size);
  return done;
}

SdoDone SdoClient::write(int node, Object object, std::size_t size, std::uint64_t value) {
  std::array<std::uint8_t, 8> bytes{};
  put(bytes, value, size);
  return download(node, object, std::span(bytes).first(size));
}

}  // namespace polyarm::cia402
