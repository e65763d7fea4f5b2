#pragma once
/// Drivers by name: those linked in, and those in shared libraries `polyarm_driver_<name>.so`.
#include <memory>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::hardware {

/// Makes the driver known under `name` (linked in). Called before any cell is built.
void register_driver(const std::string& name, ComponentFactory factory);
/// A new component of the driver. Looks among the registered, then for `polyarm_driver_<name>.so` in the
/// folders of POLYARM_DRIVERS (separated by ':'), beside the executable, in its `drivers` folder and in
/// `../lib/polyarm`. Throws Error("unknown-driver" | "driver-not-loadable").
std::unique_ptr<Component> make_driver(const std::string& name);
/// True if make_driver would find it.
bool driver_available(const std::string& name);

}  // namespace polyarm::hardware
