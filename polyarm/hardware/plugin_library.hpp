#pragma once
/// Shared libraries with a plugin's table: opened, judged, and asked for what they make.
#include <filesystem>
#include <memory>
#include <string_view>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/plugin.hpp"

namespace polyarm::hardware {

/// Opens the library, which then stays open, and judges its table: the versions, the ABI, that every entry is
/// whole, and the layout of hardware. Throws Error("plugin-refused") with the file, the reason and what to
/// do; then the library is closed. Code of the library runs when it is opened.
const PluginTable& open_plugin(const std::filesystem::path& file);
/// The same of a library that was read before: exactly these bytes run, whatever the file is now. It finds no
/// libraries beside itself.
const PluginTable& open_plugin(const std::filesystem::path& file, std::string_view bytes);

/// A new component of the entry. Throws Error("plugin-failed") when the factory throws or makes nothing.
std::unique_ptr<Component> make_component(const PluginEntry& entry, const std::filesystem::path& file);

}  // namespace polyarm::hardware
