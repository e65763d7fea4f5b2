#pragma once
/// A driver tried on its device: opened, identified, read for a while, and what came of it. Nothing moves
/// unless that is asked for.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::doctor {

struct TrialOptions {
  double seconds = 5;  ///< of reading
  double rate = 100;   ///< Hz
  bool move = false;   ///< each joint that takes positions goes a little way and back, one after the other
  double distance = 0.05;                             ///< of that, rad or m
  std::function<bool()> stop = [] { return false; };  ///< asked in each cycle; ends the trial in good order
};

/// One state during the trial.
struct TriedState {
  std::string name;
  double first = 0, last = 0, least = 0, most = 0;  ///< of the finite values; NaN if there was none
  double finite = 0;                                ///< share of the reads at which it was known
  double changes_per_second = 0;
};

struct Trial {
  std::string driver;
  std::map<std::string, std::string> parameters;
  bool passed = false, moved = false, stopped = false;
  std::string failure;  ///< which step failed, and why
  std::string summary;  ///< what the driver says of the device
  std::string reason;   ///< what it complains of at the end, though nothing failed
  double configure_ms = 0;
  std::uint64_t reads = 0, late = 0;
  double read_us_p50 = 0, read_us_p99 = 0, read_us_max = 0;  ///< how long a read took
  double write_us_p99 = 0;                                   ///< 0 without moving
  double gap_ms_p50 = 0, gap_ms_p99 = 0, gap_ms_max = 0;     ///< between two news from the device
  std::vector<TriedState> states;
};

/// Takes the component through its life. A component that is real is activated only to move. Never throws.
Trial try_driver(hardware::Component& component, const hardware::ComponentContext& context,
                 const TrialOptions& options);

/// What an expert wants to see first: rates, losses, temperatures, voltages; lines of text.
std::vector<std::string> highlights(const Trial& trial);

/// Facts of the machine that go with a report.
struct TrialSetting {
  std::string version, kernel, proof, time;
  bool preempt_rt = false;
};
/// The report, as YAML.
std::string report(const Trial& trial, const TrialSetting& setting);

}  // namespace polyarm::doctor
