#include "drivers/wire/udp.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace polyarm::wire {

namespace {

Descriptor udp_socket() {
  return Descriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

sockaddr_in name_of(const UdpAddress& address) noexcept {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_addr.s_addr = address.host;
  out.sin_port = address.port;
  return out;
}

}  // namespace

std::optional<UdpAddress> udp_address(const std::string& host, int port) {
  in_addr address{};
  if (::inet_pton(AF_INET, host.c_str(), &address) != 1 || port < 1 || port > 65535) return std::nullopt;
  return UdpAddress{address.s_addr, htons(static_cast<std::uint16_t>(port))};
}

std::string host_text(const UdpAddress& address) {
  char out[INET_ADDRSTRLEN] = "";
  const in_addr host{address.host};
  ::inet_ntop(AF_INET, &host, out, sizeof out);
  return out;
}

Descriptor connect_udp(const std::string& host, int port, std::string& why) {
  addrinfo wanted{}, *list = nullptr;
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_DGRAM;
  const int named = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &list);
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(list, [](addrinfo* one) {
    if (one) ::freeaddrinfo(one);
  });
  if (named != 0) {
    why = "there is no host '" + host + "' (" + ::gai_strerror(named) +
          "): write its address, as the robot's network settings show it";
    return Descriptor();
  }
  Descriptor out = udp_socket();
  if (!out || ::connect(out.number(), list->ai_addr, list->ai_addrlen) != 0) {
    why = host + ":" + std::to_string(port) + " cannot be reached: " + std::strerror(errno);
    return Descriptor();
  }
  return out;
}

Descriptor bind_udp(const std::string& address, int port, std::string& why) {
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_port = htons(static_cast<std::uint16_t>(port));
  if (::inet_pton(AF_INET, address.c_str(), &own.sin_addr) != 1) {
    why = "'" + address + "' is not an address of this machine: write one such as 127.0.0.1";
    return Descriptor();
  }
  Descriptor out = udp_socket();
  if (!out || ::bind(out.number(), reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) {
    why = "cannot receive at " + address + ":" + std::to_string(port) + ": " + std::strerror(errno);
    return Descriptor();
  }
  return out;
}

Received receive_datagram(int socket, std::span<std::uint8_t> into, UdpAddress* from) noexcept {
  sockaddr_in other{};
  socklen_t size = sizeof other;
  for (;;) {
    const ssize_t count = ::recvfrom(socket, into.data(), into.size(), MSG_DONTWAIT,
                                     reinterpret_cast<sockaddr*>(&other), &size);
    if (count >= 0) {
      if (from) *from = {other.sin_addr.s_addr, other.sin_port};
      return {Got::bytes, static_cast<std::size_t>(count)};
    }
    if (errno == EINTR) continue;
    return {errno == EAGAIN || errno == EWOULDBLOCK ? Got::nothing : Got::failed, 0};
  }
}

bool send_datagram(int socket, std::span<const std::uint8_t> bytes) noexcept {
  return ::send(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) ==
         static_cast<ssize_t>(bytes.size());
}

bool send_datagram(int socket, std::span<const std::uint8_t> bytes, const UdpAddress& to) noexcept {
  const sockaddr_in name = name_of(to);
  return ::sendto(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                  reinterpret_cast<const sockaddr*>(&name),
                  sizeof name) == static_cast<ssize_t>(bytes.size());
}

}  // namespace polyarm::wire
