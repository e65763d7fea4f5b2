#pragma once
/// The pendant's server: serves page, API and WebSockets on one port, for one cell after another.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "polyarm/base/bounds.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/setup/door.hpp"
#include "polyarm/users/audit_log.hpp"

namespace polyarm::server {

struct PendantOptions {
  std::uint16_t port = 8765;                  ///< 0: any free port
  std::optional<std::string> listen;          ///< address to listen on beyond loopback; "" means all
  std::string certificate, key;               ///< PEM, for other machines; empty: no TLS
  std::string fingerprint;                    ///< of that certificate, shown to the user
  std::string token;                          ///< every client must send it
  std::filesystem::path users;                ///< list of users who may log in; empty: none
  double log_in_hours = bounds::kLoginHours;  ///< every log-in of a user ends after this time
  users::AuditLog* audit = nullptr;           ///< outlives this; null: nothing is logged
  /// Where GET /metrics is served without a token; nothing: nowhere.
  struct Metrics {
    std::string address = "127.0.0.1";
    std::uint16_t port = 9464;  ///< 0: any free port
  };
  std::optional<Metrics> metrics;
  std::string page_folder;                            ///< folder of the page; empty: the built-in page
  std::string version;                                ///< version of the command, reported to clients
  const description::Catalogue* catalogue = nullptr;  ///< outlives this
  /// Makes an SVG picture of a robot; called on any thread.
  std::function<std::string(const description::RobotModel&)> picture;
};

/// Created before the cell, and outlives it. Between two cells, requests are refused with `no-cell`. An I/O
/// thread serves the sockets; a worker thread draws pictures and reads large files. All members below belong
/// to the cell thread.
class Pendant : public cell::Door {
 public:
  /// Starts to listen. Throws Error("no-port").
  Pendant(PendantOptions options, cell::Observer& next);
  ~Pendant() override;

  /// Build the cell with this observer, so that pages show the same reports as the console.
  cell::Observer& observer();
  /// Serves this cell until detach() or the next attach(). The cell must outlive that.
  void attach(cell::CellView& cell);
  void detach();
  /// Call each tick; without a cell, from time to time.
  void serve() override;
  void set_wakeup(const std::shared_ptr<realtime::Bell>& bell) override;
  void take() override;
  std::string address() const override { return link(); }

  /// The restart that a client asked for while there was no cell; returned once.
  std::optional<cell::RestartRequest> take_restart_request();

  /// The link with the token, for a browser on this machine.
  std::string link() const;
  /// The same for other machines; empty if only loopback is served.
  std::string outside_link() const;
  /// A link that allows no more than `role`; for other machines if they are served.
  std::string link_for(protocol::Role role) const;
  std::string fingerprint() const;
  std::uint16_t port() const;
  /// Of the metrics; 0: not served.
  std::uint16_t metrics_port() const;

  /// The client that the cell's requests know by this address; nothing if it is not of this port. Cell
  /// thread.
  std::optional<users::Actor> actor(const void* client) const;

  struct Counts {
    std::uint64_t clients = 0, connections = 0, refused = 0, timed_out = 0, requests = 0;
    std::uint64_t frames = 0, omitted_frames = 0, omitted_events = 0;
  };
  Counts counts() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::server
