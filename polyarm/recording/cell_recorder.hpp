#pragma once
/// Records a cell into an MCAP file.
#include <memory>
#include <string>

#include "polyarm/setup/recorder.hpp"

namespace polyarm::cell {
class CellView;
}

namespace polyarm::recording {

/// Makes a recorder for the cell, which must outlive it. Cycles reach it through a tap of the control loop,
/// other messages through a queue. Both are bounded; messages that do not fit are dropped and counted. A
/// separate thread encodes, compresses and writes, so neither loop nor cell ever waits. In lock-step the tick
/// does all of this, and equal runs give equal bytes. Messages are in the file after one second at the
/// latest. A write error (for example a full disk) ends the recording, not the run, and is reported once.
///
/// `stop` only begins to close the file; `status().recording` becomes false when the file is complete. The
/// destructor waits for that.
std::unique_ptr<cell::Recorder> make_recorder(cell::CellView& cell, std::string version);

}  // namespace polyarm::recording
