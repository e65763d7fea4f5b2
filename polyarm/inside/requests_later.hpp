#pragma once
/// Files of the project, as requests name them.
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

/// A file of the project by its path in the cell's folder. Throws Error("bad-path") for one that would lead
/// out of it, is hidden, or is of no kind that a project has.
std::filesystem::path project_file(const std::filesystem::path& folder, const std::string& path);
/// 16 hexadecimal digits that tell contents apart; not for security.
std::string content_hash(std::string_view text);

}  // namespace polyarm::cell
