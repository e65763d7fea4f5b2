#pragma once
/// UDP sockets without waiting, for drivers and the controllers that tests simulate. IPv4. Every socket is
/// non-blocking and closes on exec.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/wire/tcp.hpp"
#include "polyarm/base/descriptor.hpp"

namespace polyarm::wire {

/// The other end of a datagram.
struct UdpAddress {
  std::uint32_t host = 0;  ///< network byte order
  std::uint16_t port = 0;  ///< network byte order
  friend bool operator==(const UdpAddress&, const UdpAddress&) = default;
};
/// Of an IPv4 address as text; nothing if the address or the port is not valid.
std::optional<UdpAddress> udp_address(const std::string& host, int port);
/// "10.0.0.1". Allocates.
std::string host_text(const UdpAddress& address);

/// A socket that sends to one peer and receives from that peer only. On failure empty, with the reason in
/// `why`. Nothing is sent: a peer that does not exist shows only later. Allocates.
Descriptor connect_udp(const std::string& host, int port, std::string& why);
/// A socket that receives at an address of this machine; port 0: any. On failure empty, with the reason.
Descriptor bind_udp(const std::string& address, int port, std::string& why);

/// The next datagram that has arrived; never waits. A longer one than `into` is cut. `Got::failed`: the
/// peer's machine answers that nobody listens there. Real-time.
Received receive_datagram(int socket, std::span<std::uint8_t> into, UdpAddress* from = nullptr) noexcept;
/// To the peer of connect_udp(). False: it was not sent. Real-time.
bool send_datagram(int socket, std::span<const std::uint8_t> bytes) noexcept;
bool send_datagram(int socket, std::span<const std::uint8_t> bytes, const UdpAddress& to) noexcept;

}  // namespace polyarm::wire
