#pragma once
/// The interface between a WebSocket and its protocol.
#include <memory>
#include <optional>
#include <string>

#include "polyarm/server/client.hpp"

namespace polyarm::server {

/// All members belong to the I/O thread, except gone(): any thread.
class Stream {
 public:
  virtual ~Stream() = default;
  /// Takes a message; `now`: s, of any steady clock. Returns the reason if the connection must end, else
  /// null.
  virtual const char* take(std::string message, bool binary, double now) = 0;
  virtual std::optional<Client::Out> next() = 0;
  virtual bool gone() const = 0;
  virtual void leave() = 0;
};

}  // namespace polyarm::server
