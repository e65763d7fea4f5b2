#pragma once
/// The main of `polyarm_link_KIND`: a port behind the exchange of link_exchange.hpp.
#include "polyarm/signals/link.hpp"

namespace polyarm::signals {

/// Started by a cell as `PROGRAM PARENT`, with the descriptors of a process::Channel. Returns the exit code.
int serve_link(int argc, char** argv, MakeLinkPort make);

}  // namespace polyarm::signals
