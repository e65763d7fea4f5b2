#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/control/supervisor.hpp"
#include "polyarm/machine/fault_record.hpp"

namespace polyarm::apps {

namespace {

struct Turn {
  std::uint64_t cycle;
  std::string state, why;
};

/// Cycles at which the loop's state or a request changed.
std::vector<Turn> turns(const cell::RecordedCycles& recorded) {
  std::vector<Turn> out;
  std::string before;
  for (const auto& row : recorded.rows) {
    const auto cause = parse_number(row.cause).value_or(0);
    const std::string why = cause >= 0 && cause < control::kStopCauses && row.state != "running"
                                ? control::name(static_cast<control::StopCause>(static_cast<int>(cause)))
                                : "";
    const std::string now = row.state + (row.request == "none" ? "" : ", asked to " + row.request);
    if (now != before) out.push_back({row.cycle, now, why});
    before = now;
  }
  return out;
}

void print(const cell::Replay& replay) {
  const auto& rows = replay.recorded.rows;
  fmt::print("{}\n{} cycles, {} to {}\n", replay.problem, rows.size(), rows.front().cycle, rows.back().cycle);
  for (const Turn& turn : turns(replay.recorded))
    fmt::print("  cycle {:>8}  {}{}\n", turn.cycle, turn.state, turn.why.empty() ? "" : ": " + turn.why);
  fmt::print("the commands replayed on {}: largest difference of measured values\n", replay.driver);
  for (const cell::ReplayedJoint& joint : replay.joints)
    fmt::print("  {:<32} {:>12.6f}{}\n", joint.name, joint.worst,
               joint.worst > 0 ? fmt::format("  at cycle {}", joint.cycle) : "");
}

nlohmann::json json_of(const cell::Replay& replay) {
  nlohmann::json out{{"problem", replay.problem},
                     {"cycles", replay.recorded.rows.size()},
                     {"first_cycle", replay.recorded.rows.front().cycle},
                     {"driver", replay.driver},
                     {"turns", nlohmann::json::array()},
                     {"joints", nlohmann::json::array()}};
  for (const Turn& turn : turns(replay.recorded))
    out["turns"].push_back({{"cycle", turn.cycle}, {"state", turn.state}, {"why", turn.why}});
  for (const cell::ReplayedJoint& joint : replay.joints)
    out["joints"].push_back({{"name", joint.name}, {"worst", joint.worst}, {"cycle", joint.cycle}});
  return out;
}

}  // namespace

int run_replay(int argc, char** argv) {
  CommandLine app(
      "Replays the last cycles before a fault: the events, and the recorded commands on a simulated robot, "
      "compared with the measured values",
      "polyarm replay");
  std::string folder, hardware = "mock";
  bool json = false;
  app.add_option("folder", folder, "the folder that the fault message names: .state/faults/0001")->required();
  app.add_option("--hardware", hardware, "simulate the robot by mock or mujoco")->one_of({"mock", "mujoco"});
  app.add_flag("--json", json);
  app.footer(examples({"polyarm replay examples/r6bot/.state/faults/0001",
                       "polyarm replay .state/failures/0003 --hardware mujoco --json"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  const cell::Replay replay = cell::replay_record(folder, hardware);
  if (json)
    fmt::print("{}\n", json_of(replay).dump());
  else
    print(replay);
  return kOk;
}

}  // namespace polyarm::apps
