#pragma once
/// Files that can be made again, kept in a folder up to a number. Any thread.
#include <cstddef>
#include <filesystem>
#include <string_view>

namespace polyarm {

/// Writes `content` to `path` and makes its folder. Evicts the oldest files of the folder with the same
/// extension, so that at most `most` remain. Throws nothing: without the file its content is made again the
/// next time.
void store_in_cache(const std::filesystem::path& path, std::string_view content, std::size_t most,
                    unsigned mode);

}  // namespace polyarm
