#pragma once
/// The main function of `polyarm_link_KIND`: runs a port behind the protocol of link_exchange.hpp.
#include "polyarm/signals/link.hpp"

namespace polyarm::signals {

/// A cell starts it as `PROGRAM PARENT`, with the descriptors of a process::Channel. Returns the exit code.
int serve_link(int argc, char** argv, MakeLinkPort make);

}  // namespace polyarm::signals
