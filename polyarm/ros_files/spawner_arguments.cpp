#include "polyarm/ros_files/spawner_arguments.hpp"

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/launch/launch_substitution.hpp"
#include "polyarm/ros_files/parameter_file.hpp"

namespace polyarm::ros_files {

namespace {
const std::vector<std::string> kStopped = {"--stopped", "--inactive", "--load-only"};
const std::vector<std::string> kWithValue = {"--namespace",
                                             "-n",
                                             "--timeout",
                                             "-t",
                                             "--wait-for",
                                             "--shutdown-timeout",
                                             "-c",
                                             "--controller-manager",
                                             "--switch-timeout"};

bool among(const std::vector<std::string>& list, const std::string& option) {
  return std::find(list.begin(), list.end(), option) != list.end();
}
}  // namespace

SpawnerArguments read_spawner_arguments(std::string_view args) {
  SpawnerArguments out;
  const std::vector<std::string> words = shell_words(args);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto sign = words[i].find('=');
    const std::string option = words[i].substr(0, sign);
    if (!words[i].starts_with('-')) {
      if (words[i].find(":=") == std::string::npos) out.names.push_back(words[i]);
    } else if (among(kStopped, option)) {
      out.stopped = true;
    } else if (among(kWithValue, option)) {
      const bool inside = sign != std::string::npos;
      if (!inside && i + 1 >= words.size())
        throw Error("bad-value", "'" + option + "' of the spawner has no value", "write it behind");
      const std::string value = inside ? words[i].substr(sign + 1) : words[++i];
      if (option == "--namespace" || option == "-n") out.ns = value;
    } else if (option != "--no-timeout") {
      out.unknown.push_back(option);
    }
  }
  return out;
}

std::string spawner_option_hint(const std::string& option) {
  std::vector<std::string> known = kStopped;
  known.insert(known.end(), kWithValue.begin(), kWithValue.end());
  known.push_back("--no-timeout");
  return did_you_mean(option, known);
}

std::string resolve_name(const std::string& ns, const std::string& name) {
  std::vector<std::string> path = name.starts_with('/') ? std::vector<std::string>{} : split_name(ns);
  for (std::string& part : split_name(name)) {
    if (part.starts_with('~')) part.erase(0, 1);
    if (!part.empty()) path.push_back(std::move(part));
  }
  return join_name(path);
}

}  // namespace polyarm::ros_files
