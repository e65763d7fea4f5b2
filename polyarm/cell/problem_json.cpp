#include "polyarm/cell/problem_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"

namespace polyarm::cell {

namespace {
/// A problem may quote what was wrong, however long that is.
std::string clipped(const std::string& text) {
  if (text.size() <= bounds::kErrorTextBytes) return text;
  const std::string_view cut = std::string_view(text).substr(0, bounds::kErrorTextBytes);
  return std::string(cut.substr(0, whole_characters(cut))) + " …";
}
}  // namespace

nlohmann::json facts_json(const Facts& facts) {
  nlohmann::json out = nlohmann::json::object();
  for (const Fact& fact : facts) {
    if (const std::string* text = std::get_if<std::string>(&fact.value))
      out[fact.name] = clipped(*text);
    else if (const double number = std::get<double>(fact.value); std::isfinite(number))
      out[fact.name] = number;
  }
  return out;
}

nlohmann::json problem_json(const Problem& problem) {
  nlohmann::json out{{"code", problem.code},
                     {"what", clipped(problem.what)},
                     {"advice", clipped(problem.advice)},
                     {"where", clipped(problem.where.text())}};
  if (!problem.facts.empty()) out["facts"] = facts_json(problem.facts);
  return out;
}

}  // namespace polyarm::cell
