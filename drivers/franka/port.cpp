#include "drivers/franka/port.hpp"

#include <array>

#include "drivers/wire/ordered_bytes.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::franka {

bool Port::fail(Cause cause, const std::string& text) {
  failure_ = {cause, text};
  return false;
}

bool Port::open(Nanoseconds timeout) {
  failure_ = {};
  reader_ = FrameReader(head_);
  std::string why;
  socket_ = wire::connect_tcp(host_, port_, timeout, why);
  return socket_ || fail(Cause::unreachable, why);
}

std::optional<std::uint32_t> Port::send(std::uint32_t command, const Data& data) {
  const std::uint32_t id = id_++;
  wire::OrderedWriter out(wire::ByteOrder::little);
  if (head_ == kFciHead)
    out.u32(command);
  else
    out.u16(command);
  out.u32(id).u32(head_ + data.size()).append(data);
  if (!is_open() || !wire::send_frame(socket_.number(), out.bytes())) return std::nullopt;
  return id;
}

bool Port::receive() {
  if (!is_open()) return false;
  std::array<std::uint8_t, 2048> buffer;
  for (;;) {
    const wire::Received got = wire::receive(socket_.number(), buffer);
    if (got.got == wire::Got::nothing) return true;
    if (got.got != wire::Got::bytes) return fail(Cause::closed);
    if (!reader_.feed(Bytes(buffer).first(got.count))) return fail(Cause::bad_data);
    if (got.count < buffer.size()) return true;
  }
}

std::optional<Frame> Port::next() {
  return reader_.next();
}

std::optional<Frame> Port::ask(std::uint32_t command, const Data& data, Nanoseconds timeout) {
  const auto id = send(command, data);
  if (!id) {
    fail(Cause::closed);
    return std::nullopt;
  }
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  for (;;) {
    const bool well = receive();
    while (auto frame = next())
      if (frame->id == *id && frame->command == command) return frame;
    if (!well) return std::nullopt;
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0) {
      fail(Cause::command_silent);
      return std::nullopt;
    }
    wire::wait_readable(socket_.number(), left);
  }
}

}  // namespace polyarm::franka
