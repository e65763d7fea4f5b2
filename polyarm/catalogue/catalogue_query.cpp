#include "polyarm/catalogue/catalogue_query.hpp"

#include <algorithm>
#include <cctype>
#include <functional>
#include <map>
#include <set>

#include "polyarm/base/text.hpp"

namespace polyarm::description {

namespace {

double number_of(std::string_view text, std::string_view whole, const std::string& what,
                 Dimension dimension) {
  if (const auto value = parse_quantity(trim(text), dimension)) return *value;
  throw Error(
      "bad-range", what + ": '" + std::string(whole) + "' is not a range",
      "write a number, '4..6', '>=1.2' or '<500' (in quotes, so that the shell leaves > and < alone)");
}

/// For comparing makers: "Universal Robots", "universal_robots" and "universal robots" are equal.
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text)
    if (c != ' ' && c != '_' && c != '-')
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string folder_of(const CatalogueEntry& robot) {
  return robot.name.substr(0, robot.name.find('/'));
}

void check_maker(const std::vector<CatalogueEntry>& all, const std::string& wanted) {
  std::set<std::string> makers;
  for (const CatalogueEntry& robot : all) {
    if (plain(robot.maker) == plain(wanted) || plain(folder_of(robot)) == plain(wanted)) return;
    makers.insert(folder_of(robot));
  }
  const std::vector<std::string> names(makers.begin(), makers.end());
  throw Error("unknown-maker", "the catalogue has no robot of '" + wanted + "'" + did_you_mean(wanted, names),
              "makers: " + join(names, ", "));
}

bool within(const std::optional<Range>& range, const std::optional<double>& value) {
  return !range || (value && range->contains(*value));
}

bool wanted(const CatalogueEntry& robot, const CatalogueQuery& query) {
  const std::string text = lower(query.text);
  return (lower(robot.name).find(text) != std::string::npos ||
          lower(robot.model).find(text) != std::string::npos) &&
         (query.maker.empty() || plain(robot.maker) == plain(query.maker) ||
          plain(folder_of(robot)) == plain(query.maker)) &&
         within(query.axes, robot.axes) && within(query.reach_m, robot.reach_m) &&
         within(query.payload_kg, robot.payload_kg) && within(query.mass_kg, robot.mass_kg);
}

using Key = std::function<double(const CatalogueEntry&)>;

/// The sort keys. Robots without the figure come last in both orders.
const std::map<std::string, Key>& sort_keys() {
  static const std::map<std::string, Key> keys = {
      {"axes", [](const CatalogueEntry& r) { return r.axes; }},
      {"reach", [](const CatalogueEntry& r) { return r.reach_m.value_or(-1); }},
      {"payload", [](const CatalogueEntry& r) { return r.payload_kg.value_or(-1); }},
      {"mass", [](const CatalogueEntry& r) { return r.mass_kg.value_or(-1); }},
  };
  return keys;
}

void sort_by(std::vector<CatalogueEntry>& robots, const std::string& order) {
  const bool down = order.starts_with('-');
  const std::string name = order.substr(down ? 1 : 0);
  std::sort(robots.begin(), robots.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  if (name == "name" || name == "maker") {
    if (down) std::reverse(robots.begin(), robots.end());
    return;
  }
  const auto key = sort_keys().find(name);
  if (key == sort_keys().end()) {
    const std::vector<std::string> known{"name", "maker", "axes", "reach", "payload", "mass"};
    throw Error("bad-sort", "robots cannot be sorted by '" + name + "'" + did_you_mean(name, known),
                "name, maker, axes, reach, payload or mass; with - before it, the largest first");
  }
  std::stable_sort(robots.begin(), robots.end(), [&](const auto& a, const auto& b) {
    const double x = key->second(a), y = key->second(b);
    if ((x < 0) != (y < 0)) return y < 0;
    return down ? x > y : x < y;
  });
}

}  // namespace

bool Range::contains(double value) const {
  return (without_low ? value > low : value >= low - 1e-9) &&
         (without_high ? value < high : value <= high + 1e-9);
}

Range parse_range(std::string_view text, const std::string& what, Dimension dimension, BareNumber bare) {
  const std::string_view whole = trim(text);
  const auto number = [&](std::string_view part) { return number_of(part, whole, what, dimension); };
  Range out;
  if (const std::size_t dots = whole.find(".."); dots != std::string_view::npos) {
    out.low = number(whole.substr(0, dots));
    out.high = number(whole.substr(dots + 2));
    if (out.low > out.high)
      throw Error("bad-range", what + ": '" + std::string(whole) + "' ends before it begins",
                  "write the smaller number first");
  } else if (whole.starts_with(">=")) {
    out.low = number(whole.substr(2));
  } else if (whole.starts_with("<=")) {
    out.high = number(whole.substr(2));
  } else if (whole.starts_with('>')) {
    out.low = number(whole.substr(1));
    out.without_low = true;
  } else if (whole.starts_with('<')) {
    out.high = number(whole.substr(1));
    out.without_high = true;
  } else if (whole.starts_with('=')) {
    out.low = out.high = number(whole.substr(1));
  } else {
    out.low = number(whole);
    if (bare == BareNumber::exactly) out.high = out.low;
  }
  return out;
}

std::vector<CatalogueEntry> find_robots(std::vector<CatalogueEntry> all, const CatalogueQuery& query) {
  if (!query.maker.empty()) check_maker(all, query.maker);
  std::erase_if(all, [&](const CatalogueEntry& robot) { return !wanted(robot, query); });
  sort_by(all, query.sort);
  return all;
}

}  // namespace polyarm::description
