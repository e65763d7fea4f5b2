#include "polyarm/io/breakpoints.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {
namespace {

constexpr std::size_t kMostPairs = 1'000'000;  ///< limit of the full comparison

/// Longest common subsequence of the differing parts of two texts; [i]: index of line i in `b`, or -1.
std::vector<int> common_lines(const std::vector<std::string_view>& a,
                              const std::vector<std::string_view>& b) {
  std::vector<int> out(a.size(), -1);
  if (a.empty() || b.empty() || a.size() * b.size() > kMostPairs) return out;
  const std::size_t width = b.size() + 1;
  std::vector<std::uint32_t> longest((a.size() + 1) * width, 0);
  for (std::size_t i = a.size(); i-- > 0;)
    for (std::size_t j = b.size(); j-- > 0;)
      longest[i * width + j] = a[i] == b[j]
                                   ? longest[(i + 1) * width + j + 1] + 1
                                   : std::max(longest[(i + 1) * width + j], longest[i * width + j + 1]);
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i] == b[j]) {
      out[i++] = static_cast<int>(j++);
    } else if (longest[(i + 1) * width + j] >= longest[i * width + j + 1]) {
      ++i;
    } else {
      ++j;
    }
  }
  return out;
}

/// Lines between two matched ones: if both texts have the same number there, they were changed in place.
void pair_changed(std::vector<int>& at, std::size_t after_size) {
  int before = 0;  // index after the last matched line
  for (std::size_t i = 0; i < at.size();) {
    if (at[i] >= 0) {
      before = at[i++] + 1;
      continue;
    }
    std::size_t end = i;
    while (end < at.size() && at[end] < 0) ++end;
    const int next = end < at.size() ? at[end] : static_cast<int>(after_size);
    const bool as_many = next - before == static_cast<int>(end - i);
    for (std::size_t k = i; as_many && k < end; ++k) at[k] = before + static_cast<int>(k - i);
    i = end;
  }
}

/// A line that is in both texts but not in the common subsequence was moved: takes the nearest equal line.
void find_moved(std::vector<int>& at, const std::vector<int>& common, const std::vector<std::string_view>& a,
                const std::vector<std::string_view>& b) {
  std::vector<bool> free(b.size(), true);
  for (const int place : common)
    if (place >= 0) free[static_cast<std::size_t>(place)] = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (common[i] >= 0 || a[i].empty()) continue;
    std::size_t nearest = b.size();
    for (std::size_t j = 0; j < b.size(); ++j) {
      const auto off = [i](std::size_t place) { return place > i ? place - i : i - place; };
      if (free[j] && a[i] == b[j] && (nearest == b.size() || off(j) < off(nearest))) nearest = j;
    }
    if (nearest == b.size()) continue;
    at[i] = static_cast<int>(nearest);
    free[nearest] = false;
  }
}

}  // namespace

std::vector<int> where_lines_are(const TextLines& before, const TextLines& after) {
  std::vector<std::string_view> a(before.size()), b(after.size());
  std::transform(before.begin(), before.end(), a.begin(), [](const std::string& line) { return trim(line); });
  std::transform(after.begin(), after.end(), b.begin(), [](const std::string& line) { return trim(line); });
  const std::size_t least = std::min(a.size(), b.size());
  std::size_t head = 0, tail = 0;
  while (head < least && a[head] == b[head]) ++head;
  while (tail < least - head && a[a.size() - 1 - tail] == b[b.size() - 1 - tail]) ++tail;
  const auto between = [&](const std::vector<std::string_view>& lines) {
    return std::vector<std::string_view>(lines.begin() + static_cast<std::ptrdiff_t>(head),
                                         lines.end() - static_cast<std::ptrdiff_t>(tail));
  };
  const std::vector<std::string_view> old = between(a), now = between(b);
  const std::vector<int> common = common_lines(old, now);
  std::vector<int> middle = common;
  pair_changed(middle, now.size());
  if (old.size() * now.size() <= kMostPairs) find_moved(middle, common, old, now);
  std::vector<int> out(a.size(), 0);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (i < head)
      out[i] = static_cast<int>(i) + 1;
    else if (i >= a.size() - tail)
      out[i] = static_cast<int>(i + b.size() - a.size()) + 1;
    else if (middle[i - head] >= 0)
      out[i] = static_cast<int>(head) + middle[i - head] + 1;
  }
  return out;
}

void FileBreakpoints::add(int line) {
  const auto at = std::lower_bound(lines.begin(), lines.end(), line);
  if (at == lines.end() || *at != line) lines.insert(at, line);
}

void FileBreakpoints::drop(int line) {
  lines.erase(std::remove(lines.begin(), lines.end(), line), lines.end());
}

void FileBreakpoints::follow(TextLines now) {
  if (text) {
    const std::vector<int> moved = where_lines_are(*text, now);
    const std::vector<int> before = std::exchange(lines, {});
    for (const int line : before)
      if (line >= 1 && line <= static_cast<int>(moved.size()) &&
          moved[static_cast<std::size_t>(line - 1)] > 0)
        add(moved[static_cast<std::size_t>(line - 1)]);
  }
  text = std::move(now);
}

FileBreakpoints* Breakpoints::find(const std::string& file) {
  const auto at =
      std::find_if(files_.begin(), files_.end(), [&](const auto& each) { return each.file == file; });
  return at == files_.end() ? nullptr : &*at;
}

FileBreakpoints& Breakpoints::of(const std::string& file) {
  if (FileBreakpoints* there = find(file)) return *there;
  files_.push_back({file});
  return files_.back();
}

std::vector<Location> Breakpoints::all() const {
  std::vector<Location> out;
  for (const FileBreakpoints& each : files_)
    for (const int line : each.lines) out.push_back({each.file, line, 0});
  return out;
}

}  // namespace polyarm::cell
