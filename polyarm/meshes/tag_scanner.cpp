#include "polyarm/meshes/tag_scanner.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/printable.hpp"

namespace polyarm::meshes {

namespace {

constexpr std::string_view kSpaces = " \t\r\n";
constexpr std::size_t kMostAttributes = bounds::kTagAttributes;

std::string_view without_prefix(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

}  // namespace

int TagScanner::line() const {
  return 1 + static_cast<int>(
                 std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(begin_), '\n'));
}

void TagScanner::refuse(const std::string& why) const {
  throw Error("bad-mesh", "the mesh " + name_ + ":" + std::to_string(line()) + ": " + why, "export it again");
}

void TagScanner::skip_past(std::string_view end) {
  const std::size_t found = text_.find(end, at_);
  if (found == std::string_view::npos) refuse("a tag does not end");
  at_ = found + end.size();
}

bool TagScanner::next() {
  for (;;) {
    begin_ = std::min(text_.find('<', at_), text_.size());
    at_ = begin_;
    if (at_ == text_.size()) return false;
    const std::string_view rest = text_.substr(at_);
    if (rest.starts_with("<!--")) {
      skip_past("-->");
    } else if (rest.starts_with("<?")) {
      skip_past("?>");
    } else if (rest.starts_with("<![CDATA[")) {
      skip_past("]]>");
    } else if (rest.starts_with("<!")) {
      refuse("it has a document type, which is not read");
    } else {
      break;
    }
  }
  skip_past(">");
  std::string_view inside = text_.substr(begin_ + 1, at_ - begin_ - 2);
  opens_ = !inside.starts_with('/');
  closes_ = !opens_ || inside.ends_with('/');
  if (!opens_) inside.remove_prefix(1);
  if (opens_ && closes_) inside.remove_suffix(1);
  const std::size_t end = std::min(inside.find_first_of(kSpaces), inside.size());
  element_ = without_prefix(inside.substr(0, end));
  attributes_.clear();
  if (opens_) read_attributes(inside.substr(end));
  return true;
}

void TagScanner::read_attributes(std::string_view inside) {
  for (;;) {
    const std::size_t begin = inside.find_first_not_of(kSpaces);
    if (begin == std::string_view::npos) return;
    inside.remove_prefix(begin);
    const std::size_t equal = inside.find('=');
    if (equal == std::string_view::npos || attributes_.size() >= kMostAttributes) refuse("a tag is damaged");
    std::string_view name = inside.substr(0, equal);
    name = name.substr(0, name.find_last_not_of(kSpaces) + 1);
    const std::size_t open = inside.find_first_not_of(kSpaces, equal + 1);
    if (open == std::string_view::npos || (inside[open] != '"' && inside[open] != '\''))
      refuse("a tag is damaged");
    const std::size_t close = inside.find(inside[open], open + 1);
    if (close == std::string_view::npos) refuse("a tag is damaged");
    attributes_.emplace_back(without_prefix(name), inside.substr(open + 1, close - open - 1));
    inside.remove_prefix(close + 1);
  }
}

std::string_view TagScanner::attribute(std::string_view name) const {
  for (const auto& [key, value] : attributes_)
    if (key == name) return value;
  return {};
}

double TagScanner::number(std::string_view name, std::optional<double> fallback) const {
  std::string_view text = attribute(name);
  if (text.empty() && fallback) return *fallback;
  if (text.starts_with('+')) text.remove_prefix(1);
  double out = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (wrong != std::errc() || end != text.data() + text.size() || !std::isfinite(out))
    refuse("'" + shortened(text) + "' is not a number");
  return out;
}

}  // namespace polyarm::meshes
