#pragma once
/// Files, read whole and replaced atomically.
#include <filesystem>
#include <string>
#include <string_view>

namespace polyarm {

/// The whole file. Throws Error("no-file" | "unreadable") that names it.
std::string read_file(const std::filesystem::path& path);

/// Replaces the file's content so that at any moment, also after a kill or a power cut, it is either all old
/// or all new: writes a temporary neighbour, flushes it to disk, renames it over. Throws Error("unwritable").
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

}  // namespace polyarm
