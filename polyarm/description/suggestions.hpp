#pragma once
/// Suggests the nearest names for the first wrong names of a file. Each is compared with every known name, so a file
/// with ten thousand of either would take seconds; a person needs no more. Private to the room.
#include <concepts>
#include <string>
#include <string_view>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::description {

class Suggestions {
 public:
  /// As did_you_mean(). `names` may be a function that returns them.
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
