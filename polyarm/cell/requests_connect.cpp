/// From simulation to the real hardware that a cell names, and back.
#include <algorithm>
#include <filesystem>
#include <memory>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/problem_json.hpp"
#include "polyarm/cell/requests_work.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/driver_loader.hpp"

namespace polyarm::cell {

namespace {

/// A file of the system that a driver opens, by the parameter that names it.
struct Device {
  std::string parameter, path;
  bool there;
};

std::vector<Device> devices_of(const NamedHardware& hardware, const hardware::DriverFacts* facts) {
  std::vector<Device> out;
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

/// What would be connected, each with its driver and the devices that it opens.
struct Found {
  NamedHardware hardware;
  std::string drives;
  std::vector<Device> devices;
};

std::vector<Found> found_in(Cell& cell) {
  std::vector<Found> out;
  for (NamedHardware& each : named_real_hardware(cell.robots())) {
    const auto component = hardware::make_driver(each.driver);
    const hardware::DriverFacts* facts = component->facts();
    Found found{each, facts ? facts->drives : "", devices_of(each, facts)};
    out.push_back(std::move(found));
  }
  return out;
}

/// Why it cannot be connected, in one sentence; nothing where it may be tried.
std::optional<Error> refusal(Cell& cell, const std::vector<Found>& found) {
  if (cell.lock_step())
    return Error("real-and-fast", "real hardware has its own time, this cell runs in lock-step",
                 "run it without --fast");
  if (found.empty()) {
    std::vector<std::string> robots;
    for (const auto& robot : cell.robots())
      robots.push_back("'" + robot->entry.name + "' is '" + robot->entry.hardware + "'");
    return Error("no-real-hardware", "the cell names no real hardware: " + join(robots, ", "),
                 "name the driver in cell.yaml ('hardware: feetech'); polyarm drivers lists them");
  }
  for (const Found& each : found)
    for (const Device& device : each.devices)
      if (!device.there)
        return Error("no-device",
                     "'" + device.path + "' is not there, by which '" + each.hardware.component + "' (" +
                         each.hardware.driver + ") is reached",
                     "plug it in and switch it on, or correct '" + device.parameter + "' in cell.yaml");
  return std::nullopt;
}

Json connect_json(Cell& cell, const std::vector<Found>& found) {
  Json hardware = Json::array();
  for (const Found& each : found) {
    Json devices = Json::array();
    for (const Device& device : each.devices)
      devices.push_back({{"parameter", device.parameter}, {"path", device.path}, {"there", device.there}});
    hardware.push_back({{"robot", each.hardware.robot},
                        {"component", each.hardware.component},
                        {"driver", each.hardware.driver},
                        {"drives", each.drives},
                        {"devices", std::move(devices)}});
  }
  const std::optional<Error> why = refusal(cell, found);
  return {{"real", cell.arming().needed()},
          {"hardware", std::move(hardware)},
          {"possible", !why},
          {"why", why ? why->problems().front().what : ""},
          {"advice", why ? why->problems().front().advice : ""},
          {"problem", why ? problem_json(why->problems().front()) : Json()}};
}

Poll cell_connect(Cell& cell, const Json& arguments) {
  const std::vector<Found> found = found_in(cell);
  Json answer = connect_json(cell, found);
  if (!arguments.contains("real") || arguments["real"].is_null()) return at_once(std::move(answer));
  const bool real = flag_argument(arguments, "real");
  if (real == cell.arming().needed())
    throw Error("connected-already",
                real ? "the cell drives its real hardware already" : "the cell is simulated already");
  if (real)
    if (const auto why = refusal(cell, found)) throw *why;
  RestartWish wish;
  wish.real = real;
  cell.ask_restart(std::move(wish));
  answer["asked"] = real ? "real" : "simulated";
  return at_once(std::move(answer));
}

}  // namespace

const std::vector<RequestRow>& connect_rows() {
  static const std::vector<RequestRow> table = {
      {{"cell.connect",
        {{"real", kFlag}},
        "{real, hardware: [{robot, component, driver, drives, devices: [{parameter, path, there}]}], "
        "possible, "
        "why, advice, problem, asked}",
        "without `real`: what real hardware the cell names, and whether it can be connected; with it: build "
        "the "
        "cell anew, on that hardware, held and disarmed, or simulated",
        true},
       cell_connect},
  };
  return table;
}

}  // namespace polyarm::cell
