#pragma once
/// `polyarm run --pendant`: the options, the server, and the link that a person opens.
#include <memory>
#include <string>

#include "apps/command_line.hpp"
#include "polyarm/server/pendant.hpp"

namespace polyarm::apps {

struct PendantArguments {
  bool on = false, open = false, listens = false, in_clear = false, links = false;
  int port = -1;  ///< default: 8765, or any free port if it is in use
  double log_in_hours = bounds::kLoginHours;
  std::string listen, page, certificate, key, metrics;
};
void add_pendant_options(CommandLine& app, PendantArguments& arguments);

/// The catalogue and the audit log (or null) must outlive the pendant. Throws Error.
std::unique_ptr<server::Pendant> open_pendant(const PendantArguments& arguments,
                                              const description::Catalogue& catalogue, cell::Observer& next,
                                              users::AuditLog* audit);
/// If other machines are served, prints the link and a QR code; opens the page if requested.
void announce(const server::Pendant& pendant, const PendantArguments& arguments, cell::Observer& observer);

}  // namespace polyarm::apps
