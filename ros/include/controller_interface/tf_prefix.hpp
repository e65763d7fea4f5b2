#pragma once
#include <string>

namespace controller_interface {
/// The prefix of frame names: "~" is the node's namespace; without a slash in front, with one at the end.
inline std::string resolve_tf_prefix(std::string prefix, const std::string& name_space) {
  if (prefix.empty()) return prefix;
  if (const auto at = prefix.find('~'); at != std::string::npos) prefix.replace(at, 1, name_space);
  if (prefix.empty() || prefix.back() != '/') prefix += '/';
  return prefix.front() == '/' ? prefix.substr(1) : prefix;
}
}  // namespace controller_interface
