#pragma once
/// TCP sockets without waiting, for drivers and the controllers that tests simulate. IPv4. Every socket is
/// non-blocking, closes on exec and sends at once (TCP_NODELAY).
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::wire {

/// Connects, and waits at most `timeout` ns. On failure the descriptor is empty and `why` says what to check:
/// name, cable, closed port, firewall. Allocates.
Descriptor connect_tcp(const std::string& host, int port, Nanoseconds timeout, std::string& why);
/// Listens at an address of this machine ("127.0.0.1", "0.0.0.0"); port 0: any. On failure empty, with the
/// reason in `why`.
Descriptor listen_tcp(const std::string& address, int port, std::string& why);
/// The next connection that waits to be accepted; empty without one.
Descriptor accept_tcp(int listener);
/// The port that a socket is bound to; 0 on failure.
int local_port(int socket);
/// The address of the other end; empty on failure.
std::string peer_address(int socket);
/// The address of this machine from which the socket speaks: what its peer can connect back to.
std::string local_address(int socket);

enum class Got : std::uint8_t { bytes, nothing, closed, failed };
struct Received {
  Got got = Got::nothing;
  std::size_t count = 0;
};
/// What has arrived; never waits. Real-time.
Received receive(int socket, std::span<std::uint8_t> into) noexcept;
/// Sends all or nothing of a frame that the socket's buffer should hold; never waits. False: the peer is gone
/// or does not read. Real-time.
bool send_frame(int socket, std::span<const std::uint8_t> bytes) noexcept;
inline bool send_frame(int socket, const std::string& text) noexcept {
  return send_frame(socket, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}
/// Sends what the socket takes of a text; never waits. Nothing: the peer is gone.
std::optional<std::size_t> send_some(int socket, std::string_view text) noexcept;
/// Waits at most `timeout` ns until the socket can be read.
bool wait_readable(int socket, Nanoseconds timeout) noexcept;

}  // namespace polyarm::wire
