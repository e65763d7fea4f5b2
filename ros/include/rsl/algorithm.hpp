#pragma once
#include <algorithm>
#include <set>

namespace rsl {
template <typename Collection>
bool contains(const Collection& all, const typename Collection::value_type& value) {
  return std::find(all.begin(), all.end(), value) != all.end();
}
template <typename Collection>
bool is_unique(const Collection& all) {
  return std::set<typename Collection::value_type>(all.begin(), all.end()).size() == all.size();
}
}  // namespace rsl
