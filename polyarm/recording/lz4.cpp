#include "polyarm/recording/lz4.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace polyarm::recording {

namespace {

constexpr unsigned kHashBits = 14;
constexpr std::size_t kShortestMatch = 4, kFarthest = 65535;
constexpr std::size_t kLastLiterals = 5, kLastMatch = 12;  // the format requires these distances to a block's
                                                           // end
constexpr std::size_t kLargestBlock = 4u << 20;
constexpr std::uint8_t kFlags = 0x60, kBlockSize = 0x70;  // version 1, independent blocks of up to 4 MiB

/// xxHash32 with seed 0 for less than 16 bytes, no 4-byte words: the checksum of the frame's header.
constexpr std::uint32_t header_hash(std::uint8_t a, std::uint8_t b) {
  constexpr std::uint32_t p1 = 2654435761u, p2 = 2246822519u, p3 = 3266489917u, p5 = 374761393u;
  std::uint32_t h = p5 + 2;
  for (const std::uint8_t byte : {a, b}) h = std::rotl(h + byte * p5, 11) * p1;
  h = (h ^ (h >> 15)) * p2;
  h = (h ^ (h >> 13)) * p3;
  return h ^ (h >> 16);
}

std::uint32_t word(const std::byte* at) {
  std::uint32_t out;
  std::memcpy(&out, at, 4);
  return out;
}
std::uint32_t hash(std::uint32_t four_bytes) {
  return (four_bytes * 2654435761u) >> (32 - kHashBits);
}

void put_word(std::vector<std::byte>& out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i)));
}

/// The part of a length that does not fit into its half of the token.
void put_rest(std::vector<std::byte>& out, std::size_t rest) {
  for (; rest >= 255; rest -= 255) out.push_back(std::byte{255});
  out.push_back(static_cast<std::byte>(rest));
}

/// Literals, followed by a match if `match` is not 0.
void put_sequence(std::vector<std::byte>& out, std::span<const std::byte> literals, std::size_t offset,
                  std::size_t match) {
  const std::size_t extra = match > 0 ? match - kShortestMatch : 0;
  out.push_back(static_cast<std::byte>((std::min<std::size_t>(literals.size(), 15) << 4) |
                                       std::min<std::size_t>(extra, 15)));
  if (literals.size() >= 15) put_rest(out, literals.size() - 15);
  out.insert(out.end(), literals.begin(), literals.end());
  if (match == 0) return;
  out.push_back(static_cast<std::byte>(offset));
  out.push_back(static_cast<std::byte>(offset >> 8));
  if (extra >= 15) put_rest(out, extra - 15);
}

std::size_t common_length(const std::byte* a, const std::byte* b, const std::byte* end) {
  const std::byte* const from = b;
  while (b + 8 <= end) {
    std::uint64_t x, y;
    std::memcpy(&x, a, 8);
    std::memcpy(&y, b, 8);
    if (x != y) break;
    a += 8, b += 8;
  }
  while (b < end && *a == *b) ++a, ++b;
  return static_cast<std::size_t>(b - from);
}

}  // namespace

Lz4Compressor::Lz4Compressor() : places_(std::size_t{1} << kHashBits) {}

void Lz4Compressor::compress(std::span<const std::byte> data, std::vector<std::byte>& out) {
  put_word(out, 0x184D2204);
  for (const std::uint8_t byte :
       {kFlags, kBlockSize, static_cast<std::uint8_t>(header_hash(kFlags, kBlockSize) >> 8)})
    out.push_back(std::byte{byte});
  for (; !data.empty(); data = data.subspan(std::min(data.size(), kLargestBlock))) {
    const auto part = data.first(std::min(data.size(), kLargestBlock));
    block_.clear();
    add_block(part, block_);
    const bool smaller = block_.size() < part.size();
    put_word(out, static_cast<std::uint32_t>(smaller ? block_.size() : part.size() | 0x80000000u));
    const std::span<const std::byte> stored = smaller ? std::span<const std::byte>(block_) : part;
    out.insert(out.end(), stored.begin(), stored.end());
  }
  put_word(out, 0);
}

/// Greedy: for each position, only the last position with the same four bytes is tried. Steps grow while
/// nothing matches.
void Lz4Compressor::add_block(std::span<const std::byte> data, std::vector<std::byte>& out) {
  std::fill(places_.begin(), places_.end(), 0);
  const std::byte* const from = data.data();
  std::size_t done = 0, at = 0;
  const std::size_t last = data.size() > kLastMatch ? data.size() - kLastMatch : 0;
  while (at < last) {
    std::uint32_t& place = places_[hash(word(from + at))];
    const std::size_t there = place;
    place = static_cast<std::uint32_t>(at + 1);
    const bool fits = there > 0 && at - (there - 1) <= kFarthest && word(from + there - 1) == word(from + at);
    if (!fits) {
      at += 1 + ((at - done) >> 6);
      continue;
    }
    const std::size_t length = common_length(from + there - 1, from + at, from + data.size() - kLastLiterals);
    put_sequence(out, data.subspan(done, at - done), at - (there - 1), length);
    at += length;
    done = at;
    if (at < last) places_[hash(word(from + at - 2))] = static_cast<std::uint32_t>(at - 1);
  }
  put_sequence(out, data.subspan(done), 0, 0);
}

}  // namespace polyarm::recording
