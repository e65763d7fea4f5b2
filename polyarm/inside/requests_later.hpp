#pragma once
/// File paths of the project in requests.
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

/// Resolves a path relative to the cell's folder. Throws Error("bad-path") if the path leads outside the
/// folder, is hidden, or has an extension that project files do not use.
std::filesystem::path project_file(const std::filesystem::path& folder, const std::string& path);
/// Replaces a file of the project, and keeps the text before as a version. Throws as project_file does, and
/// Error("too-many") if the project has no room for one more.
void write_project_file(const std::filesystem::path& folder, const std::string& path,
                        const std::string& text);
/// Keeps the folder .state, which stays with this machine, out of version control.
void keep_out_of_git(const std::filesystem::path& folder);
/// 16 hexadecimal digits that identify contents; not for security.
std::string content_hash(std::string_view text);

}  // namespace polyarm::cell
