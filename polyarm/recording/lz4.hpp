#pragma once
/// LZ4 compression in the form that MCAP uses for chunks: one frame. Source: the LZ4 block and frame format
/// descriptions 1.6.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace polyarm::recording {

/// Appends one frame with `data` to `out`. Equal data give equal bytes on every machine. One thread.
class Lz4Compressor {
 public:
  Lz4Compressor();
  void compress(std::span<const std::byte> data, std::vector<std::byte>& out);

 private:
  void add_block(std::span<const std::byte> data, std::vector<std::byte>& out);
  std::vector<std::uint32_t> places_;  ///< by hash: the last position of these four bytes, + 1
  std::vector<std::byte> block_;
};

}  // namespace polyarm::recording
