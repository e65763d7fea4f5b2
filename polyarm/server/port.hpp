#pragma once
/// The one TCP port: serves HTTP and WebSockets on its own I/O thread. It knows nothing of a cell.
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/access/gate.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/server/client.hpp"
#include "polyarm/server/stream.hpp"

namespace polyarm::server {

struct HttpRequest {
  std::string method, target, path;  ///< path: decoded, without the query
  std::string body, if_none_match;
  std::string authorization, shown;  ///< header as received; the token that was sent
  std::string from;                  ///< address of the client
  std::shared_ptr<Login> login;      ///< of a user; may be null
  bool gzip = false;  ///< the client accepts gzip
  Shown token = Shown::nothing;
  protocol::Role role = protocol::Role::watch;
  bool secure = false;  ///< received through TLS
};

struct HttpReply {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  Text body;
  bool gzip = false;
  std::vector<std::pair<std::string, std::string>> headers;
};
HttpReply plain(int status, const std::string& text);

/// What the port serves: answers requests and opens streams.
class Site {
 public:
  virtual ~Site() = default;
  /// True if this needs no token: the page itself and its files.
  virtual bool is_open(const std::string& method, const std::string& path) const = 0;
  /// Largest body that is accepted there, bytes; 0: no body.
  virtual std::size_t most_body(const std::string& method, const std::string& path) const = 0;
  /// I/O thread. `reply` must be called once, from any thread.
  virtual void handle(HttpRequest request, std::function<void(HttpReply)> reply) = 0;
  /// I/O thread. Called when an authorised client opens a WebSocket; null: too many are connected.
  virtual std::shared_ptr<Client> welcome(Client::Side side) = 0;
  /// I/O thread. `offered`: the list of subprotocols that a WebSocket offers. Returns the one for viewers
  /// (tools of others); empty: none is known.
  virtual std::string viewer_protocol(const std::string& offered) const { return {}; }
  /// I/O thread. Called when an authorised viewer opens a WebSocket; null: too many are connected.
  virtual std::shared_ptr<Stream> welcome_viewer() { return nullptr; }
};

struct PortOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: any free port
  GateRules rules;         ///< if the cookie name is empty, it is made from the port number
  std::string certificate, key;  ///< PEM; other machines must use TLS. Empty: no TLS
  bool local_in_clear = true;    ///< this machine may also connect without TLS
  std::size_t most_connections = bounds::kConnections;  ///< connections that have shown a token
  std::size_t most_unauthenticated = bounds::kUnauthenticated;      ///< connections that have not
  double head_s = bounds::kHead_ms / 1000.0, body_s = 60, idle_s = 20, send_s = 30;  ///< timeouts
};

class Port {
 public:
  /// Starts to listen. Throws Error("no-port") with the reason. `site` must outlive this.
  Port(PortOptions options, Site& site);
  /// Closes every WebSocket, and waits a short time until the clients have read that.
  ~Port();
  std::uint16_t number() const;
  /// Any thread. Call when clients have messages to send, or room for more.
  void wake();
  struct Counts {
    std::uint64_t connections = 0, refused = 0, requests = 0, timed_out = 0;
  };
  Counts counts() const;

  class Work;

 private:
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::server
