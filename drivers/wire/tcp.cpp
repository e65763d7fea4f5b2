#include "drivers/wire/tcp.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

namespace polyarm::wire {

namespace {

bool wait_for(int socket, short events, Nanoseconds timeout) noexcept {
  pollfd one{socket, events, 0};
  const timespec time{static_cast<time_t>(timeout / 1'000'000'000),
                      static_cast<long>(timeout % 1'000'000'000)};
  return ::ppoll(&one, 1, &time, nullptr) > 0;
}

void set_no_delay(int socket) {
  const int on = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

std::string explain(int error, const std::string& place) {
  switch (error) {
    case ECONNREFUSED:
      return place +
             " refuses the connection: the controller is still starting, this service is switched off "
             "in its security settings, or the address belongs to another machine";
    case EHOSTUNREACH:
    case ENETUNREACH:
      return place + " cannot be reached: check the cable, and that both addresses are in one network";
    case ETIMEDOUT:
      return place + " does not answer: check address and cable, and that no firewall blocks the port";
    default:
      return place + " cannot be reached: " + std::strerror(error);
  }
}

sockaddr_in name_of(int socket) {
  sockaddr_in own{};
  socklen_t size = sizeof own;
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&own), &size);
  return own;
}

std::string text_of(const sockaddr_in& address) {
  char text[INET_ADDRSTRLEN] = {};
  return ::inet_ntop(AF_INET, &address.sin_addr, text, sizeof text) ? text : "";
}

}  // namespace

Descriptor connect_tcp(const std::string& host, int port, Nanoseconds timeout, std::string& why) {
  const std::string place = host + ":" + std::to_string(port);
  addrinfo wanted{}, *list = nullptr;
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_STREAM;
  const int named = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &list);
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(list, [](addrinfo* one) {
    if (one) ::freeaddrinfo(one);
  });
  if (named != 0) {
    why = "there is no host '" + host + "' (" + ::gai_strerror(named) +
          "): write its address, as the robot's "
          "network settings show it";
    return Descriptor();
  }
  Descriptor out(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  int error = out ? 0 : errno;
  if (out && ::connect(out.number(), list->ai_addr, list->ai_addrlen) != 0) {
    error = errno;
    if (error == EINPROGRESS) {
      socklen_t size = sizeof error;
      if (!wait_for(out.number(), POLLOUT, timeout))
        error = ETIMEDOUT;
      else
        ::getsockopt(out.number(), SOL_SOCKET, SO_ERROR, &error, &size);
    }
  }
  if (error != 0) {
    why = explain(error, place);
    return Descriptor();
  }
  set_no_delay(out.number());
  return out;
}

Descriptor listen_tcp(const std::string& address, int port, std::string& why) {
  Descriptor out(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_port = htons(static_cast<std::uint16_t>(port));
  const int on = 1;
  const std::string place = address + ":" + std::to_string(port);
  if (::inet_pton(AF_INET, address.c_str(), &own.sin_addr) != 1) {
    why = "'" + address + "' is not an address of this machine: write one such as 127.0.0.1";
    return Descriptor();
  }
  if (!out || ::setsockopt(out.number(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
      ::bind(out.number(), reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 ||
      ::listen(out.number(), 8) != 0) {
    why = "cannot listen at " + place + ": " + std::strerror(errno);
    return Descriptor();
  }
  return out;
}

Descriptor accept_tcp(int listener) {
  Descriptor out(::accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (out) set_no_delay(out.number());
  return out;
}

int local_port(int socket) {
  return ntohs(name_of(socket).sin_port);
}

std::string local_address(int socket) {
  return text_of(name_of(socket));
}

std::string peer_address(int socket) {
  sockaddr_in other{};
  socklen_t size = sizeof other;
  if (::getpeername(socket, reinterpret_cast<sockaddr*>(&other), &size) != 0) return {};
  return text_of(other);
}

Received receive(int socket, std::span<std::uint8_t> into) noexcept {
  for (;;) {
    const ssize_t count = ::recv(socket, into.data(), into.size(), MSG_DONTWAIT);
    if (count > 0) return {Got::bytes, static_cast<std::size_t>(count)};
    if (count == 0) return {Got::closed, 0};
    if (errno == EINTR) continue;
    return {errno == EAGAIN || errno == EWOULDBLOCK ? Got::nothing : Got::failed, 0};
  }
}

bool send_frame(int socket, std::span<const std::uint8_t> bytes) noexcept {
  return ::send(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) ==
         static_cast<ssize_t>(bytes.size());
}

std::optional<std::size_t> send_some(int socket, std::string_view text) noexcept {
  const ssize_t count = ::send(socket, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (count >= 0) return static_cast<std::size_t>(count);
  if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) return 0;
  return std::nullopt;
}

bool wait_readable(int socket, Nanoseconds timeout) noexcept {
  return wait_for(socket, POLLIN, timeout);
}

}  // namespace polyarm::wire
