#pragma once
/// A problem as answers and events have it. Any thread.
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "polyarm/base/error.hpp"
#include "polyarm/protocol/members.hpp"

namespace polyarm::protocol {

/// What a sentence contains, by name: a text or a number.
using FactValues = std::map<std::string, std::variant<std::string, double>>;

struct ProblemFacts {
  std::string code, what, advice, where;
  std::optional<FactValues> facts;  ///< what `what` contains
  POLYARM_MEMBERS(ProblemFacts, code, what, advice, where, facts)
};

/// Texts are clipped to bounds::kErrorTextBytes; numbers that are not finite are left out.
FactValues fact_values(const polyarm::Facts& facts);
/// Without `facts` if the problem has none; texts are clipped as above.
ProblemFacts problem_facts(const Problem& problem);

}  // namespace polyarm::protocol
