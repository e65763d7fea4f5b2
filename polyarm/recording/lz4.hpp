#pragma once
/// LZ4 frames, the compression of MCAP's chunks, by liblz4.
#include <cstddef>
#include <span>
#include <vector>

namespace polyarm::recording {

/// Appends one frame that holds `data` to `out`. Equal data give equal bytes with the same liblz4. Any thread.
/// Throws std::runtime_error if memory runs out.
void add_lz4_frame(std::span<const std::byte> data, std::vector<std::byte>& out);

}  // namespace polyarm::recording
