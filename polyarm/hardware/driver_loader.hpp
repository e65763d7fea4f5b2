#pragma once
/// Finds hardware drivers by name: linked-in drivers, those of plugins, and Polyarm's own drivers in shared
/// libraries `polyarm_driver_<name>.so`, which are loaded on demand.
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::hardware {

/// Makes a component; a driver registers one under its name ("mock", "mujoco", "acme/Arm"). May throw Error.
using ComponentFactory = std::function<std::unique_ptr<Component>()>;

/// Registers the driver under `name`, replacing an earlier one. Call before any cell is built.
void register_driver(const std::string& name, ComponentFactory factory);
/// A new component of the driver. Searches the registered drivers, then `polyarm_driver_<name>.so` in the
/// folders of POLYARM_DRIVERS (separated by ':'), beside the executable, in its `drivers` folder and in
/// `../lib/polyarm`. Throws Error("unknown-driver" | "plugin-refused" | "plugin-failed").
std::unique_ptr<Component> make_driver(const std::string& name);
/// True if make_driver() would find it.
bool driver_available(const std::string& name);
/// All driver names, for hints.
std::vector<std::string> driver_names();
/// The error for a name that make_driver() does not find.
Problem unknown_driver(const std::string& name);
/// Folders searched for driver libraries, in order; some may not exist.
std::vector<std::filesystem::path> driver_folders();

}  // namespace polyarm::hardware
