#pragma once
/// Problems and facts as they appear in answers and events. Any thread.
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "polyarm/base/error.hpp"
#include "polyarm/protocol/members.hpp"

namespace polyarm::protocol {

/// The variable parts of a sentence, by name: texts and numbers.
using FactValues = std::map<std::string, std::variant<std::string, double>>;

struct ProblemFacts {
  std::string code, what, advice, where;
  std::optional<FactValues> facts;  ///< the variable parts of `what`
  POLYARM_MEMBERS(ProblemFacts, code, what, advice, where, facts)
};

/// Texts are cut to bounds::kErrorTextBytes; NaN and infinite numbers are left out.
FactValues fact_values(const polyarm::Facts& facts);
/// Empty if there are none, so that messages leave them out.
std::optional<FactValues> facts_of(const Problem& problem);
/// Without `facts` if the problem has none. Texts are cut as above.
ProblemFacts problem_facts(const Problem& problem);

}  // namespace polyarm::protocol
