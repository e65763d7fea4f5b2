#pragma once
/// What is behind a WebSocket, whatever it speaks.
#include <memory>
#include <optional>
#include <string>

#include "polyarm/server/client.hpp"

namespace polyarm::server {

/// The I/O thread's, but for gone(), which is any thread's.
class Stream {
 public:
  virtual ~Stream() = default;
  /// A message has come in; `now`: s, of any steady clock. Why the connection has to end; null: it goes on.
  virtual const char* take(std::string message, bool binary, double now) = 0;
  virtual std::optional<Client::Out> next() = 0;
  virtual bool gone() const = 0;
  virtual void leave() = 0;
};

}  // namespace polyarm::server
