#pragma once
/// Finds the files that belong to Polyarm itself: drivers, helper programs, the catalogue, examples. They are
/// found from where the running program is, never from where it was built, so that an installation may be
/// moved. Any thread; reads the disk.
#include <filesystem>
#include <string_view>
#include <vector>

namespace polyarm::installation {

/// A program that is not the command, such as Python, names the installation to use: `prefix` holds
/// `lib/polyarm` and `share/polyarm`, or is a build folder with `drivers`. Searched before the program's own
/// folders. Call it before other threads start.
void use(const std::filesystem::path& prefix);

/// The folders of modules and helper programs, in search order: for each of the installation named by `use`,
/// the file that contains `code` (an address in a module; may be null) and the executable: its folder,
/// `drivers` in it, `drivers` beside it, and `../lib/polyarm`. Folders need not exist; each is listed once.
std::vector<std::filesystem::path> program_folders(const void* code = nullptr);

/// The existing folders `name` ("robots") or `share/polyarm/name` in the installation named by `use`, and in
/// the executable's folder or at most four folders above it. Only folders that contain `proof` count.
std::vector<std::filesystem::path> data_folders(std::string_view name, std::string_view proof);

}  // namespace polyarm::installation
