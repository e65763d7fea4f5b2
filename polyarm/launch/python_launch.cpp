#include "polyarm/launch/python_launch.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/launch/markup_launch.hpp"
#include "polyarm/launch/python_calls.hpp"
#include "polyarm/launch/python_reader.hpp"
#include "polyarm/launch/python_spawners.hpp"
#include "polyarm/xacro/packages.hpp"

namespace polyarm::ros_files {

namespace python {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFound = 200;
const std::string kInPackage = "package:";  ///< begins the gap of a package that is not found
constexpr int kMostIncluded = 50, kDeepestInclude = 8;

bool is_there(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error);
}

std::string without_quotes(std::string value) {
  if (value.size() > 1 && (value.front() == '"' || value.front() == '\'') && value.back() == value.front())
    return value.substr(1, value.size() - 2);
  return value;
}

/// Shared by the first launch file and the files it includes.
struct Together {
  int included = 0;                       ///< launch files read so far
  std::set<fs::path> packages;            ///< folders from $(find-pkg-share …) and similar
  std::map<fs::path, fs::path> searched;  ///< searched in these: a missing file, and the file used instead
};

class LaunchReader : private PythonReader, private LaunchActions {
 public:
  LaunchReader(std::string_view text, const fs::path& path, const std::map<std::string, std::string>& given,
               const PackageSearch& find, int depth, Together& together)
      : PythonReader(path.extension() == ".py" ? text : std::string_view(), path.string()),
        text_{text},
        path_{path},
        given_{given},
        find_{find},
        depth_{depth},
        together_{together} {}

  PythonLaunch read() {
    PythonReader::read([this](bool last) {
      out_ = {};
      spawned_known_ = true;
      moveit_controllers_.clear();
      last_ = last;
    });
    if (path_.extension() != ".py") read_markup_launch(text_, path_, *this);
    list_arguments();
    out_.missing_packages.assign(missing_.begin(), missing_.end());
    if (out_.parameters.empty()) out_.parameters = moveit_controllers_;
    out_.spawned_known = spawned_known_;
    return std::move(out_);
  }

 private:
  // --- what names and methods mean ---

  Value unassigned(const std::string& name) override {
    if (name == "os.sep" || name == "os.path.sep") return Value::of("/");
    if (name.ends_with(".launch_configurations")) return configurations();
    if (name == "None") return Value::of("none");
    return name == "__file__" ? Value::of(path_.string()) : Value{};
  }

  Value act(const std::string& action, const Arguments& arguments, const Location& where) override {
    return call(action, action, arguments, where);
  }
  void not_read(const Location& where, std::string what) override { not_taken(where, std::move(what)); }
  void left_out(const Location& where, std::string what) override { not_taken(where, std::move(what)); }

  Value method(Value value, const std::string& name, const Arguments* a, const Location& where) override {
    if (value.kind == Value::Kind::builder) return a ? builder_method(std::move(value), name, *a) : Value{};
    if (a && name.starts_with("perform_substitution")) return performed(name, *a);
    if (!a && name == "launch_configurations") return configurations();
    if (!a) return part_of_path(value, name);
    static const std::set<std::string> kSame = {"perform", "as_posix", "toxml",    "resolve",    "strip",
                                                "items",   "copy",     "absolute", "expanduser", "as_string",
                                                "rstrip",  "lstrip",   "__str__",  "toprettyxml"};
    if (kSame.contains(name)) return value;
    if (name == "read_text" && value.kind == Value::Kind::text) return opened(value, where);
    if (name == "open" && value.kind == Value::Kind::text) return opened(value, where);
    if (name == "find" && a->values.size() == 1) return package(flat(a->values.front()));
    if (name == "get" && !a->values.empty()) {
      if (const Value* found = value.find(flat(a->values.front()))) return *found;
      return a->values.size() > 1 ? a->values[1] : Value{};
    }
    return {};
  }

  Value call(const std::string& whole, const std::string& function, const Arguments& a,
             const Location& where) override {
    if (const auto value = path_call(whole, function, a)) return *value;
    if (function == "LaunchConfiguration") {
      const Value* name = a.first_or("variable_name");
      return name ? argument(flat(*name), a.find("default")) : Value{};
    }
    if (function.starts_with("perform_substitution")) return performed(function, a);
    if (whole.ends_with(".launch_configurations.get") && !a.values.empty())
      return argument(flat(a.values.front()), a.second_or("default"));
    if (function == "DeclareLaunchArgument") declare(a);
    if (function == "SetLaunchConfiguration") set(a);
    if (function == "FindExecutable") return own_argument(a, "name");
    if (function == "Command") return command(a, where);
    if (function == "process_file") return process_file(a, where);
    if (whole == "xacro.process") return process_file(a, where);
    if (whole == "open") return opened(own_argument(a, "file"), where);
    if (function == "ParameterFile") return own_argument(a, "param_file");
    if (function == "ParameterValue" || function == "str") return own_argument(a, "value");
    if (function == "TextSubstitution") return own_argument(a, "text");
    if (function == "EnvironmentVariable" || whole == "os.getenv" || whole == "os.environ.get")
      return environment(a);
    if (function == "IfCondition" || function == "UnlessCondition") return condition(function[0] == 'U', a);
    if (function == "PythonExpression") return expression(a);
    if (function == "dict") return map_of(a);
    if (function.ends_with("LaunchDescriptionSource")) return own_argument(a, "location");
    if (function == "IncludeLaunchDescription") include(a, where);
    if (function == "MoveItConfigsBuilder") return builder(a, where);
    if (function == "Node" || is_process(function)) node(function, a, where);
    return function_of_file(a, where);
  }

  /// PythonExpression(["'", LaunchConfiguration("sim"), "' == 'true'"])
  static Value expression(const Arguments& a) {
    const Value* written = a.first_or("expression");
    const std::string text = written ? flat(*written) : std::string(1, kUnknown);
    Value out = Value::gap();
    Problems ignored;
    if (!has_gap(text)) collect(ignored, [&] { out = Value::of(evaluate_launch_expression(text, {})); });
    return out;
  }

  // --- paths and packages ---

  std::optional<Value> path_call(const std::string& whole, const std::string& function, const Arguments& a) {
    if (function == "FindPackageShare" || function == "get_package_share_directory" ||
        function == "get_package_share_path") {
      const Value* name = a.find("package_name") ? a.find("package_name") : a.first_or("package");
      return name ? package(flat(*name)) : Value{};
    }
    if (function == "PathJoinSubstitution" || function == "PathSubstitution" || function == "Path" ||
        whole.ends_with("path.join"))
      return path_of(a);
    if (function == "ThisLaunchFileDir") return Value::of(path_.parent_path().string());
    if (whole.ends_with("path.dirname"))
      return Value::of(fs::path(flat(own_argument(a, "path"))).parent_path());
    if (whole.ends_with("path.abspath") || whole.ends_with("path.realpath") ||
        whole.ends_with("path.normpath"))
      return own_argument(a, "path");
    return std::nullopt;
  }

  Value package(const std::string& name) {
    const fs::path folder = has_gap(name) ? fs::path{} : found_package(name);
    if (!folder.empty()) return Value::of(folder.string());
    if (has_gap(name)) return Value::gap();
    missing_.insert(name);
    return Value::gap_of(kInPackage + name);
  }

  fs::path found_package(const std::string& name) {
    const fs::path folder = find_(name);
    if (!folder.empty()) together_.packages.insert(folder.lexically_normal());
    return folder;
  }

  /// Finds a file that is deeper in the package's sources than in its installation: the file below the
  /// package whose path ends with the requested name. Returns `named` itself if there is none.
  fs::path located(const fs::path& named) const {
    if (named.empty() || has_gap(named.string()) || is_there(named)) return named;
    const fs::path plain = named.lexically_normal();
    const auto known = together_.searched.find(plain);
    if (known != together_.searched.end()) return known->second;
    if (together_.searched.size() >= kMostFound) return named;
    return together_.searched[plain] = searched(plain);
  }

  fs::path searched(const fs::path& named) const {
    for (const fs::path& package : together_.packages) {
      const fs::path inside = named.lexically_relative(package);
      if (inside.empty() || *inside.begin() == ".." || *inside.begin() == ".") continue;
      if (const fs::path found = description::find_inside(package, inside); !found.empty()) return found;
    }
    return named;
  }

  // --- launch arguments ---

  Value argument(const std::string& name, const Value* fallback) const {
    if (const auto given = given_.find(name); given != given_.end()) return Value::of(given->second);
    if (const auto declared = declared_.find(name); declared != declared_.end() && declared->second.value)
      return Value::of(*declared->second.value);
    if (fallback && fallback->kind == Value::Kind::text) return *fallback;
    return has_gap(name) ? Value::gap() : Value::gap_of(name);
  }

  /// context.launch_configurations
  Value configurations() const {
    Value out;
    out.kind = Value::Kind::map;
    for (const auto& [name, value] : given_) out.entries.emplace_back(name, Value::of(value));
    for (const std::string& name : order_)
      if (!given_.contains(name)) out.entries.emplace_back(name, argument(name, nullptr));
    out.weight += out.entries.size();
    return out;
  }

  /// context.perform_substitution(VALUE), perform_substitutions(context, VALUES)
  static Value performed(const std::string& function, const Arguments& a) {
    if (function == "perform_substitution") return own_argument(a, "sub");
    return a.values.size() == 2 ? Value::of(flat(a.values[1])) : Value{};
  }

  void declare(const Arguments& a) {
    const Value* name = a.first_or("name");
    if (!name || has_gap(flat(*name)) || declared_.size() > kMostFound) return;
    Declared declared;
    if (const Value* fallback = a.second_or("default_value"); fallback && !has_gap(flat(*fallback)))
      declared.value = flat(*fallback);
    if (const Value* choices = a.find("choices"))
      for (const Value& choice : choices->items)
        if (!has_gap(flat(choice))) declared.choices.push_back(flat(choice));
    declared_[flat(*name)] = std::move(declared);
    if (std::find(order_.begin(), order_.end(), flat(*name)) == order_.end()) order_.push_back(flat(*name));
  }

  void set(const Arguments& a) {
    const Value *name = a.first_or("name"), *value = a.second_or("value");
    if (name && value && !has_gap(flat(*name)) && !has_gap(flat(*value)) && declared_.size() <= kMostFound)
      declared_[flat(*name)].value = flat(*value);
  }

  // --- included launch files ---

  void include(const Arguments& a, const Location& where) {
    if (!last_ || condition_of(a) == "false") return;
    const std::string named = flat(own_argument(a, "launch_description_source"));
    if (has_gap(named) || named.empty())
      return not_taken(where, unknown_file("launch file that is included", named));
    const fs::path file = located(named);
    if (!is_there(file))
      return not_taken(where, "the launch file '" + named + "' that is included does not exist");
    if (depth_ >= kDeepestInclude || ++together_.included > kMostIncluded)
      return not_taken(where, "'" + named + "' is included, too many or too deep");
    std::string text;
    Problems problems;
    collect(problems, [&] { text = read_file(file, 1 << 20); });
    PythonLaunch inside;
    collect(problems,
            [&] { inside = LaunchReader(text, file, values_for(a), find_, depth_ + 1, together_).read(); });
    if (problems.has_errors()) return not_taken(where, problems.list().front().text());
    take_over(std::move(inside), unsure() || condition_of(a) != "true", where);
  }

  /// An included file gets all values of the including file, and the arguments passed to it.
  std::map<std::string, std::string> values_for(const Arguments& a) const {
    std::map<std::string, std::string> out;
    for (const auto& [name, declared] : declared_)
      if (declared.value) out[name] = *declared.value;
    for (const auto& [name, value] : given_) out[name] = value;
    const auto give = [&](const std::string& name, const Value& value) {
      if (has_gap(flat(value)))
        out.erase(name);
      else
        out[name] = flat(value);
    };
    if (const Value* given = a.second_or("launch_arguments")) {
      for (const auto& [name, value] : given->entries) give(name, value);
      for (const Value& pair : given->items)
        if (pair.items.size() == 2) give(flat(pair.items[0]), pair.items[1]);
    }
    return out;
  }

  void take_over(PythonLaunch inner, bool unsurely, const Location& where) {
    for (PythonLaunchDescription& found : inner.descriptions) keep(std::move(found));
    for (PythonLaunchFile& found : inner.parameters) keep_parameters(found.file, found.where);
    if (unsurely)
      spawn({inner.spawned, {}, true}, "", where);
    else
      out_.spawned.insert(out_.spawned.end(), inner.spawned.begin(), inner.spawned.end());
    spawned_known_ = spawned_known_ && inner.spawned_known;
    missing_.insert(inner.missing_packages.begin(), inner.missing_packages.end());
    for (auto& [place, what] : inner.not_taken) not_taken(place, std::move(what));
    for (PythonLaunchArgument& argument : inner.arguments) {
      const bool again = std::any_of(out_.arguments.begin(), out_.arguments.end(),
                                     [&](const auto& other) { return other.name == argument.name; });
      if (!again && !declared_.contains(argument.name) && argument.known &&
          out_.arguments.size() < kMostFound)
        out_.arguments.push_back(std::move(argument));
    }
  }

  // --- descriptions ---

  /// Command(["xacro ", FILE, " ", "name:=", VALUE, …]) or Command(["cat ", FILE])
  Value command(const Arguments& a, const Location& where) {
    const std::string text = a.values.empty() ? "" : flat(a.values.front());
    const std::vector<std::string> words = shell_words(text);
    const std::string program = words.empty() ? "" : fs::path(words.front()).filename().string();
    if (program != "xacro" && program != "cat") {
      if (has_gap(text)) not_taken(where, "a Command is computed");
      return {};
    }
    PythonLaunchDescription found;
    found.where = where;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto sign = words[i].find(":=");
      if (sign == std::string::npos && found.file.empty())
        found.file = words[i];
      else if (sign != std::string::npos)
        add_argument(found, words[i].substr(0, sign), words[i].substr(sign + 2));
    }
    keep(std::move(found));
    return {};
  }

  Value process_file(const Arguments& a, const Location& where) {
    PythonLaunchDescription found;
    found.where = where;
    if (const Value* file = a.first_or("input_file_name")) found.file = flat(*file);
    if (const Value* mappings = a.second_or("mappings"))
      for (const auto& [key, value] : mappings->entries) add_argument(found, key, flat(value));
    keep(std::move(found));
    return {};
  }

  /// open(FILE); the text becomes robot_description.
  Value opened(const Value& named, const Location& where) {
    const std::string file = flat(named);
    if (!has_gap(file) && is_description(file)) keep({file, {}, {}, where});
    return {};
  }

  /// load_file('arm_description', 'urdf/arm.urdf'), which many launch files define themselves.
  Value function_of_file(const Arguments& a, const Location& where) {
    if (a.values.size() != 2 || !a.named.empty()) return {};
    const std::string name = flat(a.values[0]), inside = flat(a.values[1]);
    if (has_gap(name + inside) || !is_description(inside) || name.find('/') != std::string::npos) return {};
    const fs::path folder = found_package(name), file = located(folder / inside);
    if (!folder.empty() && is_there(file)) keep({file, {}, {}, where});
    return {};
  }

  void add_argument(PythonLaunchDescription& to, const std::string& name, const std::string& value) {
    const std::string gap = argument_of_gap(value);
    if (has_gap(name) || has_gap(value)) {
      not_taken(
          to.where,
          "the value of '" + (has_gap(name) ? std::string("an argument") : name) + "' for the description " +
              (gap.empty() || gap.starts_with(kInPackage)
                   ? "is not written down"
                   : "comes from the argument '" + gap + "', which has no default that is written down"));
      if (!has_gap(name)) to.unknown.push_back({name, gap.starts_with(kInPackage) ? "" : gap});
    } else {
      to.arguments.emplace_back(name, located_text(without_quotes(value)));
    }
  }

  /// A value that may name a file in a package, such as `controllers_file:=…`.
  std::string located_text(const std::string& value) const {
    return value.starts_with('/') ? located(value).string() : value;
  }

  void keep(PythonLaunchDescription found) {
    if (has_gap(found.file.string()) || found.file.empty())
      return not_taken(found.where, unknown_file("description", found.file.string()));
    found.file = located(found.file);
    const std::string name = found.file.filename().string();
    if (name.find(".sdf") != std::string::npos || name.find(".world") != std::string::npos ||
        name.find(".srdf") != std::string::npos)
      return;
    const bool again = std::any_of(
        out_.descriptions.begin(), out_.descriptions.end(),
        [&](const auto& other) { return other.file == found.file && other.arguments == found.arguments; });
    if (!again && out_.descriptions.size() < kMostFound) out_.descriptions.push_back(std::move(found));
  }

  // --- MoveIt ---

  /// MoveItConfigsBuilder("arm", package_name="arm_moveit_config"): the file layout of MoveIt's setup
  /// assistant.
  Value builder(const Arguments& a, const Location& where) {
    const Value* robot = a.first_or("robot_name");
    if (!robot || has_gap(flat(*robot))) return {};
    const Value* named = a.second_or("package_name");
    const Value folder = package(named ? flat(*named) : flat(*robot) + "_moveit_config");
    if (has_gap(folder.text)) {
      not_taken(where, unknown_file("description", folder.text));
      return {};
    }
    Value out;
    out.kind = Value::Kind::builder;
    out.text = folder.text;
    for (const char* extension : {".urdf.xacro", ".urdf"})
      if (const fs::path file = located(fs::path(folder.text) / "config" / (flat(*robot) + extension));
          is_there(file)) {
        out.entries.emplace_back("file", Value::of(file.string()));
        break;
      }
    return out;
  }

  Value builder_method(Value builder, const std::string& name, const Arguments& a) {
    if (name == "robot_description") {
      std::erase_if(builder.entries, [](const auto& entry) { return entry.first == "file"; });
      if (const Value* file = a.first_or("file_path"))
        builder.entries.emplace_back("file", Value::of(joined_path({builder.text, flat(*file)})));
      if (const Value* mappings = a.second_or("mappings"))
        builder.entries.insert(builder.entries.end(), mappings->entries.begin(), mappings->entries.end());
    }
    if (name != "to_moveit_configs" && name != "to_dict") return builder;
    PythonLaunchDescription found;
    found.where = {path_.string()};
    for (const auto& [key, value] : builder.entries) {
      if (key == "file")
        found.file = flat(value);
      else
        add_argument(found, key, flat(value));
    }
    if (!found.file.empty()) keep(std::move(found));
    const fs::path controllers = located(fs::path(builder.text) / "config" / "ros2_controllers.yaml");
    if (is_there(controllers)) moveit_controllers_ = {{controllers, {path_.string()}}};
    return {};
  }

  // --- nodes ---

  void node(const std::string& function, const Arguments& a, const Location& where) {
    const std::string when = condition_of(a);
    if (when == "false") return;
    if (is_process(function)) {
      const Value* cmd = a.find("cmd");
      return cmd ? spawn(spawned_by_command(*cmd), when, where) : void();
    }
    const Value* package = a.find("package");
    const std::string name = package ? flat(*package) : "";
    const Value* arguments = a.find("arguments");
    if (name == "robot_state_publisher" && arguments)
      for (const Value& item : arguments->items)
        if (is_description(flat(item))) keep({flat(item), {}, {}, where});
    if (name == "controller_manager") spawner(a, when, where);
    if (name != "controller_manager" && name != "ros_gz_sim" && name != "mujoco_ros2_control") return;
    for (const char* key : {"parameters", "arguments", "ros_arguments"})
      if (const Value* list = a.find(key)) parameter_files(*list, where, key == std::string("parameters"));
  }

  void spawner(const Arguments& a, const std::string& when, const Location& where) {
    const Value* program = a.find("executable") ? a.find("executable") : a.find("node_executable");
    if (!program || !flat(*program).starts_with("spawner")) return;
    const Value* arguments = a.find("arguments");
    if (!arguments) return spawn(Spawned{{}, {}, false}, when, where);
    const Spawned found = spawned_by_spawner(*arguments);
    spawn(found, when, where);
    for (const std::string& file : found.files) keep_parameters(file, where);
  }

  void spawn(const Spawned& spawned, const std::string& when, const Location& where) {
    out_.spawned.insert(out_.spawned.end(), spawned.names.begin(), spawned.names.end());
    const bool surely = when == "true" && !unsure();
    if (spawned.known && (surely || spawned.names.empty())) return;
    spawned_known_ = false;
    const std::string names = join(spawned.names, ", ");
    if (!spawned.known)
      not_taken(where, "which controllers are started here is computed" +
                           (names.empty() ? "" : "; known are " + names));
    else
      not_taken(where, "'" + names + "' is started under a condition that is not known");
  }

  void parameter_files(const Value& value, const Location& where, bool each_is_one) {
    if (value.kind == Value::Kind::unknown) return not_taken(where, "a list of parameters is computed");
    for (const Value& item : value.items) {
      if (item.kind == Value::Kind::map) continue;
      const std::string text = flat(item);
      if (has_gap(text)) {
        if (each_is_one) not_taken(where, unknown_file("node's parameters", text));
      } else if (text.ends_with(".yaml") || text.ends_with(".yml")) {
        keep_parameters(text, where);
      }
    }
  }

  void keep_parameters(const fs::path& named, const Location& where) {
    const fs::path file = located(named);
    const bool again = std::any_of(out_.parameters.begin(), out_.parameters.end(),
                                   [&](const auto& other) { return other.file == file; });
    if (!again && out_.parameters.size() < kMostFound) out_.parameters.push_back({file, where});
  }

  // --- what is not taken ---

  void not_taken(const Location& where, std::string what) {
    if (!last_ || out_.not_taken.size() >= kMostFound) return;
    const auto same = [&](const auto& other) { return other.second == what; };
    if (std::none_of(out_.not_taken.begin(), out_.not_taken.end(), same))
      out_.not_taken.emplace_back(where, std::move(what));
  }

  /// Why the file of a `what` is not known, from the gap in `path`.
  static std::string unknown_file(const std::string& what, const std::string& path) {
    const std::string gap = argument_of_gap(path), begin = "the file of a " + what;
    if (gap.starts_with(kInPackage))
      return begin + " is in the package '" + gap.substr(kInPackage.size()) + "', which is not found";
    if (!gap.empty())
      return begin + " comes from the argument '" + gap + "', which has no default that is written down";
    return begin + " is not written down";
  }

  void list_arguments() {
    std::vector<PythonLaunchArgument> own;
    for (const std::string& name : order_) {
      const auto given = given_.find(name);
      const Declared& declared = declared_[name];
      const bool is_given = given != given_.end();
      own.push_back({name, is_given ? given->second : declared.value.value_or(""),
                     is_given || declared.value.has_value(), is_given, declared.choices});
      if (!own.back().known)
        not_taken(
            {path_.string()},
            "the argument '" + name + "' has no default that is written down" +
                (declared.choices.empty() ? "" : " (it is one of " + join(declared.choices, ", ") + ")"));
    }
    out_.arguments.insert(out_.arguments.begin(), own.begin(), own.end());
  }

  struct Declared {
    std::optional<std::string> value;
    std::vector<std::string> choices;
  };

  const std::string_view text_;
  const fs::path& path_;
  const std::map<std::string, std::string> given_;
  const PackageSearch& find_;
  const int depth_;
  Together& together_;
  bool last_ = false, spawned_known_ = true;
  std::map<std::string, Declared> declared_;
  std::vector<std::string> order_;
  std::set<std::string> missing_;
  std::vector<PythonLaunchFile> moveit_controllers_;
  PythonLaunch out_;
};

}  // namespace
}  // namespace python

PythonLaunch read_python_launch(std::string_view text, const std::filesystem::path& path,
                                const std::map<std::string, std::string>& args, const PackageSearch& find) {
  python::Together together;
  return python::LaunchReader(text, path, args, find, 0, together).read();
}

bool is_ros2_launch(std::string_view text, const std::filesystem::path& path) {
  return path.extension() == ".py" || python::is_markup_launch(text, path);
}

}  // namespace polyarm::ros_files
