#include "polyarm/ros_files/python_spawners.hpp"

#include <algorithm>
#include <set>

namespace polyarm::ros_files::python {

Spawned spawned_by_spawner(const Value& arguments) {
  static const std::set<std::string> kInactive = {"--inactive", "--stopped", "--load-only"};
  static const std::set<std::string> kAlone = {"-u", "--unload-on-kill", "--activate-as-group",
                                               "--switch-asap", "--no-switch-asap"};
  Spawned out;
  out.known = arguments.kind == Value::Kind::list;
  bool active = true;
  for (std::size_t i = 0; i < arguments.items.size(); ++i) {
    const std::string word = flat(arguments.items[i]);
    const bool option = word.starts_with("-");
    active = active && !kInactive.contains(word);
    if (option && !kInactive.contains(word) && !kAlone.contains(word)) ++i;  // its value
    if (option) continue;
    if (has_gap(word))
      out.known = false;
    else
      out.names.push_back(word);
  }
  if (!active) out.names.clear();
  return out;
}

Spawned spawned_by_command(const Value& cmd) {
  Spawned out;
  const std::string text = flat(cmd, " ");
  const std::vector<std::string> words = split_words(text);
  if (std::find(words.begin(), words.end(), "load_controller") == words.end()) return out;
  out.known = !has_gap(text);
  const auto active = [](const std::string& word) { return word == "active" || word == "start"; };
  if (out.known && std::any_of(words.begin(), words.end(), active) && !words.back().starts_with("-"))
    out.names.push_back(words.back());
  return out;
}

}  // namespace polyarm::ros_files::python
