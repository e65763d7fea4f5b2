#pragma once
/// Uploads of clients leave room on the disk for everything else: logs, versions, other programs.
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::cell {

/// Throws Error("no-space") if so many more bytes in the folder would leave less than `least` bytes free. A
/// file system that does not say how much is free has room.
inline void require_free_space(const std::filesystem::path& folder, std::uintmax_t bytes,
                               std::uintmax_t least = bounds::kFreeBytes) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error || (space.available >= bytes && space.available - bytes >= least)) return;
  throw Error("no-space",
              "the disk has " + std::to_string(space.available >> 20) + " MiB free, of which uploads leave " +
                  std::to_string(least >> 20) + " MiB",
              "delete files that nobody needs");
}

}  // namespace polyarm::cell
