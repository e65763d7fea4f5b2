#include "polyarm/cell/door.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/driver_loader.hpp"

namespace polyarm::cell {

std::unique_ptr<Door> open_door(const std::string& name, Cell& cell, const DoorOptions& options) {
  for (const std::filesystem::path& folder : hardware::driver_folders()) {
    const std::filesystem::path path = folder / ("polyarm_door_" + name + ".so");
    std::error_code error;
    if (!std::filesystem::exists(path, error)) continue;
    void* const module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);  // it stays until the process ends
    if (!module) throw Error("no-door", path.string() + " cannot be loaded: " + ::dlerror());
    const auto make = reinterpret_cast<MakeDoor>(::dlsym(module, "polyarm_open_door"));
    if (!make) throw Error("no-door", path.string() + " is no door of Polyarm");
    return std::unique_ptr<Door>(make(cell, options));
  }
  throw Error("no-door", "the module polyarm_door_" + name + ".so is not installed",
              name == "ros2" ? "install libfastrtps-dev and build again, or run without --ros2" : "");
}

}  // namespace polyarm::cell
