#pragma once
/// Opens shared libraries with a plugin table, checks them, and creates their objects.
#include <filesystem>
#include <memory>
#include <string_view>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/plugin.hpp"

namespace polyarm::hardware {

/// Opens the library, which then stays open, and checks its table: versions, ABI, complete entries, and the
/// layout of hardware. Throws Error("plugin-refused") with the file, the reason and what to do, and closes
/// the library. Opening runs code of the library.
const PluginTable& open_plugin(const std::filesystem::path& file);
/// The same for a library that was read before: runs exactly these bytes, whatever the file contains now.
/// Does not find libraries in the file's folder.
const PluginTable& open_plugin(const std::filesystem::path& file, std::string_view bytes);

/// A new component of the entry. Throws Error("plugin-failed") if the factory throws or returns null.
std::unique_ptr<Component> make_component(const PluginEntry& entry, const std::filesystem::path& file);

}  // namespace polyarm::hardware
