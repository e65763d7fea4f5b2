#pragma once
/// Uploads of clients leave room on the disk for everything else: logs, versions, other programs. Any thread.
#include <cstdint>
#include <filesystem>

#include "polyarm/base/bounds.hpp"

namespace polyarm::cell {

/// Throws Error("no-space") if so many more bytes in the folder would leave less than `least` bytes free. A
/// file system that does not say how much is free has room.
void require_free_space(const std::filesystem::path& folder, std::uintmax_t bytes,
                        std::uintmax_t least = bounds::kFreeBytes);

}  // namespace polyarm::cell
