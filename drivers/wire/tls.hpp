#pragma once
/// TLS over a TCP socket of wire/tcp.hpp, for clients of controllers and for simulated ones. One thread for
/// each connection.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "drivers/wire/tcp.hpp"

struct ssl_ctx_st;
struct ssl_st;

namespace polyarm::wire {

/// Why a handshake failed, when the other end just closed the connection.
inline constexpr const char* kConnectionClosed = "the connection was closed";

/// The settings of one end: for a client without a list of authorities, because controllers have
/// self-signed certificates; for a server with a certificate of its own that is made here.
class TlsContext {
 public:
  enum class End : std::uint8_t { client, server };
  /// Throws Error("no-tls").
  explicit TlsContext(End end);
  ~TlsContext();
  TlsContext(const TlsContext&) = delete;
  TlsContext& operator=(const TlsContext&) = delete;
  ssl_ctx_st* get() const { return context_; }
  bool server() const { return server_; }

 private:
  ssl_ctx_st* context_ = nullptr;
  bool server_ = false;
};

/// A connection, with TLS or without. Nothing here waits but handshake() and write(), which have a limit.
class Channel {
 public:
  Channel();
  /// `context`: null without TLS.
  Channel(Descriptor socket, const TlsContext* context);
  ~Channel();
  Channel(Channel&& other) noexcept;
  Channel& operator=(Channel&& other) noexcept;

  explicit operator bool() const { return static_cast<bool>(socket_); }
  int descriptor() const { return socket_.number(); }
  const Descriptor& socket() const { return socket_; }
  /// The client's end of the handshake. False, with the reason, if it fails or takes longer.
  bool handshake(Nanoseconds timeout, std::string& why);
  Received read(std::span<std::uint8_t> into);
  bool write(std::string_view text, Nanoseconds timeout);
  /// SHA-256 of the certificate of the other end: "3A:F1:…"; empty without TLS.
  std::string fingerprint() const;
  void close();

 private:
  bool wait(int error, Nanoseconds deadline) const;
  Descriptor socket_;
  ssl_st* ssl_ = nullptr;
};

}  // namespace polyarm::wire
