#pragma once
/// `polyarm run --pendant`: the options, the server, and the link that a person opens.
#include <memory>
#include <string>

#include "apps/command_line.hpp"
#include "polyarm/server/pendant.hpp"

namespace polyarm::apps {

struct PendantArguments {
  bool on = false, open = false, listens = false, in_clear = false, links = false;
  int port = -1;  ///< not stated: 8765, or any where that is taken
  std::string listen, page, certificate, key;
};
void add_pendant_options(CommandLine& app, PendantArguments& arguments);

/// The catalogue outlives it. Throws Error.
std::unique_ptr<server::Pendant> open_pendant(const PendantArguments& arguments,
                                              const description::Catalogue& catalogue, cell::Observer& next);
/// Where other machines are served, prints their link and a QR code; opens the page where that is asked for.
void announce(const server::Pendant& pendant, const PendantArguments& arguments, cell::Observer& observer);

}  // namespace polyarm::apps
