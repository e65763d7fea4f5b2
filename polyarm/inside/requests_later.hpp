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
/// 16 hexadecimal digits that identify contents; not for security.
std::string content_hash(std::string_view text);

}  // namespace polyarm::cell
