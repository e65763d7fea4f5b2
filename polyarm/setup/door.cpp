#include "polyarm/setup/door.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/setup/door_kinds.hpp"

namespace polyarm::cell {

namespace {
std::vector<DoorKind>& kinds() {
  static std::vector<DoorKind> all;
  return all;
}
}  // namespace

void register_door(DoorKind kind) {
  kinds().push_back(std::move(kind));
}
const std::vector<DoorKind>& door_kinds() {
  return kinds();
}

std::unique_ptr<Door> open_door(const std::string& name, CellView& cell, const DoorOptions& options) {
  for (const std::filesystem::path& folder : hardware::driver_folders()) {
    const std::filesystem::path path = folder / ("polyarm_door_" + name + ".so");
    std::error_code error;
    if (!std::filesystem::exists(path, error)) continue;
    void* const module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);  // stays loaded
    if (!module) throw Error("no-door", path.string() + " cannot be loaded: " + ::dlerror());
    const auto make = reinterpret_cast<MakeDoor>(::dlsym(module, "polyarm_open_door"));
    if (!make) throw Error("no-door", path.string() + " is not a door of Polyarm");
    return std::unique_ptr<Door>(make(cell, options));
  }
  std::string advice;
  for (const DoorKind& kind : door_kinds())
    if (kind.name == name) advice = kind.advice;
  throw Error("no-door", "the module polyarm_door_" + name + ".so is not installed", advice);
}

}  // namespace polyarm::cell
