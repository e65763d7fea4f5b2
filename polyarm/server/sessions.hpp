#pragma once
/// The connected clients: takes their requests, decides who has control, and sends them events.
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/inside/view.hpp"
#include "polyarm/server/client.hpp"
#include "polyarm/server/journal.hpp"
#include "polyarm/server/pendant.hpp"

namespace polyarm::server {

/// All members but welcome() belong to the cell thread.
class Sessions {
 public:
  static constexpr double kFastest = 60;  ///< frames per second

  /// `audit` may be null.
  Sessions(cell::Observer& next, std::string version, users::AuditLog* audit = nullptr);
  ~Sessions();
  /// I/O thread. Null: too many clients are connected.
  std::shared_ptr<Client> welcome(Client::Side side);

  Journal& journal();
  void attach(cell::CellView& cell);
  void detach();
  /// Call each tick. Returns true if a client has something to send.
  bool serve();
  /// Between ticks: only takes the requests that have come in.
  bool take();
  void set_wakeup(const std::shared_ptr<realtime::Bell>& bell);
  std::optional<cell::RestartRequest> take_restart_request();
  Pendant::Counts counts() const;
  std::optional<users::Actor> actor(const void* client) const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::server
