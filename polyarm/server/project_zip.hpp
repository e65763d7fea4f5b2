#pragma once
/// A project as one zip, and back.
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/base/bounds.hpp"

namespace polyarm::server {

/// More is neither packed nor unpacked.
inline constexpr std::size_t kMostZipped = bounds::kZipBytes, kMostUnzipped = bounds::kUnzippedBytes,
                             kMostZippedFiles = bounds::kZipFiles;

/// Was the command built with libzip?
bool can_zip();
/// All regular files of the folder but hidden ones (.state, .git), links and secrets (base/secrets.hpp). Throws Error("no-zip"
/// | "too-large").
std::string zip_of(const std::filesystem::path& folder);
/// Unpacks into a folder that must not be there yet: whole or not at all. Throws Error("bad-zip") for what is
/// no zip, a name that leads out of the folder or is hidden, or too much of it; Error("native-code") for
/// libraries and programs; Error("exists").
void unzip_into(std::string_view zip, const std::filesystem::path& folder);

}  // namespace polyarm::server
