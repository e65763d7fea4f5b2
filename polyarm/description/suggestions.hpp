#pragma once
/// Suggests the nearest names, but only for the first unknown names of a file. Each unknown name is compared
/// with every known name, so a file with ten thousand of either would take seconds. Private to the room.
#include <concepts>
#include <string>
#include <string_view>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::description {

class Suggestions {
 public:
  /// Works like did_you_mean(). `names` may be a function that returns the names.
  template <class Names>
  std::string operator()(std::string_view wrong, const Names& names) {
    if (given_ >= bounds::kSuggestions) return {};
    ++given_;
    if constexpr (std::invocable<const Names&>)
      return did_you_mean(wrong, names());
    else
      return did_you_mean(wrong, names);
  }

 private:
  std::size_t given_ = 0;
};

}  // namespace polyarm::description
