#include "polyarm/sweeps/robot_choice.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <optional>

#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/there.hpp"

namespace polyarm::sweeps {

namespace {

using description::CatalogueEntry;

struct Property {
  const char* name;
  Dimension dimension;
  std::optional<double> (*of)(const CatalogueEntry&);
};
constexpr Property kProperties[] = {
    {"payload", Dimension::mass, [](const CatalogueEntry& e) { return e.payload_kg; }},
    {"reach", Dimension::length, [](const CatalogueEntry& e) { return e.reach_m; }},
    {"mass", Dimension::mass, [](const CatalogueEntry& e) { return e.mass_kg; }},
    {"axes", Dimension::none, [](const CatalogueEntry& e) { return std::optional<double>(e.axes); }},
};

constexpr std::array<const char*, 5> kComparisons{">=", "<=", "==", ">", "<"};

bool compare(double a, const std::string& comparison, double b) {
  if (comparison == ">=") return a >= b;
  if (comparison == "<=") return a <= b;
  if (comparison == ">") return a > b;
  if (comparison == "<") return a < b;
  return a == b;
}

using Test = std::function<bool(const CatalogueEntry&)>;

/// "payload >= 5kg"
Test comparison(const std::string& text, const Location& where) {
  const char* const advice = "for example payload >= 5kg and reach < 900mm and axes == 6";
  for (const char* sign : kComparisons) {
    const auto at = text.find(sign);
    if (at == std::string::npos) continue;
    const std::string name(trim(text.substr(0, at))),
        value(trim(text.substr(at + std::string_view(sign).size())));
    std::vector<std::string> names;
    for (const Property& property : kProperties) {
      names.emplace_back(property.name);
      if (name != property.name) continue;
      const auto number = parse_quantity(value, property.dimension);
      if (!number)
        throw Error(Problem{"bad-condition", where, "'" + value + "' is no value for " + name, advice});
      return [&property, sign, number](const CatalogueEntry& entry) {
        const auto own = property.of(entry);  // a robot whose value is not known is not chosen
        return own && compare(*own, sign, *number);
      };
    }
    throw Error(Problem{"bad-condition", where,
                        "the catalogue has no '" + name + "' of robots" + did_you_mean(name, names),
                        "payload, reach, mass or axes"});
  }
  throw Error(Problem{"bad-condition", where, "'" + text + "' compares nothing", advice});
}

/// Comparisons joined by "and".
Test condition(const std::string& text, const Location& where) {
  std::vector<Test> tests;
  std::string part;
  for (const std::string& word : split_words(text + " and")) {
    if (word != "and") {
      part += (part.empty() ? "" : " ") + word;
      continue;
    }
    tests.push_back(comparison(part, where));
    part.clear();
  }
  return [tests](const CatalogueEntry& entry) {
    return std::all_of(tests.begin(), tests.end(), [&](const Test& test) { return test(entry); });
  };
}

Test pattern(const std::string& text) {
  return [text](const CatalogueEntry& entry) {
    const std::string model = entry.name.substr(entry.name.find('/') + 1);
    return ::fnmatch(text.c_str(), entry.name.c_str(), 0) == 0 ||
           ::fnmatch(text.c_str(), model.c_str(), 0) == 0;
  };
}

}  // namespace

std::vector<std::string> choose_robots(const std::string& text, const std::vector<CatalogueEntry>& catalogue,
                                       const std::string& folder, const Location& where) {
  const std::filesystem::path file = std::filesystem::path(folder) / text;
  if (is_file(file)) return {file.string()};
  const bool compares = text.find_first_of("<>=") != std::string::npos;
  const Test test = compares ? condition(text, where) : pattern(text);
  std::vector<std::string> out, names;
  for (const CatalogueEntry& entry : catalogue) {
    if (test(entry)) out.push_back(entry.name);
    names.push_back(entry.name);
  }
  if (!out.empty()) return out;
  throw Error(Problem{"unknown-robot", where,
                      "no robot of the catalogue is meant by '" + text + "'" +
                          (compares ? std::string() : did_you_mean(text, names)),
                      "polyarm robots lists them; a pattern is like 'ur*' or 'abb/*'"});
}

}  // namespace polyarm::sweeps
