#include "polyarm/yaml/yaml_repeats.hpp"

#include <map>
#include <string>

namespace polyarm {

namespace {
/// `left`: the number of nodes that may still be visited. It bounds the work, because aliases can multiply
/// nodes.
void check_node(const Yaml& node, Problems& problems, int& left) {
  if (--left < 0) return;
  std::map<std::string, int> lines;
  for (const Yaml::Entry& entry : node.entries()) {
    const auto [at, is_new] = lines.try_emplace(entry.key, entry.where.line);
    if (!is_new)
      problems.error("duplicate-name", entry.where,
                     "'" + entry.key + "' is defined twice, here and in line " + std::to_string(at->second),
                     "rename one of them, or take it away");
    check_node(entry.value, problems, left);
  }
  if (!node.is_list()) return;
  for (const Yaml& item : node.items()) check_node(item, problems, left);
}
}  // namespace

void check_repeats(const Yaml& node, Problems& problems) {
  int left = 100'000;
  check_node(node, problems, left);
}

}  // namespace polyarm
