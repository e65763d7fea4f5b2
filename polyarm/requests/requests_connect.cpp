/// Switches a cell from simulation to the real hardware that its files name, and back.
#include <algorithm>
#include <filesystem>
#include <memory>

#include "polyarm/base/text.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/protocol/projects.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// The parts of the cell that connecting needs.
struct ConnectOwners {
  const CellSetup& setup;
  const Arming& arming;
  LifeCycle& life;
};

/// The device files that a driver opens, by the parameters that name them.
std::vector<DeviceFacts> devices_of(const NamedHardware& hardware, const hardware::DriverFacts* facts) {
  std::vector<DeviceFacts> out;
  std::map<std::string, std::string> values = hardware.parameters;
  if (facts)
    for (const hardware::DriverParameter& each : facts->parameters)
      if (each.kind == hardware::ParameterKind::text && each.fallback)
        values.emplace(each.name, each.fallback);
  std::error_code error;
  for (const auto& [name, value] : values)
    if (value.starts_with("/dev/")) out.push_back({name, value, std::filesystem::exists(value, error)});
  return out;
}

/// The hardware that would be connected, with its drivers and their device files.
std::vector<RealHardware> found_in(const ConnectOwners& cell) {
  std::vector<RealHardware> out;
  for (const NamedHardware& each : named_real_hardware(cell.setup.robots)) {
    const auto component = hardware::make_driver(each.driver);
    const hardware::DriverFacts* facts = component->facts();
    out.push_back({each.robot, each.component, each.driver, facts ? facts->drives : "", devices_of(each, facts)});
  }
  return out;
}

/// Why the hardware cannot be connected; empty if connecting may be tried.
std::optional<Error> refusal(const ConnectOwners& cell, const std::vector<RealHardware>& found) {
  if (cell.setup.options.lock_step)
    return Error("real-and-fast", "real hardware has its own time, this cell runs in lock-step",
                 "run it without --fast");
  if (found.empty()) {
    std::vector<std::string> robots;
    for (const auto& robot : cell.setup.robots)
      robots.push_back("'" + robot->entry.name + "' is '" + robot->entry.hardware + "'");
    return Error("no-real-hardware", "the cell names no real hardware: " + join(robots, ", "),
                 "name the driver in cell.yaml ('hardware: feetech'); polyarm drivers lists them");
  }
  for (const RealHardware& each : found)
    for (const DeviceFacts& device : each.devices)
      if (!device.there)
        return Error("no-device",
                     "'" + device.path + "' does not exist; it connects '" + each.component + "' (" +
                         each.driver + ")",
                     "plug it in and switch it on, or correct '" + device.parameter + "' in cell.yaml");
  return std::nullopt;
}

CellConnect::Answer cell_connect(const ConnectOwners& cell, const CellConnect& request) {
  CellConnect::Answer answer;
  answer.real = cell.arming.needed();
  answer.hardware = found_in(cell);
  const std::optional<Error> why = refusal(cell, answer.hardware);
  answer.possible = !why;
  answer.why = why ? why->problems().front().what : "";
  answer.advice = why ? why->problems().front().advice : "";
  if (why) answer.problem.emplace(protocol::problem_facts(why->problems().front()));
  if (!request.real) return answer;
  if (*request.real == answer.real)
    throw Error("connected-already", answer.real ? "the cell drives its real hardware already"
                                                 : "the cell is simulated already");
  if (*request.real && why) throw *why;
  RestartRequest wish;
  wish.real = request.real;
  cell.life.request_restart(std::move(wish));
  answer.asked = *request.real ? "real" : "simulated";
  return answer;
}

}  // namespace

std::vector<Handler> connect_handlers() {
  return handlers<cell_connect>();
}

}  // namespace polyarm::cell
