#pragma once
/// `polyarm setup yaskawa`: looks at a controller and says what to set at its pendant. Nothing moves.
#include <functional>
#include <string>

#include "drivers/yaskawa/moto.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::yaskawa {

struct SetupOptions {
  std::string host;  ///< empty: the maker's address
  int motion_port = kMotionPort, state_port = kStatePort, io_port = kIoPort, hses_port = 10040;
  int group = 0;
  bool forward = false;  ///< forward mode: the Ethernet server alone
  std::string folder;    ///< where our files are written; empty: nowhere
  Nanoseconds timeout = 3'000'000'000;
  std::function<void(const std::string&)> say;  ///< a line for a person
};

/// True if everything that the driver needs is there. Throws Error if a file cannot be written.
bool set_up(SetupOptions options);

/// The job that MotoROS starts, for a controller with one robot (not DX100).
std::string init_ros_job();
/// What the ladder has to do with the heartbeat of forward mode, for a person who writes its rungs.
std::string ladder_text(int watchdog_ms);

}  // namespace polyarm::yaskawa
