#pragma once
/// The connected clients of the port, as the cell thread sees them. Cell thread; welcome() is called on the
/// I/O thread.
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/server/client.hpp"

namespace polyarm::server {

// Pages also load files, and viewers of other tools connect.
static_assert(bounds::kPageClients + bounds::kControlSeats + 128 <= bounds::kConnections);

/// A connected client.
struct Seat {
  std::shared_ptr<Client> client;
  std::string name;
  bool listens = false, greeted = false;  ///< listens: wants events; greeted: has received the full state
  double rate = 0, due = 0;               ///< state frames a second; the time of the next one, s
  double reserved_until = 0;  ///< it uses a seat reserved for control until this time; 0: no such seat
};

class Seats {
 public:
  /// Seats a client from the next seat_arrivals() on; null if all seats are taken. Clients that may take
  /// control have some seats beyond the limit for all. `rope` is pulled when a line comes in.
  std::shared_ptr<Client> welcome(Client::Side side, const std::shared_ptr<realtime::WakeupHandle>& rope) {
    const std::lock_guard lock(mutex_);
    const bool may_take = side.role != protocol::Role::watch;
    if (connected_ >= bounds::kPageClients + (may_take ? bounds::kControlSeats : 0)) return nullptr;
    ++connected_;
    auto client = std::make_shared<Client>(++last_client_, std::move(side), rope, waiting_);
    arrived_.emplace_back(client, connected_ > bounds::kPageClients);
    return client;
  }

  void seat_arrivals(double now) {
    const std::lock_guard lock(mutex_);
    for (auto& [client, reserved] : arrived_) {
      Seat seat;
      seat.name = client->login ? client->login->user : client->from;
      if (reserved) seat.reserved_until = now + bounds::kControlSeat_ms / 1000.0;
      const std::uint64_t number = client->number;
      seat.client = std::move(client);
      seats_.emplace(number, std::move(seat));
    }
    arrived_.clear();
  }

  /// Calls `leaves(seat)` for each client that is gone, and frees its seat.
  template <class Leaves>
  void free_seats(const Leaves& leaves) {
    for (auto each = seats_.begin(); each != seats_.end();) {
      if (!each->second.client->gone()) {
        ++each;
        continue;
      }
      leaves(each->second);
      omitted_frames_ += each->second.client->omitted_frames();
      omitted_events_ += each->second.client->omitted_events();
      each = seats_.erase(each);
      const std::lock_guard lock(mutex_);
      --connected_;
    }
  }

  /// All clients by number.
  std::map<std::uint64_t, Seat>& all() { return seats_; }
  const std::map<std::uint64_t, Seat>& all() const { return seats_; }
  std::size_t size() const { return seats_.size(); }

  /// The client after the one that this function returned last; there must be one.
  Seat& next() {
    auto next = seats_.upper_bound(served_);
    if (next == seats_.end()) next = seats_.begin();
    served_ = next->first;
    return next->second;
  }

  std::string name_of(std::uint64_t client) const {
    const auto found = seats_.find(client);
    return found == seats_.end() ? "a client that is gone" : found->second.name;
  }

  /// Sends an answer, if that client is still there.
  void tell(std::uint64_t to, const std::string& line) {
    if (const auto found = seats_.find(to); found != seats_.end()) found->second.client->answer(line);
  }

  /// True if a client has put a new line since the last call.
  bool any_woken() {
    bool wake = false;
    for (auto& [number, seat] : seats_) wake = seat.client->take_wake() || wake;
    return wake;
  }

  /// Of all clients since the start.
  std::uint64_t omitted_frames() const {
    std::uint64_t out = omitted_frames_;
    for (const auto& [number, seat] : seats_) out += seat.client->omitted_frames();
    return out;
  }
  std::uint64_t omitted_events() const {
    std::uint64_t out = omitted_events_;
    for (const auto& [number, seat] : seats_) out += seat.client->omitted_events();
    return out;
  }

 private:
  const std::shared_ptr<Waiting> waiting_ = std::make_shared<Waiting>();
  std::mutex mutex_;  // protects the next three, which the I/O thread also changes
  std::vector<std::pair<std::shared_ptr<Client>, bool>> arrived_;  // true: on a seat reserved for control
  std::uint64_t last_client_ = 0;
  std::size_t connected_ = 0;

  std::map<std::uint64_t, Seat> seats_;
  std::uint64_t served_ = 0;                               // the client whose line was taken last
  std::uint64_t omitted_frames_ = 0, omitted_events_ = 0;  // of clients that are gone
};

}  // namespace polyarm::server
