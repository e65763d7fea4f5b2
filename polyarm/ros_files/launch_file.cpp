#include "polyarm/ros_files/launch_file.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <set>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/xml_bounds.hpp"
#include "polyarm/ros_files/spawner_arguments.hpp"

namespace polyarm::ros_files {

namespace {
using tinyxml2::XMLElement;
using Args = std::map<std::string, std::string>;

constexpr int kDeepestInclude = bounds::kLaunchNesting;
constexpr int kMostFiles = bounds::kLaunchFiles;
constexpr int kMostElements = bounds::kLaunchElements;

std::string last_name(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

const char* reason(tinyxml2::XMLError error) {
  switch (error) {
    case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
      return "a closing tag does not fit the one that is open";
    case tinyxml2::XML_ERROR_PARSING_ELEMENT:
      return "a tag is not complete";
    case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
      return "an attribute does not have the form NAME=\"VALUE\"";
    case tinyxml2::XML_ERROR_EMPTY_DOCUMENT:
      return "the file is empty";
    case tinyxml2::XML_ERROR_PARSING_COMMENT:
      return "a comment does not end";
    case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED:
      return "tags are nested too deep";
    default:
      return "this is no XML";
  }
}

/// The scope of an element: namespace and known args.
struct Scope {
  std::string ns = "/";
  Args args;
  std::set<std::string> declared;  ///< in this scope, not in an outer one
};

/// A file that is being read, and the place of its <include>.
struct Frame {
  std::filesystem::path path;
  Args passed;
  bool pass_all = false;
  Location from;  ///< of the <include>; no line for the first file
  std::set<std::string> declared;
};

class LaunchReader {
 public:
  LaunchReader(const PackageSearch& find, LaunchedCell& out, Problems& problems)
      : find_(find), out_(out), problems_(problems) {}

  /// Throws Error, without the chain of includes, if the file cannot be read.
  void file(Frame frame, const std::string& ns) {
    if (++files_ > kMostFiles)
      throw Error("too-many-includes", "more than 500 launch files are included", "look for an endless loop");
    const std::string text = read_file(frame.path, bounds::kXmlBytes);
    check_xml_bounds(text, frame.path.string());
    tinyxml2::XMLDocument xml;
    const std::string plain = without_instructions(text);
    const auto error = xml.Parse(plain.data(), plain.size());
    const std::string name = frame.path.string();
    if (error != tinyxml2::XML_SUCCESS)
      throw Error(Problem{
          "xml-syntax", {name, xml.ErrorLineNum()}, reason(error), "check this line and the tags above it"});
    const XMLElement* root = xml.RootElement();
    if (!root || std::string_view(root->Name()) != "launch")
      throw Error(Problem{"not-launch",
                          {name, root ? root->GetLineNum() : 1},
                          "this is not a launch file: it does not begin with <launch>",
                          "a description is given with --description"});
    frames_.push_back(std::move(frame));
    Scope scope;
    scope.ns = ns;
    children(*root, scope);
    unused_args();
    frames_.pop_back();
  }

 private:
  // --- places and messages ---

  Location at(const XMLElement& element) const {
    return {frames_.back().path.string(), element.GetLineNum()};
  }

  std::string chain() const {
    std::string out;
    for (std::size_t i = frames_.size(); i-- > 1;)
      out += (out.empty() ? "; included from " : ", from ") + frames_[i].from.text();
    return out;
  }

  void error(const XMLElement& element, std::string code, const std::string& what, std::string advice = {}) {
    if (follows_from_args(element)) return;
    problems_.error(std::move(code), at(element), what + chain(), std::move(advice));
  }
  void warning(const XMLElement& element, std::string code, const std::string& what,
               std::string advice = {}) {
    problems_.warning(std::move(code), at(element), what + chain(), std::move(advice));
  }
  void not_applicable(const XMLElement& element, std::string what) {
    out_.not_applicable.push_back({at(element), std::move(what)});
  }
  /// True if an <arg> has no value. Errors of other elements may follow from that, so they are not reported.
  bool follows_from_args(const XMLElement& element) {
    const bool arg = std::string_view(element.Name()) == "arg";
    args_broken_ |= arg;
    return args_broken_ && !arg;
  }
  /// Reports a thrown error, at its own location or else at the element.
  void tell(const XMLElement& element, const Error& thrown) {
    if (follows_from_args(element)) return;
    for (const Problem& problem : thrown.problems())
      problems_.add({problem.code, problem.where.line > 0 ? problem.where : at(element),
                     problem.what + chain(), problem.advice, problem.severity});
  }

  // --- attributes ---

  static bool has(const XMLElement& element, const char* name) { return element.Attribute(name) != nullptr; }

  /// A missing package is reported only if a file of it is read.
  Substitution substitution(const Scope& scope) const {
    const std::filesystem::path folder = std::filesystem::absolute(frames_.back().path).parent_path();
    return {scope.args, folder, find_, false, true};
  }

  std::string attribute(const XMLElement& element, const char* name, const Scope& scope) const {
    const char* written = element.Attribute(name);
    return written ? substitute(written, substitution(scope)) : "";
  }

  std::string required(const XMLElement& element, const char* name, const Scope& scope) const {
    const std::string value(trim(attribute(element, name, scope)));
    if (value.empty())
      throw Error("missing-attribute", "<" + std::string(element.Name()) + "> has no " + name,
                  "write " + std::string(name) + "=\"…\"");
    return value;
  }

  bool boolean(const XMLElement& element, const char* name, const Scope& scope) const {
    return has(element, name) && launch_condition(attribute(element, name, scope));
  }

  bool applies(const XMLElement& element, const Scope& scope) const {
    if (has(element, "if") && has(element, "unless"))
      throw Error("bad-value", "an element has either 'if' or 'unless', here are both",
                  "take one of them away");
    if (has(element, "if")) return boolean(element, "if", scope);
    return !boolean(element, "unless", scope);
  }

  std::filesystem::path path_of(const std::string& written) const {
    const std::filesystem::path path = written;
    return (path.is_absolute() ? path : frames_.back().path.parent_path() / path).lexically_normal();
  }

  std::filesystem::path existing(const std::string& written) const {
    refuse_missing_package(written);
    std::filesystem::path path = path_of(written);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored))
      throw Error("no-file", "there is no file '" + path.string() + "'", "check its name and folder");
    return path;
  }

  // --- elements ---

  void children(const XMLElement& parent, Scope& scope) {
    for (const XMLElement* child = parent.FirstChildElement(); child; child = child->NextSiblingElement()) {
      if (++elements_ > kMostElements)
        throw Error("too-many-elements", "the launch files have more than 50000 elements together",
                    "look for an endless loop of includes");
      try {
        element(*child, scope);
      } catch (const Error& thrown) {
        if (is_final(thrown)) throw placed(thrown.problems().front(), *child);
        tell(*child, thrown);
      }
    }
  }

  Error placed(Problem problem, const XMLElement& element) const {
    if (problem.where.line == 0) problem.where = at(element);
    return Error(std::move(problem));
  }

  static bool is_final(const Error& thrown) {
    const std::string& code = thrown.problems().front().code;
    return code == "too-many-elements" || code == "too-many-includes" || code == "ros2-launch";
  }

  void element(const XMLElement& element, Scope& scope) {
    const std::string_view tag = element.Name();
    if (tag == "arg") declare(element);
    if (!applies(element, scope)) return;
    if (tag == "arg") return arg(element, scope);
    if (tag == "param") return param(element, scope);
    if (tag == "rosparam") return rosparam(element, scope);
    if (tag == "group") return group(element, scope);
    if (tag == "include") return include(element, scope);
    if (tag == "node") return node(element, scope);
    other(element, scope);
  }

  void other(const XMLElement& element, const Scope& scope) {
    const std::string tag = element.Name();
    static const std::vector<std::string> kKnown = {"arg",  "param", "rosparam", "group", "include",
                                                    "node", "remap", "env",      "test",  "machine"};
    if (tag == "let" || tag == "push_ros_namespace" || tag == "push-ros-namespace" || tag == "executable")
      throw ros2(element);
    if (tag == "remap")
      return not_applicable(element, "topics keep their names: '" + attribute(element, "from", scope) +
                                         "' is not renamed to '" + attribute(element, "to", scope) + "'");
    if (tag == "env") return not_applicable(element, "environment variables of nodes: there are no nodes");
    if (tag == "machine") return not_applicable(element, "a cell runs on this machine");
    if (tag == "test") return not_applicable(element, "a test of ROS is not run");
    warning(element, "unknown-element",
            "<" + tag + "> is not an element of a launch file" + did_you_mean(tag, kKnown), "it is ignored");
    not_applicable(element, "<" + tag + "> is not an element of a launch file");
  }

  Error ros2(const XMLElement& element) const {
    return Error(Problem{"ros2-launch", at(element), "this is a launch file of ROS 2, which is not read here",
                         "start with: polyarm run --description FILE --controllers FILE"});
  }

  void declare(const XMLElement& element) {
    if (const char* name = element.Attribute("name")) frames_.back().declared.insert(name);
  }

  void arg(const XMLElement& element, Scope& scope) {
    const std::string name = required(element, "name", scope);
    if (!scope.declared.insert(name).second)
      throw Error("duplicate-name", "the arg '" + name + "' is declared twice", "take one of them away");
    Frame& frame = frames_.back();
    const auto passed = frame.passed.find(name);
    const bool given = passed != frame.passed.end();
    LaunchArg out{name,  element.Attribute("doc") ? element.Attribute("doc") : "",
                  "",    has(element, "value"),
                  false, at(element)};
    if (out.fixed && given && !frame.pass_all)
      throw Error("fixed-arg", "the arg '" + name + "' has a fixed value and cannot be set from outside",
                  "write default= instead of value= in its declaration");
    try {
      out.value = given && !out.fixed ? passed->second : own_value(element, name, scope);
    } catch (const Error&) {
      scope.args[name] = "";  // avoids further errors where the arg is used
      throw;
    }
    out.required = !out.fixed && !has(element, "default");
    scope.args[name] = out.value;
    if (frames_.size() == 1) out_.args.push_back(std::move(out));
  }

  std::string own_value(const XMLElement& element, const std::string& name, const Scope& scope) const {
    for (const char* written : {"value", "default"})
      if (has(element, written)) return attribute(element, written, scope);
    throw Error("missing-arg", "the arg '" + name + "' has no value",
                frames_.size() == 1 ? "give one: polyarm run FILE " + name + ":=VALUE"
                                    : "write <arg name=\"" + name + "\" value=\"…\"/> in the <include>");
  }

  void unused_args() {
    const Frame& frame = frames_.back();
    if (frame.pass_all) return;
    const std::vector<std::string> declared(frame.declared.begin(), frame.declared.end());
    for (const auto& [name, value] : frame.passed)
      if (!frame.declared.contains(name))
        problems_.error("unknown-arg", frame.from.line > 0 ? frame.from : Location{frame.path.string()},
                        "'" + frame.path.filename().string() + "' has no arg '" + name + "'" +
                            did_you_mean(name, declared) + (frames_.size() > 2 ? chain() : ""),
                        declared.empty() ? "it has none" : "it has: " + join(declared, ", "));
  }

  void group(const XMLElement& element, const Scope& scope) {
    Scope inner = scope;
    inner.declared.clear();
    if (has(element, "ns")) inner.ns = resolve_name(scope.ns, attribute(element, "ns", scope));
    children(element, inner);
  }

  // --- include ---

  void include(const XMLElement& element, const Scope& scope) {
    Frame frame;
    frame.from = at(element);
    frame.pass_all = boolean(element, "pass_all_args", scope);
    if (frame.pass_all) frame.passed = scope.args;
    if (!find_included(element, scope, frame.path)) return;
    passed_args(element, scope, frame.passed);
    if (loops(element, frame)) return;
    const std::string ns = resolve_name(scope.ns, attribute(element, "ns", scope));
    const std::size_t depth = frames_.size();
    try {
      file(std::move(frame), ns);
    } catch (const Error& thrown) {
      if (is_final(thrown)) throw;
      frames_.resize(depth);
      tell(element, thrown);
    }
  }

  /// Skips a package that is missing, with a warning. A missing file in an existing package is an error.
  bool find_included(const XMLElement& element, const Scope& scope, std::filesystem::path& path) {
    try {
      path = existing(required(element, "file", scope));
      return true;
    } catch (const Error& thrown) {
      const Problem& problem = thrown.problems().front();
      if (problem.code != "no-package") throw;
      const std::string written = element.Attribute("file");
      warning(element, "no-package", problem.what + ", so '" + written + "' is ignored", problem.advice);
      not_applicable(element, "'" + written + "' is not here");
      return false;
    }
  }

  void passed_args(const XMLElement& element, const Scope& scope, Args& out) {
    for (const XMLElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
      const std::string_view tag = child->Name();
      if (tag != "arg" && tag != "env")
        warning(*child, "unknown-element", "<" + std::string(tag) + "> has no meaning within <include>");
      if (tag != "arg" || !applies(*child, scope)) continue;
      const std::string name = required(*child, "name", scope);
      if (has(*child, "value"))
        out[name] = attribute(*child, "value", scope);
      else if (has(*child, "default"))
        out[name] = attribute(*child, "default", scope);
      else
        error(*child, "missing-attribute", "the arg '" + name + "' is passed on without a value",
              "write value=\"$(arg " + name + ")\"");
    }
  }

  bool loops(const XMLElement& element, const Frame& next) {
    for (const Frame& frame : frames_)
      if (frame.path == next.path && frame.passed == next.passed) {
        error(element, "include-loop", "'" + next.path.filename().string() + "' includes itself",
              "remove the <include>, or give it an 'if' that ends");
        return true;
      }
    if (frames_.size() < kDeepestInclude) return false;
    error(element, "include-loop", "launch files include each other more than 32 deep");
    return true;
  }

  // --- parameters ---

  void param(const XMLElement& element, const Scope& scope) {
    const std::string name = resolve_name(scope.ns, required(element, "name", scope));
    const bool semantic = last_name(name).ends_with("robot_description_semantic");
    const bool description = !semantic && last_name(name).ends_with("robot_description");
    if (has(element, "binfile"))
      return not_applicable(element, "'" + name + "' is binary data for a ROS node");
    if (description || semantic)
      return describe(element, scope, name, semantic ? out_.semantics : out_.descriptions);
    if (has(element, "textfile") || has(element, "command"))
      return not_applicable(element, "'" + name + "' is a text for a ROS node");
    if (!has(element, "value"))
      throw Error("missing-attribute", "the param '" + name + "' has no value", "write value=\"…\"");
    ParameterSource source{frames_.back().path, name, attribute(element, "value", scope), true, at(element)};
    if (source.text->find("$(find ") != std::string::npos)
      warning(element, "no-package",
              "'" + name + "' names a ROS package that is not found: '" + *source.text + "'",
              "add the folder that holds it to the package folders");
    if (attribute(element, "type", scope) == "yaml") {
      source.literal = false;
      source.text = std::string(std::max(0, element.GetLineNum() - 1), '\n') + *source.text;
    }
    out_.parameters.push_back(std::move(source));
  }

  void describe(const XMLElement& element, const Scope& scope, const std::string& name,
                std::vector<LaunchedDescription>& list) {
    LaunchedDescription out;
    out.parameter = name;
    out.where = at(element);
    if (has(element, "textfile"))
      out.file = existing(required(element, "textfile", scope));
    else if (has(element, "command"))
      command(element, scope, out);
    else if (has(element, "value"))
      out.text = attribute(element, "value", scope);
    else
      throw Error("missing-attribute", "'" + name + "' has neither textfile nor command",
                  "write textfile=\"FILE.urdf\" or command=\"xacro FILE.xacro\"");
    list.push_back(std::move(out));
  }

  /// Accepts `xacro FILE NAME:=VALUE …` and `cat FILE`. No command is executed.
  void command(const XMLElement& element, const Scope& scope, LaunchedDescription& out) const {
    Substitution with = substitution(scope);
    with.in_command = true;
    const std::string whole = substitute(element.Attribute("command"), with);
    refuse_missing_package(whole);
    std::vector<std::string> words = shell_words(whole);
    if (words.size() > 3 && words[0] == "rosrun" && words[1] == "xacro")
      words.erase(words.begin(), words.begin() + 2);
    const std::string program = words.empty() ? "" : last_name(words.front());
    out.xacro = program == "xacro" || program == "xacro.py";
    if (!out.xacro && program != "cat")
      throw Error("foreign-command", "the command '" + whole.substr(0, 80) + "' is not run here",
                  "xacro FILE NAME:=VALUE … and cat FILE are understood; else write textfile=\"FILE.urdf\"");
    std::string file;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto sign = words[i].find(":=");
      if (sign != std::string::npos)
        out.arguments.emplace_back(words[i].substr(0, sign), words[i].substr(sign + 2));
      else if (!words[i].starts_with('-') && !std::exchange(file, words[i]).empty())
        throw Error("foreign-command", "the command '" + whole.substr(0, 80) + "' names two files",
                    "name one");
    }
    if (file.empty())
      throw Error("foreign-command", "the command '" + whole.substr(0, 80) + "' names no file", "name one");
    out.file = existing(file);
  }

  void rosparam(const XMLElement& element, const Scope& scope) {
    const std::string command = has(element, "command") ? attribute(element, "command", scope) : "load";
    if (command != "load" && command != "delete" && command != "dump")
      throw Error("bad-value", "'" + command + "' is not a command of rosparam",
                  "write load, which is also the default");
    if (command != "load")
      return not_applicable(element, "rosparam " + command + ": there is no parameter server");
    ParameterSource source;
    source.file = frames_.back().path;
    source.ns = resolve_name(scope.ns, attribute(element, "ns", scope));
    if (has(element, "param")) source.ns = resolve_name(source.ns, attribute(element, "param", scope));
    const bool replace = boolean(element, "subst_value", scope);
    if (has(element, "file"))
      rosparam_file(element, scope, replace, source);
    else
      rosparam_text(element, scope, replace, source);
    out_.parameters.push_back(std::move(source));
  }

  void rosparam_file(const XMLElement& element, const Scope& scope, bool replace, ParameterSource& source) {
    source.file = existing(required(element, "file", scope));
    if (replace) source.text = substitute(read_file(source.file), substitution(scope));
  }

  /// The line where an element's text begins. The XML reader gives only the line of the first character that
  /// is not blank.
  static int first_line(const XMLElement& element, std::string_view text) {
    const tinyxml2::XMLNode* node = element.FirstChild();
    while (node && !node->ToText()) node = node->NextSibling();
    if (!node) return std::max(1, element.GetLineNum());
    const std::size_t blank = node->ToText()->CData() ? 0 : text.find_first_not_of(" \t\r\n");
    const std::string_view before = text.substr(0, blank);
    const auto lines = std::count(before.begin(), before.end(), '\n');
    return std::max(1, node->GetLineNum() - static_cast<int>(lines));
  }

  /// Empty lines are put before the text, so that its line numbers are those of the launch file.
  void rosparam_text(const XMLElement& element, const Scope& scope, bool replace, ParameterSource& source) {
    const char* written = element.GetText();
    if (!written || trim(written).empty())
      throw Error("missing-attribute", "<rosparam> has neither a file nor text in it",
                  "write file=\"FILE.yaml\"");
    const std::string text = replace ? substitute(written, substitution(scope)) : written;
    source.text = std::string(first_line(element, written) - 1, '\n') + text;
  }

  // --- nodes ---

  void node(const XMLElement& element, const Scope& scope) {
    if (has(element, "exec") && !has(element, "type")) throw ros2(element);
    const std::string package = required(element, "pkg", scope), type = required(element, "type", scope);
    const std::string name = has(element, "name") ? attribute(element, "name", scope) : type;
    Scope inner = scope;
    if (has(element, "ns")) inner.ns = resolve_name(scope.ns, attribute(element, "ns", scope));
    const std::string outer = inner.ns;
    inner.ns = resolve_name(inner.ns, name);
    for (const XMLElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement())
      inside_node(*child, inner);
    const std::string args = attribute(element, "args", scope);
    if (package == "controller_manager" && type.starts_with("spawner")) return spawner(element, args, outer);
    if (package == "controller_manager" && type == "controller_manager") return script(element, args, outer);
    not_applicable(element, "'" + name + "' (" + package + "/" + type + ") is a ROS node");
  }

  void inside_node(const XMLElement& child, Scope& scope) {
    const std::string_view tag = child.Name();
    try {
      if ((tag != "param" && tag != "rosparam") || !applies(child, scope)) return;
      tag == "param" ? param(child, scope) : rosparam(child, scope);
    } catch (const Error& thrown) {
      if (is_final(thrown)) throw;
      tell(child, thrown);
    }
  }

  void spawner(const XMLElement& element, const std::string& args, const std::string& ns) {
    const SpawnerArguments read = read_spawner_arguments(args);
    if (read.names.empty())
      warning(element, "no-controllers", "the spawner names no controller",
              "write their names in args=\"…\"");
    for (const std::string& option : read.unknown)
      warning(element, "unknown-option",
              "the spawner has no option '" + option + "'" + spawner_option_hint(option), "it is ignored");
    for (const std::string& name : read.names) spawn(element, name, resolve_name(ns, read.ns), read.stopped);
  }

  void spawn(const XMLElement& element, const std::string& name, const std::string& ns, bool stopped) {
    if (name.ends_with(".yaml") || name.ends_with(".yml")) {
      out_.parameters.push_back({existing(name), ns});
      return not_applicable(
          element, "the parameters in '" + name + "' are loaded; name its controllers to start them");
    }
    std::vector<std::string> path = split_name(resolve_name(ns, name));
    if (path.empty()) return;
    const std::string last = path.back();
    path.pop_back();
    out_.spawned.push_back({last, join_name(path), stopped, at(element)});
  }

  /// `controller_manager spawn A B`, and `load`, which leaves controllers inactive.
  void script(const XMLElement& element, const std::string& args, const std::string& ns) {
    const std::vector<std::string> words = shell_words(args);
    const std::string verb = words.empty() ? "" : words.front();
    if (verb != "spawn" && verb != "load" && verb != "start")
      return not_applicable(element, "controller_manager " + verb + ": polyarm control does this");
    for (std::size_t i = 1; i < words.size(); ++i)
      if (!words[i].starts_with('-')) spawn(element, words[i], ns, verb == "load");
  }

  const PackageSearch& find_;
  LaunchedCell& out_;
  Problems& problems_;
  std::vector<Frame> frames_;
  int files_ = 0, elements_ = 0;
  bool args_broken_ = false;
};

void mark(ControllersFile& file, const SpawnedController& spawned, Problems& problems) {
  std::vector<std::string> names;
  for (ControllerEntry& entry : file.controllers) {
    names.push_back(entry.full_name());
    if (entry.full_name() != spawned.full_name()) continue;
    entry.spawned = true;
    entry.stopped = spawned.stopped;
    return;
  }
  std::string hint = did_you_mean(spawned.full_name(), names);
  for (const std::string& name : names)
    if (last_name(name) == spawned.name) hint = "; there is '" + name + "', in another namespace";
  problems.warning("no-type", spawned.where,
                   "the spawner names '" + spawned.full_name() +
                       "', for which no parameters with a type are loaded" + hint + "; it is left out",
                   "load them with <rosparam file=\"FILE.yaml\"/> in the same namespace");
}
}  // namespace

LaunchedCell read_launch_file(const std::filesystem::path& path, const Args& args, const PackageSearch& find,
                              Problems& problems) {
  LaunchedCell out;
  LaunchReader reader(find, out, problems);
  Frame first;
  first.path = path.lexically_normal();
  first.passed = args;
  reader.file(std::move(first), "/");
  return out;
}

ControllersFile read_controllers(const LaunchedCell& cell, Problems& problems) {
  ControllersFile out = read_controllers(cell.parameters, problems);
  if (cell.spawned.empty()) return out;
  for (ControllerEntry& entry : out.controllers) entry.spawned = false;
  for (const SpawnedController& spawned : cell.spawned) mark(out, spawned, problems);
  return out;
}

}  // namespace polyarm::ros_files
