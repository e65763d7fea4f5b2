#pragma once
/// Files, read whole and replaced atomically. What a cell may reach is asked of reach(): base/reach.hpp.
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace polyarm {

/// More than this is not read into memory.
inline constexpr std::size_t kLargestFile = std::size_t{512} << 20;

/// The whole file, at most `most` bytes. Throws Error that names it: "no-file"; "not-a-file" for a pipe, a
/// device or a socket, which are never waited for; "too-large"; "unreadable"; "outside-cell".
std::string read_file(const std::filesystem::path& path, std::size_t most = kLargestFile);

/// Replaces the file's content so that at any moment, also after a kill or a power cut, it is either all old
/// or all new: writes a temporary neighbour, flushes it to disk, renames it over. Throws Error("unwritable" |
/// "not-a-file" | "outside-cell").
/// A new file gets `mode`; one that is there keeps its own.
void write_file_atomically(const std::filesystem::path& path, std::string_view content,
                           unsigned mode = 0644);

/// Removes the temporary neighbours that processes left which were killed while they wrote. Not recursive.
void sweep_temporaries(const std::filesystem::path& folder);

}  // namespace polyarm
