#pragma once
/// Tries a driver on its device: opens it, identifies it, reads for a while, and reports the result. Nothing
/// moves unless requested. Not for the control thread: it blocks.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::doctor {

struct TrialOptions {
  double seconds = 5;      ///< duration of reading
  double rate = 100;       ///< Hz
  bool move = false;       ///< moves each joint that has a position command a little and back, one joint
                           ///< after the other
  double distance = 0.05;  ///< of that move, rad or m
  std::function<bool()> stop = [] { return false; };  ///< called in each cycle; true ends the trial cleanly
};

/// One state interface during the trial.
struct TriedState {
  std::string name;
  double first = 0, last = 0, least = 0, most = 0;  ///< of the finite values; NaN if there are none
  double finite = 0;                                ///< fraction of the reads with a finite value
  double changes_per_second = 0;
};

struct Trial {
  std::string driver;
  std::map<std::string, std::string> parameters;
  bool passed = false, moved = false, stopped = false;
  std::string failure;  ///< the step that failed, and why
  std::string summary;  ///< the driver's description of the device
  std::string reason;   ///< its warning at the end, without a failure
  double configure_ms = 0;
  std::uint64_t reads = 0, late = 0;
  double read_us_p50 = 0, read_us_p99 = 0, read_us_max = 0;  ///< duration of one read
  double write_us_p99 = 0;                                   ///< 0 without movement
  double gap_ms_p50 = 0, gap_ms_p99 = 0, gap_ms_max = 0;     ///< between two updates from the device
  std::vector<TriedState> states;
};

/// Takes the component through its life cycle. A real component is activated only to move. Never throws.
Trial try_driver(hardware::Component& component, const hardware::ComponentContext& context,
                 const TrialOptions& options);

/// The most important facts for an expert: rates, losses, temperatures, voltages; lines of text.
std::vector<std::string> highlights(const Trial& trial);

/// Facts about the machine for the report.
struct TrialSetting {
  std::string version, kernel, proof, time;
  bool preempt_rt = false;
};
/// The report, as YAML.
std::string report(const Trial& trial, const TrialSetting& setting);

}  // namespace polyarm::doctor
