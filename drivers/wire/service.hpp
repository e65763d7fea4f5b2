#pragma once
/// The clients of a listening TCP socket, for simulated controllers. One thread; nothing here waits.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "drivers/wire/bytes.hpp"
#include "drivers/wire/tcp.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::wire {

/// Reads of one client in one turn: a client that never stops sending holds up no other one.
inline constexpr int kReadsInTurn = 64;

/// At most bounds::kFarSideClients clients. A further one takes the place of the oldest that has never sent
/// anything, so that idle connections keep nobody away; it is closed if all have. `Client` has the members
/// `socket` and `gone`.
template <typename Client>
class Service {
 public:
  /// Throws Error("no-port"). Port 0: any.
  void listen(const std::string& address, int port) {
    std::string why;
    listener_ = listen_tcp(address, port, why);
    if (!listener_) throw Error("no-port", why, "choose another port, or end the program that uses it");
    local_port_ = wire::local_port(listener_.number());
  }
  int port() const { return local_port_; }
  int listener() const { return listener_.number(); }
  std::vector<std::unique_ptr<Client>>& clients() { return clients_; }
  /// Accepts, reads, and drops those that are gone or for which `take` returns false.
  template <typename Arrived, typename Take>
  void serve(Arrived arrived, Take take) {
    while (Descriptor socket = accept_tcp(listener_.number()))
      if (make_room()) {
        clients_.push_back(std::make_unique<Client>());
        clients_.back()->socket = std::move(socket);
        silent_.push_back(clients_.back().get());
        arrived(*clients_.back());
      }
    for (auto& client : clients_) client->gone = client->gone || !read(*client, take);
    drop_gone();
  }
  void drop_all() {
    silent_.clear();
    clients_.clear();
  }
  /// Drops those that are gone.
  void drop_gone() {
    std::erase_if(silent_, [](const Client* client) { return client->gone; });
    std::erase_if(clients_, [](const auto& client) { return client->gone; });
  }

 private:
  bool make_room() {
    if (clients_.size() < bounds::kFarSideClients) return true;
    if (silent_.empty()) return false;
    silent_.front()->gone = true;
    drop_gone();
    return true;
  }
  template <typename Take>
  bool read(Client& client, Take& take) {
    std::array<std::uint8_t, 4096> buffer;
    for (int turn = 0; turn < kReadsInTurn; ++turn) {
      const Received got = receive(client.socket.number(), buffer);
      if (got.got == Got::nothing) return true;
      if (got.got == Got::bytes) std::erase(silent_, &client);
      if (got.got != Got::bytes || !take(client, Bytes(buffer).first(got.count)) || client.gone) return false;
    }
    return true;
  }
  Descriptor listener_;
  int local_port_ = 0;
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<Client*> silent_;  ///< those that have never sent anything, the oldest first
};

}  // namespace polyarm::wire
