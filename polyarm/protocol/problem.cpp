#include "polyarm/protocol/problem.hpp"

#include <cmath>
#include <string_view>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"

namespace polyarm::protocol {

namespace {
/// A problem may quote a wrong value of any length.
std::string clipped(const std::string& text) {
  if (text.size() <= bounds::kErrorTextBytes) return text;
  const std::string_view cut = std::string_view(text).substr(0, bounds::kErrorTextBytes);
  return std::string(cut.substr(0, whole_characters(cut))) + " …";
}
}  // namespace

FactValues fact_values(const polyarm::Facts& facts) {
  FactValues out;
  for (const Fact& fact : facts) {
    if (const std::string* text = std::get_if<std::string>(&fact.value))
      out[fact.name] = clipped(*text);
    else if (const double number = std::get<double>(fact.value); std::isfinite(number))
      out[fact.name] = number;
  }
  return out;
}

std::optional<FactValues> facts_of(const Problem& problem) {
  if (problem.facts.empty()) return std::nullopt;
  return fact_values(problem.facts);
}

ProblemFacts problem_facts(const Problem& problem) {
  return {problem.code, clipped(problem.what), clipped(problem.advice), clipped(problem.where.text()),
          facts_of(problem)};
}

}  // namespace polyarm::protocol
