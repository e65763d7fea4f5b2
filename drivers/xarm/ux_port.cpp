#include "drivers/xarm/ux_port.hpp"

#include <array>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::xarm {

bool UxPort::fail(Cause cause, const std::string& text) {
  failure_ = {cause, text};
  close();
  return false;
}

bool UxPort::open(Nanoseconds timeout) {
  failure_ = {};
  reader_ = UxReader();
  std::string why;
  socket_ = wire::connect_tcp(host_, port_, timeout, why);
  return socket_ || fail(Cause::unreachable, why);
}

bool UxPort::send(Register reg, const std::vector<std::uint8_t>& data) {
  transaction_ = static_cast<std::uint16_t>(transaction_ % 65535 + 1);
  asked_ = reg;
  const auto bytes = encode(UxRequest{transaction_, kPrivateProtocol, reg, data});
  return (is_open() && wire::send_frame(socket_.number(), bytes)) || fail(Cause::closed);
}

bool UxPort::receive() {
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

std::optional<UxReply> UxPort::next() {
  while (const auto frame = reader_.next()) {
    const auto reply = decode_reply(*frame);
    if (!reply) {
      fail(Cause::bad_data);
      return std::nullopt;
    }
    if (reply->transaction != transaction_) continue;  // the answer to an earlier request, which was late
    if (reply->reg == asked_) return reply;
    fail(Cause::bad_data);
    return std::nullopt;
  }
  return std::nullopt;
}

std::optional<UxReply> UxPort::ask(Register reg, const std::vector<std::uint8_t>& data, Nanoseconds timeout) {
  if (!send(reg, data)) return std::nullopt;
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  for (;;) {
    const bool well = receive();
    if (auto reply = next()) return reply;
    if (!well || !is_open()) return std::nullopt;
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0) {
      fail(Cause::command_silent);
      return std::nullopt;
    }
    wire::wait_readable(socket_.number(), left);
  }
}

}  // namespace polyarm::xarm
