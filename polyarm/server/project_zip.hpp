#pragma once
/// Packs a project into a zip file, and unpacks one.
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/base/bounds.hpp"

namespace polyarm::server {

/// Limits for packing and unpacking.
inline constexpr std::size_t kMostZipped = bounds::kZipBytes, kMostUnzipped = bounds::kUnzippedBytes,
                             kMostZippedFiles = bounds::kZipFiles;

/// Packs all regular files of the folder except hidden files (.state, .git), links and secrets
/// (base/secrets.hpp). Throws Error("too-large" | "bad-zip").
std::string zip_of(const std::filesystem::path& folder);
/// The place of a project with this name beside the folder of the running cell. Throws Error("too-many") if
/// there are bounds::kProjects folders.
std::filesystem::path place_beside(const std::filesystem::path& folder, const std::string& name);
/// Unpacks into a new folder, completely or not at all. Throws Error("bad-zip") if the data is not a zip, is
/// too large, or has a name that is hidden or leads out of the folder; Error("native-code") for libraries and
/// programs; Error("exists") if the folder exists.
void unzip_into(std::string_view zip, const std::filesystem::path& folder);

}  // namespace polyarm::server
