#pragma once
/// The pendant's server: page, API and WebSockets of one cell after another on one port.
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "polyarm/inside/view.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/setup/door.hpp"

namespace polyarm::server {

struct PendantOptions {
  std::uint16_t port = 8765;                          ///< 0: any that is free
  std::optional<std::string> listen;                  ///< an address beyond loopback; "" is all of them
  std::string certificate, key;                       ///< PEM, for other machines; empty: all in clear
  std::string fingerprint;                            ///< of that certificate, for a person
  std::string token;                                  ///< that everybody has to show
  std::string page_folder;                            ///< the page from there instead of the command's own
  std::string version;                                ///< of the command, for who asks
  const description::Catalogue* catalogue = nullptr;  ///< outlives this
  /// A picture of a robot as SVG; any thread.
  std::function<std::string(const description::RobotModel&)> picture;
};

/// Made before a cell and outlives it; between two cells requests are refused with `no-cell`. An I/O thread
/// carries, another one draws and reads what takes long; everything below is the cell thread's.
class Pendant : public cell::Door {
 public:
  /// Listens from now on. Throws Error("no-port").
  Pendant(PendantOptions options, cell::Observer& next);
  ~Pendant() override;

  /// What a cell is to be made with, so that pages see what a person is told.
  cell::Observer& observer();
  /// This cell is served from now on, until detach() or another; it outlives that.
  void attach(cell::CellView& cell);
  void detach();
  /// Each tick, or now and then without a cell.
  void serve() override;
  void set_bell(const std::shared_ptr<realtime::Bell>& bell) override;
  void take() override;
  std::string address() const override { return link(); }

  /// What somebody wants to be run, asked for while there is no cell; once.
  std::optional<cell::RestartWish> take_wish();

  /// With the token, for a browser of this machine.
  std::string link() const;
  /// The same for other machines; empty where only loopback is served.
  std::string outside_link() const;
  /// The link, for other machines where they are served, of those who may do no more than that.
  std::string link_for(protocol::Role role) const;
  std::string fingerprint() const;
  std::uint16_t port() const;

  struct Counts {
    std::uint64_t clients = 0, connections = 0, refused = 0, timed_out = 0, requests = 0;
    std::uint64_t frames = 0, frames_left_out = 0, events_left_out = 0;
  };
  Counts counts() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::server
