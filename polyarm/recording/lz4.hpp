#pragma once
/// LZ4, as MCAP has its chunks: one frame. Source: the LZ4 block and frame format descriptions 1.6.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace polyarm::recording {

/// Appends a frame with `data` to `out`. The same data give the same bytes on every machine. One thread.
class Lz4Compressor {
 public:
  Lz4Compressor();
  void compress(std::span<const std::byte> data, std::vector<std::byte>& out);

 private:
  void add_block(std::span<const std::byte> data, std::vector<std::byte>& out);
  std::vector<std::uint32_t> places_;  ///< by hash: where the four bytes were last, + 1
  std::vector<std::byte> block_;
};

}  // namespace polyarm::recording
