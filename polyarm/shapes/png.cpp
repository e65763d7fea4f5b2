#include <zlib.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "polyarm/shapes/render.hpp"

/// Writes PNG with a palette. Source: W3C's Portable Network Graphics specification, third edition.
namespace polyarm::shapes {

namespace {

using Color = std::array<std::uint8_t, 4>;

void number(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift);
}

void chunk(std::string& out, const std::string& type, const std::string& data) {
  number(out, static_cast<std::uint32_t>(data.size()));
  const std::string body = type + data;
  out += body;
  number(out, static_cast<std::uint32_t>(
                  crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

struct Count {
  Color color;
  std::size_t pixels;
};

/// Chooses colours by median cut: repeatedly halves the box of colours with the longest side.
std::vector<Color> palette_of(std::vector<Count> counts, std::size_t most) {
  struct Part {
    std::size_t from, to;
  };
  std::vector<Part> parts{{0, counts.size()}};
  const auto longest = [&](const Part& part) {
    std::pair<int, std::size_t> out{-1, 0};
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [low, high] =
          std::minmax_element(counts.begin() + static_cast<std::ptrdiff_t>(part.from),
                              counts.begin() + static_cast<std::ptrdiff_t>(part.to),
                              [&](const Count& a, const Count& b) { return a.color[k] < b.color[k]; });
      out = std::max(out, std::pair{high->color[k] - low->color[k], k});
    }
    return out;
  };
  while (parts.size() < most) {
    const auto widest = std::max_element(parts.begin(), parts.end(), [&](const Part& a, const Part& b) {
      return longest(a).first < longest(b).first;
    });
    const auto [size, k] = longest(*widest);
    if (size <= 0) break;
    const Part part = *widest;
    const auto begin = counts.begin() + static_cast<std::ptrdiff_t>(part.from),
               end = counts.begin() + static_cast<std::ptrdiff_t>(part.to);
    std::sort(begin, end, [k = k](const Count& a, const Count& b) {
      return std::tie(a.color[k], a.color) < std::tie(b.color[k], b.color);
    });
    const std::size_t middle = std::max<std::size_t>(1, (part.to - part.from) / 2);
    widest->to = part.from + middle;
    parts.push_back({part.from + middle, part.to});
  }
  std::vector<Color> out;
  for (const Part& part : parts) {
    std::array<std::size_t, 4> sum{};
    std::size_t pixels = 0;
    for (std::size_t i = part.from; i < part.to; ++i) {
      pixels += counts[i].pixels;
      for (std::size_t k = 0; k < 4; ++k) sum[k] += counts[i].pixels * counts[i].color[k];
    }
    Color mean{};
    for (std::size_t k = 0; k < 4; ++k) mean[k] = static_cast<std::uint8_t>((sum[k] + pixels / 2) / pixels);
    out.push_back(mean);
  }
  return out;
}

std::size_t nearest(const std::vector<Color>& palette, const Color& color) {
  std::size_t best = 0;
  int least = 1 << 30;
  for (std::size_t i = 0; i < palette.size(); ++i) {
    int d = 0;
    for (std::size_t k = 0; k < 4; ++k) d += (palette[i][k] - color[k]) * (palette[i][k] - color[k]);
    if (d < least) least = d, best = i;
  }
  return best;
}

}  // namespace

std::string png(const Picture& picture, int colors) {
  std::map<Color, std::size_t> seen;
  const auto pixels = static_cast<std::size_t>(picture.width * picture.height);
  const auto pixel = [&](std::size_t i) {
    Color out;
    std::copy_n(&picture.rgba[4 * i], 4, out.begin());
    return out[3] == 0 ? Color{} : out;
  };
  for (std::size_t i = 0; i < pixels; ++i) ++seen[pixel(i)];
  std::vector<Count> counts;
  for (const auto& [color, count] : seen) counts.push_back({color, count});
  const auto palette = palette_of(counts, static_cast<std::size_t>(std::clamp(colors, 2, 256)));
  std::map<Color, std::uint8_t> index;
  for (const auto& [color, count] : seen) index[color] = static_cast<std::uint8_t>(nearest(palette, color));
  std::string rows;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (i % static_cast<std::size_t>(picture.width) == 0) rows += '\0';  // no filter
    rows += static_cast<char>(index[pixel(i)]);
  }
  uLongf size = compressBound(static_cast<uLong>(rows.size()));
  std::string packed(size, '\0');
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
            static_cast<uLong>(rows.size()), 9);
  packed.resize(size);
  std::string out("\x89PNG\r\n\x1a\n", 8), header, plte, alpha;
  number(header, static_cast<std::uint32_t>(picture.width));
  number(header, static_cast<std::uint32_t>(picture.height));
  header += std::string("\x08\x03\x00\x00\x00", 5);
  for (const Color& color : palette) {
    plte.append(reinterpret_cast<const char*>(color.data()), 3);
    alpha += static_cast<char>(color[3]);
  }
  chunk(out, "IHDR", header);
  chunk(out, "PLTE", plte);
  chunk(out, "tRNS", alpha);
  chunk(out, "IDAT", packed);
  chunk(out, "IEND", {});
  return out;
}

}  // namespace polyarm::shapes
