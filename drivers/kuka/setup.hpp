#pragma once
/// `polyarm setup kuka`: looks at a controller and offers our texts for it. Nothing moves.
#include <functional>
#include <string>

#include "drivers/kuka/krl.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::kuka {

struct SetupOptions {
  std::string host;      ///< empty: the maker's address of the KLI
  std::string rsi_host;  ///< address in the network of RSI; empty: `host`
  KrlSettings krl;       ///< without an own address, that of the interface that reaches the controller
  std::string folder;    ///< where the texts are written; empty: nowhere
  Nanoseconds timeout = 3'000'000'000;
  std::function<void(const std::string&)> say;  ///< a line for a person
};

/// True if everything that the driver needs is there. Throws Error if a file cannot be written.
bool set_up(SetupOptions options);

}  // namespace polyarm::kuka
