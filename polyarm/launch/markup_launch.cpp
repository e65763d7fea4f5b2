#include "polyarm/launch/markup_launch.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <optional>
#include <set>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/xml_bounds.hpp"
#include "polyarm/launch/launch_substitution.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::ros_files::python {

namespace {

/// An XML element, or the equivalent YAML map.
struct Element {
  std::string tag;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<Element> children;
  Location where;

  const std::string* find(const char* name) const {
    for (const auto& [key, value] : attributes)
      if (key == name) return &value;
    return nullptr;
  }
};

Element element_of(const tinyxml2::XMLElement& xml, const std::string& file, std::size_t depth) {
  Element out;
  out.tag = xml.Name();
  out.where = {file, xml.GetLineNum()};
  for (const auto* a = xml.FirstAttribute(); a; a = a->Next())
    out.attributes.emplace_back(a->Name(), a->Value());
  if (depth < bounds::kLaunchNesting)
    for (const auto* child = xml.FirstChildElement(); child; child = child->NextSiblingElement())
      out.children.push_back(element_of(*child, file, depth + 1));
  return out;
}

void add_children(const Yaml& yaml, const std::string& tag, Element& to, std::size_t depth);

Element element_of(const Yaml& yaml, const std::string& tag, std::size_t depth) {
  Element out;
  out.tag = tag;
  out.where = yaml.where();
  for (const std::string& key : yaml.keys()) {
    const Yaml value = yaml[key];
    if (value.is_scalar())
      out.attributes.emplace_back(key, value.text());
    else
      add_children(value, key, out, depth + 1);
  }
  return out;
}

/// `param: [{…}, {…}]` are children with this tag; `launch: [{node: {…}}]` are children with the tags in the
/// items.
void add_children(const Yaml& yaml, const std::string& tag, Element& to, std::size_t depth) {
  static const std::set<std::string> kNamed = {"param",  "remap",          "env", "arg", "let",
                                               "choice", "composable_node"};
  if (depth > bounds::kLaunchNesting || !yaml.defined()) return;
  if (yaml.is_map()) {
    to.children.push_back(element_of(yaml, tag, depth));
    return;
  }
  for (const Yaml& item : yaml.items()) {
    if (!item.is_map()) continue;
    if (kNamed.contains(tag)) {
      to.children.push_back(element_of(item, tag, depth));
      continue;
    }
    for (const std::string& key : item.keys()) {
      Element inner;
      inner.tag = key;
      inner.where = item.where();
      if (item[key].is_map())
        inner = element_of(item[key], key, depth + 1);
      else
        add_children(item[key], key, inner, depth + 1);
      to.children.push_back(std::move(inner));
    }
  }
}

class Walk {
 public:
  Walk(const std::filesystem::path& path, LaunchActions& actions) : path_{path}, actions_{actions} {}

  void children(const Element& parent, const std::string& condition) {
    for (const Element& child : parent.children) {
      if (++count_ > bounds::kLaunchElements) return;
      element(child, condition);
    }
  }

 private:
  // --- $(…) ---

  std::string text(const std::string& written, const Location& where, std::size_t depth = 0) {
    if (depth > bounds::kLaunchNesting) return std::string(1, kUnknown);
    std::string out;
    for (std::size_t at = 0; at < written.size() && out.size() <= kLongestText;) {
      const std::size_t begin = std::min(written.find("$(", at), written.size());
      out += written.substr(at, begin - at);
      if (begin == written.size()) break;
      const std::size_t end = closing(written, begin + 2);
      out += substituted(written.substr(begin + 2, end - begin - 2), where, depth);
      at = end + 1;
    }
    return out;
  }

  static std::size_t closing(const std::string& text, std::size_t from) {
    int open = 1;
    for (std::size_t at = from; at < text.size(); ++at) {
      if (text[at] == '(') ++open;
      if (text[at] == ')' && --open == 0) return at;
    }
    return text.size();
  }

  std::string substituted(const std::string& inside, const Location& where, std::size_t depth) {
    const std::string whole(trim(text(inside, where, depth + 1)));
    const std::size_t blank = std::min(whole.find_first_of(" \t\r\n"), whole.size());
    const std::string name = whole.substr(0, blank);
    const std::string rest = unquoted(std::string(trim(whole.substr(blank))));
    if (name == "find-pkg-share") return flat(act("FindPackageShare", {rest}, where));
    if (name == "find-pkg-prefix" || name == "exec-in-pkg") return std::string(1, kUnknown);
    if (name == "dirname") return path_.parent_path().string();
    if (name == "filename") return path_.string();
    if (name == "find-exec") return rest;
    if (name == "anon") return rest;
    if (name == "command") return flat(act("Command", {rest}, where));
    if (name == "eval") return evaluated(rest);
    const std::vector<std::string> words = shell_words(rest);
    if (name == "var" && !words.empty()) {
      Arguments arguments = texts({words[0]});
      if (words.size() > 1) arguments.named.emplace_back("default", Value::of(words[1]));
      return flat(actions_.act("LaunchConfiguration", arguments, where));
    }
    if (name == "env" || name == "optenv") return flat(act("EnvironmentVariable", words, where));
    return std::string(1, kUnknown);
  }

  static std::string unquoted(std::string text) {
    for (const std::string mark : {"\"", "'", "&quot;"})
      if (text.size() >= 2 * mark.size() && text.starts_with(mark) && text.ends_with(mark) &&
          text.find(mark, mark.size()) == text.size() - mark.size())
        return text.substr(mark.size(), text.size() - 2 * mark.size());
    return text;
  }

  static std::string evaluated(const std::string& expression) {
    std::string out(1, kUnknown);
    Problems ignored;
    if (!has_gap(expression)) collect(ignored, [&] { out = evaluate_launch_expression(expression, {}); });
    return out;
  }

  // --- arguments ---

  static Arguments texts(const std::vector<std::string>& words) {
    Arguments out;
    for (const std::string& word : words) out.values.push_back(Value::of(word));
    return out;
  }
  Value act(const std::string& action, const std::vector<std::string>& words, const Location& where) {
    return actions_.act(action, texts(words), where);
  }
  void add(Arguments& to, const char* name, const Element& element, const char* attribute) {
    if (const std::string* written = element.find(attribute))
      to.named.emplace_back(name, Value::of(text(*written, element.where)));
  }
  static Value list() {
    Value out;
    out.kind = Value::Kind::list;
    return out;
  }

  // --- elements ---

  /// "true", "false" or a gap.
  std::string condition_of(const Element& element) {
    const std::string* yes = element.find("if");
    const std::string* no = element.find("unless");
    if (!yes && !no) return "true";
    const Value value =
        act(yes ? "IfCondition" : "UnlessCondition", {text(yes ? *yes : *no, element.where)}, element.where);
    return value.kind == Value::Kind::text ? value.text : std::string(1, kUnknown);
  }

  void element(const Element& element, const std::string& outer) {
    const std::string own = condition_of(element);
    if (own == "false") return;
    const std::string condition = outer == "true" ? own : outer;
    Arguments a;
    if (condition != "true") a.named.emplace_back("condition", Value::of(condition));
    const std::string& tag = element.tag;
    if (tag == "arg") return declare(element);
    if (tag == "let") return set(element);
    if (tag == "include") return include(element, std::move(a));
    if (tag == "node") return node(element, std::move(a));
    if (tag == "executable") {
      add(a, "cmd", element, "cmd");
      actions_.act("ExecuteProcess", a, element.where);
      return;
    }
    if (tag == "group" || tag == "timer") return children(element, condition);
    static const std::set<std::string> kNothing = {"remap",
                                                   "set_remap",
                                                   "env",
                                                   "set_env",
                                                   "unset_env",
                                                   "append_env",
                                                   "reset",
                                                   "log",
                                                   "log_info",
                                                   "set_parameter",
                                                   "push_ros_namespace",
                                                   "push-ros-namespace",
                                                   "shutdown",
                                                   "param",
                                                   "set_use_sim_time",
                                                   "node_container",
                                                   "load_composable_node",
                                                   "ros_timer",
                                                   "lifecycle_node",
                                                   "set_parameters_from_file"};
    if (!kNothing.contains(tag)) actions_.not_read(element.where, "<" + tag + "> is not read");
  }

  void declare(const Element& element) {
    Arguments a;
    add(a, "name", element, "name");
    add(a, "default_value", element, "default");
    Value choices = list();
    for (const Element& child : element.children)
      if (const std::string* value = child.find("value"); value && child.tag == "choice")
        choices.items.push_back(Value::of(text(*value, child.where)));
    if (!choices.items.empty()) a.named.emplace_back("choices", std::move(choices));
    actions_.act("DeclareLaunchArgument", a, element.where);
  }

  void set(const Element& element) {
    Arguments a;
    add(a, "name", element, "name");
    add(a, "value", element, "value");
    actions_.act("SetLaunchConfiguration", a, element.where);
  }

  void include(const Element& element, Arguments a) {
    add(a, "launch_description_source", element, "file");
    Value given;
    given.kind = Value::Kind::map;
    for (const Element& child : element.children) {
      const std::string *name = child.find("name"), *value = child.find("value");
      if (name && value && (child.tag == "arg" || child.tag == "let"))
        given.entries.emplace_back(text(*name, child.where), Value::of(text(*value, child.where)));
    }
    a.named.emplace_back("launch_arguments", std::move(given));
    if (const Value* source = a.find("launch_description_source")) a.values.push_back(*source);
    actions_.act("IncludeLaunchDescription", a, element.where);
  }

  void node(const Element& element, Arguments a) {
    add(a, "package", element, "pkg");
    add(a, "executable", element, "exec");
    if (const std::string* args = element.find("args")) {
      Value words = list();
      for (const std::string& word : shell_words(text(*args, element.where)))
        words.items.push_back(Value::of(word));
      a.named.emplace_back("arguments", std::move(words));
    }
    Value parameters = list();
    for (const Element& child : element.children) {
      if (child.tag != "param") continue;
      const std::string* from = child.find("from");
      if (const std::string* value = child.find("value")) text(*value, child.where);  // $(command 'xacro …')
      if (from) parameters.items.push_back(Value::of(text(*from, child.where)));
    }
    a.named.emplace_back("parameters", std::move(parameters));
    actions_.act("Node", a, element.where);
  }

  const std::filesystem::path& path_;
  LaunchActions& actions_;
  std::size_t count_ = 0;
};

bool is_yaml(const std::filesystem::path& path) {
  return path.extension() == ".yaml" || path.extension() == ".yml";
}

Element read_xml(std::string_view text, const std::string& name) {
  check_xml_bounds(text, name);
  tinyxml2::XMLDocument xml;
  const std::string plain = without_instructions(text);
  const auto error = xml.Parse(plain.data(), plain.size());
  const auto* root = xml.RootElement();
  if (error != tinyxml2::XML_SUCCESS || !root || std::string_view(root->Name()) != "launch")
    throw Error(Problem{"not-launch",
                        {name, std::max(1, xml.ErrorLineNum())},
                        "this is not a launch file in XML",
                        "check this line and the tags above it"});
  return element_of(*root, name, 0);
}

Element read_yaml(std::string_view text, const std::string& name) {
  const Yaml yaml = Yaml::parse(text, name);
  Element out;
  add_children(yaml["launch"], "launch", out, 0);
  return out;
}

}  // namespace

bool is_markup_launch(std::string_view text, const std::filesystem::path& path) {
  if (is_yaml(path)) return text.starts_with("launch:") || text.find("\nlaunch:") != std::string_view::npos;
  if (text.find("<launch") == std::string_view::npos) return false;
  for (const char* mark : {"$(find-pkg", "$(var ", " exec=", "<let ", "$(command ", "<executable"})
    if (text.find(mark) != std::string_view::npos) return true;
  return false;
}

void read_markup_launch(std::string_view text, const std::filesystem::path& path, LaunchActions& actions) {
  const Element root = is_yaml(path) ? read_yaml(text, path.string()) : read_xml(text, path.string());
  Walk(path, actions).children(root, "true");
}

}  // namespace polyarm::ros_files::python
