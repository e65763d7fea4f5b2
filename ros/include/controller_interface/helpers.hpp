#pragma once
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "hardware_interface/helpers.hpp"

namespace controller_interface {

/// Appends to `out` those of `all` that `names` lists, in its order; true if all were found. As in Humble and
/// Jazzy it allocates if `out` has no room for them; a controller of Rolling has reserved it.
template <typename T>
bool get_ordered_interfaces(std::vector<T>& all, const std::vector<std::string>& names,
                            const std::string& type, std::vector<std::reference_wrapper<T>>& out) {
  out.reserve(names.size());
  for (const std::string& name : names)
    for (T& each : all) {
      const std::string& whole = each.get_name();
      const bool same =
          type.empty() ? whole == name
                       : whole.size() == name.size() + 1 + type.size() &&
                             whole.compare(0, name.size(), name) == 0 && whole[name.size()] == '/' &&
                             whole.compare(name.size() + 1, std::string::npos, type) == 0;
      if (same) out.push_back(std::ref(each));
    }
  return out.size() == names.size();
}
inline bool interface_list_contains_interface_type(const std::vector<std::string>& all,
                                                   const std::string& type) {
  return std::find(all.begin(), all.end(), type) != all.end();
}

}  // namespace controller_interface
