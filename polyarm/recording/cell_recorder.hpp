#pragma once
/// Writes what a cell does into an MCAP file.
#include <memory>
#include <string>

#include "polyarm/setup/recorder.hpp"

namespace polyarm::cell {
class CellView;
}

namespace polyarm::recording {

/// A recorder for the cell, which must outlive it. Cycles reach it through a tap of the control loop, the
/// rest through a queue; both have an end, and what finds no room is counted and lost. A thread of its own
/// encodes, compresses and writes, so that neither loop nor cell ever waits; in lock-step it is all done
/// within the tick, and the same run gives the same bytes. What is recorded is in the file after a second at
/// the latest. A disk that takes no more ends the recording, not the run, and is told once.
///
/// `stop` only begins to close the file: `status().recording` says when it is whole. Destroying the recorder
/// waits for that.
std::unique_ptr<cell::Recorder> make_recorder(cell::CellView& cell, std::string version);

}  // namespace polyarm::recording
