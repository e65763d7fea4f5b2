#pragma once
/// The same validators under the names of Humble's releases.
#include "rsl/algorithm.hpp"
#include "rsl/parameter_validators.hpp"

namespace parameter_traits {
using namespace ::rsl;
using Result = tl::expected<void, std::string>;
inline Result OK;
template <typename... Words>
Result ERROR(const std::string& text, const Words&...) {
  return tl::make_unexpected(text);
}
}  // namespace parameter_traits
