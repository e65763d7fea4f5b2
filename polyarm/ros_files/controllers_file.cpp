#include "polyarm/ros_files/controllers_file.hpp"

#include <algorithm>
#include <functional>
#include <set>
#include <tuple>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/controller_entries.hpp"
#include "polyarm/ros_files/superseded_keys.hpp"

namespace polyarm::ros_files {

namespace {
using controllers::Parameters;
using Path = std::vector<std::string>;

const std::vector<std::string> kControllerKeys = {"type", "params_file", "fallback_controllers",
                                                  "node_options_args"};
constexpr const char* kTypeAdvice =
    "write 'type: PACKAGE/CLASS' there, such as joint_trajectory_controller/JointTrajectoryController";
constexpr std::size_t kMostGathered = 1'000'000;

bool is_wild(const std::string& name) {
  return name == "*" || name == "**";
}

struct ManagerName {
  Path ns;
  std::string name = "controller_manager";
  bool operator==(const ManagerName&) const = default;
};

/// The parameters of a node from several blocks. `own`: keys from blocks that name the node, not only from
/// wildcard blocks.
struct Gathered {
  Parameters parameters;
  std::set<std::string> own;
  bool has_block = false;
};

/// Combines the blocks of ROS 2 files: finds the managers, their controllers, and the parameters of each.
class Ros2Reader {
 public:
  Ros2Reader(ParameterSet& set, const ParameterSubstitution* substitution, ControllersFile& out,
             Problems& problems)
      : set_(set),
        substitution_(substitution),
        out_(out),
        problems_(&problems),
        used_(set.nodes.size(), false) {}

  void read() {
    for (const ManagerName& manager : managers()) read_manager_of(manager);
    lend_other_namespaces();
    std::erase_if(out_.controllers, [&](ControllerEntry& entry) {
      return !alone("the controller '" + entry.name + "' is left out: ", [&] { finish(entry); });
    });
    check_fallbacks();
  }

 private:
  std::vector<ManagerName> managers() const {
    std::vector<ManagerName> named, other;
    std::vector<Path> typed;  // namespaces of controllers whose own blocks give a type
    bool everywhere = false;
    const auto add = [](std::vector<ManagerName>& list, ManagerName manager) {
      if (std::find(list.begin(), list.end(), manager) == list.end()) list.push_back(std::move(manager));
    };
    for (const NodeParameters& node : set_.nodes) {
      if (node.path.empty()) continue;
      const Path ns(node.path.begin(), node.path.end() - 1);
      const bool wild = std::any_of(ns.begin(), ns.end(), is_wild) || is_wild(node.path.back());
      const bool is_manager = node.path.back() == "controller_manager";
      if (is_manager && !wild)
        add(named, {ns});
      else if (is_manager || (wild && says_manager(node)))
        everywhere = true;
      else if (declares_controllers(node))
        add(other, {ns, node.path.back()});
      else if (is_class_name(node.parameters.text("type")))
        wild ? void(everywhere = true) : typed.push_back(ns);
    }
    if (!named.empty()) return named;
    if (everywhere) return where_controllers_are();
    for (const Path& ns : typed)
      if (std::none_of(other.begin(), other.end(), [&](const ManagerName& m) { return m.ns == ns; }))
        add(other, {ns});
    return other;
  }

  static bool says_manager(const NodeParameters& node) {
    return declares_controllers(node) || (is_wild(node.path.back()) && node.parameters.has("update_rate"));
  }

  /// For a manager whose namespace is a wildcard: the namespaces in which controllers are named.
  std::vector<ManagerName> where_controllers_are() const {
    std::set<std::string> names;
    for (const NodeParameters& node : set_.nodes) {
      if (is_class_name(node.parameters.text("type"))) names.insert(node.path.back());
      for (const auto& [key, entry] : node.parameters.entries)
        if (key.ends_with(".type")) names.insert(key.substr(0, key.find('.')));
    }
    std::vector<ManagerName> out;
    for (const NodeParameters& node : set_.nodes) {
      const ManagerName manager{{node.path.begin(), node.path.end() - 1}};
      if (!names.contains(node.path.back()) || std::any_of(manager.ns.begin(), manager.ns.end(), is_wild))
        continue;
      if (std::find(out.begin(), out.end(), manager) == out.end()) out.push_back(manager);
    }
    if (out.empty()) out.push_back({});
    return out;
  }

  static bool declares_controllers(const NodeParameters& node) {
    return std::any_of(node.parameters.entries.begin(), node.parameters.entries.end(), [](const auto& item) {
      const auto dot = item.first.find('.');
      return dot != std::string::npos && item.first.substr(dot) == ".type" && !item.second.values.empty() &&
             is_class_name(item.second.values.front());
    });
  }

  Gathered gather(const Path& name, const std::vector<NodeParameters>& nodes, std::vector<bool>* used) {
    Gathered out;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!means_node(nodes[i].path, name)) continue;
      const bool own = !is_wild(nodes[i].path.back());
      if (own && used) (*used)[i] = true;
      out.has_block |= own;
      take(nodes[i].parameters, own, out);
    }
    return out;
  }

  void take(const Parameters& from, bool own, Gathered& out) {
    gathered_ += from.entries.size();
    if (gathered_ > kMostGathered)
      throw Error("yaml-size", "more than 1000000 parameters come together", "fewer controllers share '/**'");
    for (const auto& [key, entry] : from.entries) {
      out.parameters.entries[key] = entry;
      if (own) out.own.insert(key);
    }
  }

  void read_manager_of(const ManagerName& manager) {
    Path whole = manager.ns;
    whole.push_back(manager.name);
    const Gathered gathered = gather(whole, set_.nodes, &used_);
    const std::set<std::string> names = controller_names(manager, gathered);
    const auto is_controller = [&](const std::string& name) { return names.contains(name); };
    const auto is_own = [&](const std::string& key) { return gathered.own.contains(key); };
    ManagerParameters read =
        read_manager(gathered.parameters, is_controller, is_own, out_.unused, *problems_);
    read.ns = join_name(manager.ns);
    keep(read, gathered);
    for (const std::string& name : names)
      alone("the controller '" + name + "' is left out: ",
            [&] { controller(name, manager, gathered, names); });
  }

  void keep(const ManagerParameters& read, const Gathered& gathered) {
    if (out_.manager.ns.empty()) {
      out_.manager = read;
    } else if (read.update_rate > 0 && out_.manager.update_rate > 0 &&
               read.update_rate != out_.manager.update_rate) {
      problems_->warning(
          "several-rates", gathered.parameters.entries.at("update_rate").where,
          "the manager in " + read.ns + " asks for " + format_number(read.update_rate) + " Hz, the one in " +
              out_.manager.ns + " for " + format_number(out_.manager.update_rate) + " Hz",
          "a cell has one rate, and the first is used; set update_rate of the slower controllers");
    }
    out_.update_rate = out_.manager.update_rate > 0 ? out_.manager.update_rate : read.update_rate;
  }

  /// Runs `step`. A mistake in one controller does not affect the others, so its errors become warnings that
  /// begin with `consequence`. Returns false if there were any.
  template <typename Step>
  bool alone(const std::string& consequence, Step step) {
    Problems own;
    Problems* const outer = std::exchange(problems_, &own);
    step();
    problems_ = outer;
    for (Problem problem : own.list()) {
      if (problem.severity == Severity::error) problem.what = consequence + problem.what;
      problem.severity = Severity::warning;
      problems_->add(std::move(problem));
    }
    return !own.has_errors();
  }

  /// The names of controllers: nodes with a type, or with keys that only controllers have.
  std::set<std::string> controller_names(const ManagerName& manager, const Gathered& gathered) const {
    std::set<std::string> out, blocks;
    for (const NodeParameters& node : set_.nodes) {
      if (node.path.empty() || is_wild(node.path.back())) continue;
      const std::string& name = node.path.back();
      blocks.insert(name);
      Path whole = manager.ns;
      whole.push_back(name);
      if (is_class_name(node.parameters.text("type")) && means_node(node.path, whole)) out.insert(name);
    }
    for (const auto& [key, entry] : gathered.parameters.entries) {
      const auto dot = key.find('.');
      const std::string name = key.substr(0, dot);
      if (name.empty() || is_manager_key(key)) continue;
      const std::string rest = dot == std::string::npos ? "" : key.substr(dot + 1);
      const bool known =
          std::find(kControllerKeys.begin(), kControllerKeys.end(), rest) != kControllerKeys.end();
      const bool misspelled = !entry.values.empty() && is_class_name(entry.values.front()) &&
                              nearest_name(rest, kControllerKeys) == "type";
      if (known || misspelled || (blocks.contains(name) && gathered.own.contains(key))) out.insert(name);
    }
    return out;
  }

  void controller(const std::string& name, const ManagerName& manager, const Gathered& from,
                  const std::set<std::string>& names) {
    Path whole = manager.ns;
    whole.push_back(name);
    Gathered own = gather(whole, set_.nodes, &used_);
    if (!taken_.insert(whole).second) return;  // taken by another manager of this namespace
    drop_foreign(own, names);
    ControllerEntry entry;
    entry.name = name;
    entry.ns = join_name(manager.ns);
    const auto declared = [&](const char* key) -> const Parameters::Entry* {
      const auto found = from.parameters.entries.find(name + "." + key);
      return found == from.parameters.entries.end() ? nullptr : &found->second;
    };
    check_declaration(name, from);
    if (!read_type(entry, declared("type"), own, from)) return;
    ParameterReader reader(*problems_);
    if (const auto* files = declared("params_file")) reader.read("params_file", *files, entry.params_files);
    if (const auto* others = declared("fallback_controllers"))
      reader.read("fallback_controllers", *others, entry.fallback_controllers);
    if (const auto* args = declared("node_options_args"))
      reader.read("node_options_args", *args, entry.node_options_args);
    if (problems_->has_errors()) return;
    if (!own.has_block && entry.params_files.empty()) lonely_.insert(out_.controllers.size());
    for (const std::string& file : entry.params_files)
      read_params_file(file, *declared("params_file"), whole, own);
    if (problems_->has_errors()) return;
    take_arguments(entry, declared("node_options_args"), own.parameters);
    entry.parameters = std::move(own.parameters);
    add_bounded(out_.controllers, std::move(entry));
  }

  /// Removes keys from wildcard blocks that are meant for the manager or for other controllers.
  static void drop_foreign(Gathered& own, const std::set<std::string>& names) {
    std::erase_if(own.parameters.entries, [&](const auto& item) {
      if (own.own.contains(item.first) || item.first == "update_rate") return false;
      return is_manager_key(item.first) || names.contains(item.first.substr(0, item.first.find('.')));
    });
  }

  bool read_type(ControllerEntry& entry, const Parameters::Entry* declared, Gathered& own,
                 const Gathered& from) {
    const auto in_block = own.parameters.entries.find("type");
    const bool block = in_block != own.parameters.entries.end();
    const Parameters::Entry* type = declared ? declared : block ? &in_block->second : nullptr;
    if (!type || type->values.empty()) {
      problems_->error("no-type", place_of(entry.name, from, own),
                       "the controller '" + entry.name + "' has no type", kTypeAdvice);
      return false;
    }
    entry.type = type->values.front();
    entry.where = type->where;
    if (!is_class_name(entry.type) || type->list) {
      problems_->error("bad-type", type->where, "'" + entry.type + "' is not a type of controller",
                       kTypeAdvice);
      return false;
    }
    if (block) own.parameters.entries.erase(in_block);
    return true;
  }

  static Location place_of(const std::string& name, const Gathered& from, const Gathered& own) {
    for (const auto& [key, entry] : from.parameters.entries)
      if (key == name || key.starts_with(name + ".")) return entry.where;
    return own.parameters.entries.empty() ? Location{} : own.parameters.entries.begin()->second.where;
  }

  /// Warns about parameters of a controller in the manager's block, where no controller looks for them.
  void check_declaration(const std::string& name, const Gathered& from) {
    for (const std::string& key : from.own) {
      if (!key.starts_with(name + ".")) continue;
      const std::string rest = key.substr(name.size() + 1);
      if (std::find(kControllerKeys.begin(), kControllerKeys.end(), rest) != kControllerKeys.end()) continue;
      const Location& where = from.parameters.entries.at(key).where;
      if (rest.find('.') == std::string::npos && nearest_name(rest, kControllerKeys))
        problems_->warning(
            "unknown-key", where,
            "'" + rest + "' is not a key of a controller here" + did_you_mean(rest, kControllerKeys),
            "known are: " + join(kControllerKeys, ", "));
      else
        problems_->warning(
            "misplaced-key", where,
            "'" + rest + "' is below the controller manager, where '" + name + "' does not look for it",
            "write it below '" + name + ":' and 'ros__parameters:' at the left margin");
    }
  }

  void read_params_file(const std::string& file, const Parameters::Entry& entry, const Path& name,
                        Gathered& own) {
    const std::filesystem::path beside = std::filesystem::path(entry.where.file).parent_path();
    ParameterSet extra;
    try {
      ParameterSource source{beside / file};
      source.substitution = substitution_;
      read_parameters(source, extra, *problems_);
    } catch (const Error& error) {
      problems_->error("params-file", entry.where, "'" + file + "' of '" + name.back() + "': " + error.what(),
                       "a relative name starts from the folder of this file");
      return;
    }
    Gathered more = gather(name, extra.nodes, nullptr);
    if (more.parameters.entries.empty())
      problems_->warning("params-file", entry.where,
                         "'" + file + "' has no entry for '" + join_name(name) + "'",
                         "its lines must be below '" + name.back() + ":' and 'ros__parameters:'");
    more.parameters.entries.erase("type");
    for (auto& [key, value] : more.parameters.entries) own.parameters.entries[key] = std::move(value);
    for (JointLimitsSource& limits : extra.joint_limits) set_.joint_limits.push_back(std::move(limits));
  }

  /// Reads `-p name:=value` from the arguments of the controller's node.
  static void take_arguments(const ControllerEntry& entry, const Parameters::Entry* written,
                             Parameters& out) {
    const std::vector<std::string>& args = entry.node_options_args;
    for (std::size_t i = 0; i + 1 < args.size(); ++i) {
      const auto sign = args[i + 1].find(":=");
      if ((args[i] != "-p" && args[i] != "--param") || sign == std::string::npos) continue;
      out.entries[args[i + 1].substr(0, sign)] = {{args[i + 1].substr(sign + 2)}, written->where};
    }
  }

  /// Uses blocks that name a controller in another namespace, if only one controller matches.
  void lend_other_namespaces() {
    for (std::size_t i = 0; i < set_.nodes.size(); ++i) {
      const NodeParameters& node = set_.nodes[i];
      if (used_[i] || node.path.empty() || is_wild(node.path.back())) continue;
      std::vector<std::size_t> fitting;
      for (const std::size_t k : lonely_)
        if (out_.controllers[k].name == node.path.back()) fitting.push_back(k);
      if (fitting.size() == 1)
        lend(node, out_.controllers[fitting.front()]);
      else
        leave_out(node);
    }
  }

  void lend(const NodeParameters& node, ControllerEntry& entry) {
    problems_->warning(
        "other-namespace", node.where,
        "'" + join_name(node.path) + "' is not where the controller '" + entry.full_name() + "' is",
        "its parameters are used; ROS would ignore them: write '" + entry.full_name() + ":'");
    for (const auto& [key, value] : node.parameters.entries)
      if (key != "type") entry.parameters.entries[key] = value;
  }

  void leave_out(const NodeParameters& node) {
    std::vector<std::string> names;
    for (const ControllerEntry& entry : out_.controllers) names.push_back(entry.name);
    const std::string& name = node.path.back();
    const bool known = std::find(names.begin(), names.end(), name) != names.end();
    const std::string hint = known ? "" : did_you_mean(name, names);
    if (hint.empty() && !sounds_like_controller(name) && !known) {
      out_.unused.push_back({join_name(node.path), node.where, "these are the parameters of another node"});
      return;
    }
    problems_->warning("no-type", node.where,
                       "no controller manager declares a controller '" + join_name(node.path) + "'" + hint,
                       "its lines are ignored; write '" + name +
                           ": type: PACKAGE/CLASS' below the manager's "
                           "'ros__parameters:'");
  }

  void finish(ControllerEntry& entry) {
    std::map<std::string, Parameters::Entry>& entries = entry.parameters.entries;
    ParameterReader reader(*problems_);
    if (entries.contains("update_rate"))
      reader.whole("update_rate", entries["update_rate"], 0, 10000, entry.update_rate);
    if (entries.contains("is_async")) reader.read("is_async", entries["is_async"], entry.is_async);
    for (const auto& [key, value] : entries)
      if (key.starts_with("async_parameters.")) async(key.substr(17), value, entry.async);
    if (const char* instead = superseded_type(entry.type))
      problems_->warning("superseded-type", entry.where, entry.type + " is the name of an older release",
                         instead);
    for (const auto& [key, value] : entries) supersede(entry, key, value);
    std::erase_if(entries, [&](const auto& item) {
      const std::string& key = item.first;
      if (key != "use_sim_time" && !key.starts_with("qos_overrides."))
        return key == "update_rate" || key == "is_async" || key.starts_with("async_parameters.");
      out_.unused.push_back({key, item.second.where, "a cell has one clock, and no topics in between"});
      return true;
    });
  }

  void supersede(const ControllerEntry& entry, const std::string& key, const Parameters::Entry& value) {
    if (const char* instead = superseded(entry.type, key))
      problems_->warning("superseded-key", value.where,
                         "'" + key + "' of '" + entry.name + "' is the key of an older release", instead);
  }

  void async(const std::string& key, const Parameters::Entry& value, AsyncParameters& out) {
    static const std::vector<std::string> kKnown = {"thread_priority", "cpu_affinity", "scheduling_policy",
                                                    "print_warnings", "wait_until_initial_trigger"};
    ParameterReader reader(*problems_);
    if (key == "thread_priority")
      reader.whole(key, value, 0, 99, out.thread_priority);
    else if (key == "cpu_affinity")
      reader.read(key, value, out.cpu_affinity);
    else if (key == "print_warnings")
      reader.read(key, value, out.print_warnings);
    else if (key == "scheduling_policy")
      policy(value, out);
    else if (key != "wait_until_initial_trigger")
      problems_->warning("unknown-key", value.where,
                         "'" + key + "' is not a key of async_parameters" + did_you_mean(key, kKnown),
                         "known are: " + join(kKnown, ", "));
  }

  void policy(const Parameters::Entry& value, AsyncParameters& out) {
    std::string written;
    ParameterReader(*problems_).read("scheduling_policy", value, written);
    if (written == "synchronized" || written == "detached")
      out.scheduling_policy = written;
    else
      problems_->error("bad-value", value.where, "'" + written + "' is not a scheduling_policy",
                       "write synchronized or detached");
  }

  void check_fallbacks() {
    for (ControllerEntry& entry : out_.controllers) {
      std::vector<std::string> names;
      for (const ControllerEntry& other : out_.controllers)
        if (other.ns == entry.ns && other.name != entry.name) names.push_back(other.name);
      std::erase_if(entry.fallback_controllers, [&](const std::string& name) {
        if (name == entry.name)
          problems_->warning("bad-fallback", entry.where,
                             "'" + name + "' is named as its own fallback; this is ignored",
                             "name another controller, or remove the line");
        else if (std::find(names.begin(), names.end(), name) == names.end())
          problems_->warning("bad-fallback", entry.where,
                             "'" + entry.name + "' falls back to '" + name +
                                 "', which is not a controller here" + did_you_mean(name, names) +
                                 "; it has no such fallback");
        else
          return false;
        return true;
      });
    }
  }

  ParameterSet& set_;
  const ParameterSubstitution* substitution_;
  ControllersFile& out_;
  Problems* problems_;  ///< those of the whole file, or of the controller that is being read
  std::vector<bool> used_;
  std::set<std::size_t> lonely_;  ///< controllers without a block
  std::set<Path> taken_;          ///< controllers that have been read
  std::size_t gathered_ = 0;
};

/// Sorts by source, then by line.
auto by_place(const std::vector<ParameterSource>& sources) {
  return [&sources](const auto& a, const auto& b) {
    const auto rank = [&](const Location& where) {
      const auto found = std::find_if(sources.begin(), sources.end(), [&](const ParameterSource& source) {
        return source.file.string() == where.file;
      });
      return std::tuple(found - sources.begin(), where.line, where.column);
    };
    return rank(a.where) < rank(b.where);
  };
}

void warn_of_no_controllers(const ControllersFile& file, const std::vector<ParameterSource>& sources,
                            Problems& problems) {
  if (sources.empty() || !file.controllers.empty() || !file.joint_limits.empty() ||
      !file.pid_gains.entries.empty() || !problems.list().empty())
    return;
  problems.warning(
      "no-controllers", {sources.front().file.string(), 1, 1},
      "the file names no controllers: no 'controller_manager: ros__parameters: NAME: type: …' in "
      "it, and no 'NAME: type: …'",
      "a joint trajectory controller for all joints is used");
}

void hand_over(const Problems& found, const std::vector<ParameterSource>& sources, Problems& out) {
  std::vector<Problem> list = found.list();
  std::stable_sort(list.begin(), list.end(), by_place(sources));
  for (Problem& problem : list) out.add(std::move(problem));
}
}  // namespace

ControllersFile read_controllers(const std::vector<ParameterSource>& sources, Problems& problems) {
  ParameterSet set;
  ControllersFile out;
  Problems found;
  try {
    for (const ParameterSource& source : sources) read_parameters(source, set, found);
    Ros2Reader(set, sources.empty() ? nullptr : sources.front().substitution, out, found).read();
    read_ros1_controllers(set.tree, out, found);
  } catch (const Error&) {
    hand_over(found, sources, problems);
    throw;
  }
  out.joint_limits = std::move(set.joint_limits);
  std::stable_sort(out.controllers.begin(), out.controllers.end(), by_place(sources));
  warn_of_no_controllers(out, sources, found);
  hand_over(found, sources, problems);
  return out;
}

ControllersFile read_controllers_file(const std::filesystem::path& path, Problems& problems) {
  return read_controllers_files({path}, problems);
}

ControllersFile read_controllers_files(const std::vector<std::filesystem::path>& paths, Problems& problems,
                                       const ParameterSubstitution& substitution) {
  std::vector<ParameterSource> sources;
  for (const std::filesystem::path& path : paths) {
    ParameterSource source{path};
    source.substitution = &substitution;
    sources.push_back(std::move(source));
  }
  return read_controllers(sources, problems);
}

}  // namespace polyarm::ros_files
