#pragma once
/// Reads whole files and replaces files atomically. reach() (base/reach.hpp) decides what a cell may access.
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace polyarm {

/// Larger files are not read into memory.
inline constexpr std::size_t kLargestFile = std::size_t{512} << 20;

/// Reads the whole file, at most `most` bytes. Throws an Error that names the file: "no-file"; "not-a-file"
/// for a pipe, device or socket (it never waits for them); "too-large"; "unreadable"; "outside-cell".
std::string read_file(const std::filesystem::path& path, std::size_t most = kLargestFile);

/// Replaces the file's content. The file is always all old or all new, even after a kill or a power cut: the
/// function writes a temporary file beside it, flushes it to disk and renames it. A new file gets `mode`; an
/// existing file keeps its own. Throws Error("unwritable" | "not-a-file" | "outside-cell").
void write_file_atomically(const std::filesystem::path& path, std::string_view content,
                           unsigned mode = 0644);

/// Removes temporary files left by processes that were killed while writing. Not recursive.
void sweep_temporaries(const std::filesystem::path& folder);

}  // namespace polyarm
