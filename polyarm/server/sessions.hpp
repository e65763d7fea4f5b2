#pragma once
/// Those who are connected: what they ask, who of them may move the cell, and what they are told.
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

/// Everything but welcome() is the cell thread's.
class Sessions {
 public:
  static constexpr double kFastest = 60;  ///< frames a second

  Sessions(cell::Observer& next, std::string version);
  ~Sessions();
  /// I/O thread; null: there are too many.
  std::shared_ptr<Client> welcome(Client::Side side);

  Journal& journal();
  void attach(cell::CellView& cell);
  void detach();
  /// True when somebody has been given something to send.
  bool serve();
  /// Between ticks: the same of what has come in alone.
  bool take();
  void set_bell(const std::shared_ptr<realtime::Bell>& bell);
  std::optional<cell::RestartWish> take_wish();
  Pendant::Counts counts() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::server
