#include "polyarm/launch/python_spawners.hpp"

#include <algorithm>
#include <set>

namespace polyarm::ros_files::python {

namespace {

using Words = std::vector<std::string>;

/// Adds several words for a nested list, or for a text with blanks.
void add_words(const Value& value, Words& to, int depth = 0) {
  if (value.kind != Value::Kind::list || depth > kDeepest) {
    const std::string text = flat(value);
    const Words split = split_words(text);
    to.insert(to.end(), split.begin(), split.end());
    return;
  }
  to.push_back(flat(value));
}

Spawned spawned_by_words(const Words& words) {
  static const std::set<std::string> kInactive = {"--inactive", "--stopped", "--load-only"};
  static const std::set<std::string> kAlone = {"-u", "--unload-on-kill", "--activate-as-group",
                                               "--switch-asap", "--no-switch-asap"};
  Spawned out;
  bool active = true;
  for (std::size_t i = 0; i < words.size() && words[i] != "--ros-args"; ++i) {
    const std::string& word = words[i];
    const bool option = word.starts_with("-");
    active = active && !kInactive.contains(word);
    const bool with_value =
        option && !kInactive.contains(word) && !kAlone.contains(word) && word.find('=') == std::string::npos;
    if ((word == "-p" || word == "--param-file") && i + 1 < words.size() && !has_gap(words[i + 1]))
      out.files.push_back(words[i + 1]);
    if (with_value) ++i;
    if (option || word.find(":=") != std::string::npos) continue;  // remapped topics
    if (has_gap(word))
      out.known = false;
    else
      out.names.push_back(word);
  }
  if (!active) {
    out.names.clear();
    out.known = true;
  }
  return out;
}

/// The words after `ros2 control VERB`.
Spawned spawned_by_verb(const std::string& verb, const Words& words) {
  static const std::set<std::string> kWithValue = {
      "-c",      "--controller-manager", "--controller-manager-name", "--include-hidden-nodes", "--spin-time",
      "--filter"};
  Spawned out;
  Words names, switched;
  bool active = false, into_switched = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const bool state = word == "--set-state" || word == "--state";
    if (state && i + 1 < words.size()) {
      ++i;
      active = words[i] == "active" || words[i] == "start";
    } else if (kWithValue.contains(word)) {
      ++i;
    } else if (word.starts_with("-")) {
      into_switched = word == "--activate" || word == "--start" || word == "--start-controllers" ||
                      word == "--activate-controllers";
    } else {
      (into_switched ? switched : names).push_back(word);
    }
  }
  if (verb == "switch_controllers") names = switched;
  if (verb == "set_controller_state" && names.size() > 1) {
    active = names[1] == "active" || names[1] == "start";
    names.resize(1);
  }
  if (verb == "load_controller" && names.size() > 1) names.resize(1);  // a parameter file may follow
  if (verb != "switch_controllers" && !active) return out;
  for (const std::string& name : names)
    if (has_gap(name))
      out.known = false;
    else
      out.names.push_back(name);
  return out;
}

}  // namespace

Spawned spawned_by_spawner(const Value& arguments) {
  if (arguments.kind == Value::Kind::unknown ||
      (arguments.kind == Value::Kind::text && has_gap(arguments.text)))
    return {{}, {}, false};
  Words words;
  if (arguments.kind != Value::Kind::list) add_words(arguments, words);
  for (const Value& item : arguments.items) add_words(item, words);
  return spawned_by_words(words);
}

Spawned spawned_by_command(const Value& cmd) {
  const std::string text = flat(cmd, " ");
  Words words = split_words(text);
  const auto after = [&](std::vector<std::string>::iterator at) { return Words(at + 1, words.end()); };
  for (auto at = words.begin(); at != words.end(); ++at) {
    const bool control = at != words.begin() && *(at - 1) == "control";
    if (control && (*at == "load_controller" || *at == "set_controller_state" || *at == "switch_controllers"))
      return spawned_by_verb(*at, after(at));
    if (at != words.begin() && *(at - 1) == "controller_manager" && at->starts_with("spawner"))
      return spawned_by_words(after(at));
  }
  return {};
}

}  // namespace polyarm::ros_files::python
