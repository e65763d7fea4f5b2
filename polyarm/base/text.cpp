#include "polyarm/base/text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <utility>

#include "polyarm/base/bounds.hpp"

namespace polyarm {

namespace {
char lower_ascii(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// Optimal string alignment distance, case ignored: insert, delete, replace and swap of neighbours cost one.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower_ascii(a[i - 1]) == lower_ascii(b[j - 1]);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && lower_ascii(a[i - 1]) == lower_ascii(b[j - 2]) &&
          lower_ascii(a[i - 2]) == lower_ascii(b[j - 1]))
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}
}  // namespace

std::string_view trim(std::string_view s) {
  const auto first = s.find_first_not_of(" \t\r\n\f\v");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t\r\n\f\v") - first + 1);
}

std::string lower(std::string_view s) {
  std::string out(s);
  std::transform(out.begin(), out.end(), out.begin(), lower_ascii);
  return out;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(),
                                            [](char x, char y) { return lower_ascii(x) == lower_ascii(y); });
}

std::vector<std::string> split_words(std::string_view s, std::string_view separators) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < s.size();) {
    const auto first = s.find_first_not_of(separators, at);
    if (first == std::string_view::npos) break;
    const auto last = std::min(s.find_first_of(separators, first), s.size());
    out.emplace_back(s.substr(first, last - first));
    at = last;
  }
  return out;
}

std::vector<std::string> split_fields(std::string_view s, char separator) {
  std::vector<std::string> out;
  for (;;) {
    const auto end = s.find(separator);
    out.emplace_back(trim(s.substr(0, end)));
    if (end == std::string_view::npos) return out;
    s.remove_prefix(end + 1);
  }
}

std::optional<double> parse_number(std::string_view s) {
  s = trim(s);
  if (s.starts_with('+')) s.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), value);
  if (s.empty() || error != std::errc{} || end != s.data() + s.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::string format_number(double value) {
  constexpr double kSmall = 1e-4, kLarge = 1e15;  // an exponent only beyond them: 100000, not 1e+05
  const double size = std::abs(value);
  char text[32];
  const auto result = size >= kSmall && size < kLarge
                          ? std::to_chars(text, text + sizeof text, value, std::chars_format::fixed)
                          : std::to_chars(text, text + sizeof text, value);
  return {text, result.ptr};
}

namespace {
/// The shortest candidate that goes on where `wrong` ends; null: none does, or `wrong` is too short to tell.
const std::string* completion(std::string_view wrong, std::span<const std::string> candidates) {
  constexpr std::size_t kLeast = 3;
  const std::string* best = nullptr;
  if (wrong.size() < kLeast) return best;
  for (const std::string& candidate : candidates) {
    const bool begins = candidate.size() > wrong.size() &&
                        equal_ignoring_case(std::string_view(candidate).substr(0, wrong.size()), wrong);
    if (begins && (!best || candidate.size() < best->size())) best = &candidate;
  }
  return best;
}

/// The text with Latin letters instead of Cyrillic and Greek ones that look the same.
std::string in_latin(std::string_view text) {
  static constexpr std::pair<std::string_view, char> kAlike[] = {
      {"\u0410", 'A'}, {"\u0412", 'B'}, {"\u0415", 'E'}, {"\u041a", 'K'}, {"\u041c", 'M'}, {"\u041d", 'H'},
      {"\u041e", 'O'}, {"\u0420", 'P'}, {"\u0421", 'C'}, {"\u0422", 'T'}, {"\u0425", 'X'}, {"\u0430", 'a'},
      {"\u0435", 'e'}, {"\u043e", 'o'}, {"\u0440", 'p'}, {"\u0441", 'c'}, {"\u0443", 'y'}, {"\u0445", 'x'},
      {"\u0456", 'i'}, {"\u0391", 'A'}, {"\u0392", 'B'}, {"\u0395", 'E'}, {"\u0396", 'Z'}, {"\u0397", 'H'},
      {"\u0399", 'I'}, {"\u039a", 'K'}, {"\u039c", 'M'}, {"\u039d", 'N'}, {"\u039f", 'O'}, {"\u03a1", 'P'},
      {"\u03a4", 'T'}, {"\u03a5", 'Y'}, {"\u03a7", 'X'}, {"\u03bf", 'o'}};
  std::string out;
  for (std::size_t i = 0; i < text.size() && text.size() <= bounds::kSuggestedBytes;) {
    const auto alike = std::find_if(std::begin(kAlike), std::end(kAlike),
                                    [&](const auto& each) { return text.substr(i).starts_with(each.first); });
    const bool found = alike != std::end(kAlike);
    out += found ? alike->second : text[i];
    i += found ? alike->first.size() : 1;
  }
  return out.empty() ? std::string(text) : out;
}

/// True if the names differ in case, '_', '-' and blanks only.
bool same_letters(std::string_view a, std::string_view b) {
  const auto next = [](std::string_view& text) {
    text.remove_prefix(std::min(text.find_first_not_of("_- "), text.size()));
    if (text.empty()) return '\0';
    const char out = text.front();
    text.remove_prefix(1);
    return out >= 'A' && out <= 'Z' ? static_cast<char>(out | 0x20) : out;
  };
  for (;;) {
    const char x = next(a), y = next(b);
    if (x != y) return false;
    if (x == '\0') return true;
  }
}

/// Of names such as MAKER/MODEL the last part, where `wrong` has one part only.
std::string_view comparable(std::string_view candidate, std::string_view wrong) {
  const auto slash = candidate.rfind('/');
  return slash == std::string_view::npos || wrong.find('/') != std::string_view::npos
             ? candidate
             : candidate.substr(slash + 1);
}
}  // namespace

std::optional<std::string> nearest_name(std::string_view wrong, std::span<const std::string> candidates) {
  constexpr std::size_t kLongest = bounds::kSuggestedBytes, kMostLookedAt = bounds::kSuggestedNames;
  constexpr std::size_t kMostCells = 4'000'000;  // of edit distances: names of 20 letters, ten thousand times
  std::size_t cells = 0;
  const std::string* best = nullptr;
  if (wrong.size() > kLongest) return std::nullopt;
  // A name of one letter has nothing in common with another one.
  std::size_t best_distance = wrong.size() < 2 ? 1 : std::max<std::size_t>(1, wrong.size() / 3) + 1;
  for (const std::string& candidate : candidates.first(std::min(candidates.size(), kMostLookedAt))) {
    for (const std::string_view name : {std::string_view(candidate), comparable(candidate, wrong)}) {
      if (cells > kMostCells) break;
      if (name != wrong && same_letters(name, wrong)) return candidate;
      const std::size_t apart = std::max(name.size(), wrong.size()) - std::min(name.size(), wrong.size());
      if (apart < best_distance) cells += wrong.size() * name.size();
      const std::size_t distance = apart < best_distance ? edit_distance(wrong, name) : best_distance;
      if (distance >= best_distance) continue;
      best = &candidate;
      best_distance = distance;
    }
  }
  // One slip of the pen is likelier than a name that was not written to its end; two are not.
  if (best_distance > 1)
    if (const std::string* whole = completion(wrong, candidates)) return *whole;
  if (best) return *best;
  return std::nullopt;
}

std::string did_you_mean(std::string_view wrong, std::span<const std::string> candidates) {
  if (const std::string latin = in_latin(wrong); latin != wrong)
    if (const auto same = std::find(candidates.begin(), candidates.end(), latin); same != candidates.end())
      return "; did you mean '" + *same + "', in Latin letters?";
  const auto name = nearest_name(wrong, candidates);
  return name && *name != wrong ? "; did you mean '" + *name + "'?" : std::string{};
}

std::string join(std::span<const std::string> items, std::string_view separator) {
  std::string out;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) out += separator;
    out += items[i];
  }
  return out;
}

}  // namespace polyarm
