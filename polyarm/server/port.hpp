#pragma once
/// The one port: HTTP and WebSockets on a thread of its own, which carries and owns nothing of a cell.
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/server/client.hpp"
#include "polyarm/server/gate.hpp"
#include "polyarm/server/stream.hpp"

namespace polyarm::server {

struct HttpRequest {
  std::string method, target, path;  ///< path: decoded, without the query
  std::string body, if_none_match;
  bool gzip = false;  ///< the other side takes it
  Shown token = Shown::nothing;
  protocol::Role role = protocol::Role::watch;
  bool secure = false;  ///< it came through TLS
};

struct HttpReply {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  Text body;
  bool gzip = false;
  std::vector<std::pair<std::string, std::string>> headers;
};
HttpReply plain(int status, const std::string& text);

/// What is behind the port.
class Site {
 public:
  virtual ~Site() = default;
  /// May everybody see it, who has no token? The page itself and its files.
  virtual bool is_open(const std::string& method, const std::string& path) const = 0;
  /// Most bytes that a body may have there; 0: none.
  virtual std::size_t most_body(const std::string& method, const std::string& path) const = 0;
  /// I/O thread; `reply` is called once, from any thread.
  virtual void handle(HttpRequest request, std::function<void(HttpReply)> reply) = 0;
  /// I/O thread: a WebSocket was opened by somebody who may; null: there are too many.
  virtual std::shared_ptr<Client> welcome(Client::Side side) = 0;
  /// I/O thread: the subprotocol by which tools of others watch, of those that a WebSocket offers in one
  /// text; empty: none of them.
  virtual std::string viewer_protocol(const std::string& offered) const { return {}; }
  /// I/O thread: one of these was opened by somebody who may; null: there are too many.
  virtual std::shared_ptr<Stream> welcome_viewer() { return nullptr; }
};

struct PortOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: any that is free
  GateRules rules;         ///< an empty cookie name is made from the port
  std::string certificate, key;  ///< PEM: other machines are served through TLS alone; empty: all in clear
  bool local_in_clear = true;    ///< this machine itself is served in clear, too
  std::size_t most_connections = bounds::kConnections;  ///< that have shown a token
  std::size_t most_strangers = bounds::kStrangers;      ///< that have not
  double head_s = bounds::kHead_ms / 1000.0, body_s = 60, idle_s = 20, send_s = 30;  ///< how long the other side may take
};

class Port {
 public:
  /// Listens. Throws Error("no-port") with what is wrong; `site` outlives it.
  Port(PortOptions options, Site& site);
  /// Says goodbye to every WebSocket, and waits a moment for it to be read.
  ~Port();
  std::uint16_t number() const;
  /// Any thread: clients have been given something to send, or have room for more.
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
