#include "polyarm/ros_files/parameter_file.hpp"

#include <algorithm>
#include <numbers>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::ros_files {

namespace {
using controllers::Parameters;
using Path = std::vector<std::string>;

constexpr const char* kParameters = "ros__parameters";
constexpr std::size_t kDeepestParameter = 64;
constexpr int kMostNodes = 100'000;

bool misspelled_parameters(const std::string& key) {
  const std::string plain = lower(key);
  return key != kParameters && (plain == "ros_parameters" || plain == "ros__parameter" ||
                                plain == "ros_parameter" || plain == "ros__params" || plain == "ros_params" ||
                                plain == "ros___parameters" || plain == kParameters);
}

Path operator+(Path path, const Path& more) {
  path.insert(path.end(), more.begin(), more.end());
  return path;
}

/// Converts `deg(90)` and `rad(0.5)` of ROS 1 files to radians.
std::string in_radians(const std::string& text) {
  const bool degrees = text.starts_with("deg(");
  if ((!degrees && !text.starts_with("rad(")) || !text.ends_with(")")) return text;
  const auto number = parse_number(std::string_view(text).substr(4, text.size() - 5));
  if (!number) return text;
  return format_number(degrees ? *number * std::numbers::pi / 180 : *number);
}

/// Reads one document. Counts what it visits, so that aliases of aliases are refused.
class Reader {
 public:
  Reader(const ParameterSource& source, ParameterSet& set, Problems& problems)
      : source_(source), set_(set), problems_(problems) {}

  void read(const Yaml& document) {
    if (!document.defined()) return;
    if (!document.is_map() && split_name(source_.ns).empty())
      return problems_.error("not-parameters", document.where(),
                             "a list of names and values is expected here",
                             "a controllers file begins with 'controller_manager:'");
    ros2_ = speaks_ros2(document, 0) || lacks_ros2(document);
    visited_ = 0;
    if (ros2_)
      node_names(document, {}, {});
    else
      plain_names(document);
  }

 private:
  void count(const Location& where, std::size_t depth) {
    if (depth > kDeepestParameter)
      throw Error(Problem{"yaml-nesting", where, "names are nested more than 64 deep",
                          "an alias that contains itself does this too"});
    if (++visited_ > kMostNodes)
      throw Error(Problem{"yaml-size", where, "the file holds more than 100000 values",
                          "aliases of aliases do this too"});
  }

  /// The pairs of a map, after those that `<<` merges into it. A duplicate key is reported.
  std::vector<Yaml::Entry> pairs(const Yaml& map, std::size_t depth) {
    std::vector<Yaml::Entry> merged, own;
    std::map<std::string, Location> seen;
    for (Yaml::Entry& entry : map.entries()) {
      count(entry.where, depth);
      if (entry.key == "<<" && !entry.value.is_scalar()) {
        for (const Yaml& other : entry.value.items())
          for (Yaml::Entry& inherited : pairs(other, depth + 1)) merged.push_back(std::move(inherited));
        continue;
      }
      const auto [first, fresh] = seen.try_emplace(entry.key, entry.where);
      if (!fresh) twice(entry, first->second);
      own.push_back(std::move(entry));
    }
    merged.insert(merged.end(), own.begin(), own.end());
    return merged;
  }

  void twice(const Yaml::Entry& entry, const Location& first) {
    if (!told_twice_.insert(entry.where.line).second) return;
    const std::string what =
        "'" + entry.key + "' occurs twice, here and in line " + std::to_string(first.line);
    if (entry.value.is_map() && ros2_)
      problems_.warning("duplicate-name", entry.where, what, "both are read; put their lines together");
    else if (entry.value.is_map())  // ROS 1 drops the first
      problems_.error("duplicate-name", entry.where, what,
                      "put its lines together, or give one another name");
    else
      problems_.warning("duplicate-key", entry.where, what, "the later line counts; remove one of them");
  }

  bool speaks_ros2(const Yaml& node, std::size_t depth) {
    for (const Yaml::Entry& entry : node.entries()) {
      count(entry.where, depth);
      if (entry.key == kParameters || misspelled_parameters(entry.key)) return true;
      if (entry.value.is_map() && speaks_ros2(entry.value, depth + 1)) return true;
    }
    return false;
  }

  /// True for a file without any `ros__parameters` that nevertheless looks like ROS 2.
  static bool lacks_ros2(const Yaml& document) {
    for (const Yaml::Entry& entry : document.entries()) {
      const Path path = split_name(entry.key);
      if (path.empty() || !entry.value.is_map()) continue;
      if (path.front() == "**") return true;
      if (path.back() != "controller_manager") continue;
      if (entry.value.has("update_rate")) return true;
      for (const Yaml::Entry& inner : entry.value.entries())
        if (inner.key.ends_with(".type") || inner.value.has("type")) return true;
    }
    return false;
  }

  // --- ROS 2 ---

  void node_names(const Yaml& node, const Path& path, const Path& keys) {
    if (path.size() > kDeepestParameter) count(node.where(), path.size());
    if (!path.empty() && !speaks_ros2(node, keys.size())) return without_parameters(node, path, keys);
    std::optional<NodeParameters> stray;
    for (const Yaml::Entry& entry : pairs(node, keys.size())) {
      const Path inner_keys = keys + Path{entry.key};
      note_joint_limits(entry, inner_keys, path);
      if (entry.key == kParameters || misspelled_parameters(entry.key))
        parameters(entry, path, inner_keys);
      else if (entry.value.is_map() && entry.key != "joint_limits")
        node_names(entry.value, path + split_name(entry.key), inner_keys);
      else if (entry.value.defined() && entry.key != "joint_limits")
        before_parameters(entry, path, stray);
    }
    if (stray && !path.empty()) set_.nodes.push_back(std::move(*stray));
  }

  /// A node's block without `ros__parameters`: reported once, and read as if it had one.
  void without_parameters(const Yaml& node, const Path& path, const Path& keys) {
    const std::vector<std::string> names = node.keys();
    const auto told =
        std::find_if(names.begin(), names.end(), [](const auto& n) { return n != "joint_limits"; });
    if (told != names.end()) no_parameters(*told, node.key_location(*told), path.back());
    NodeParameters out{path, {}, node.where()};
    flatten("", node, keys, path, out.parameters);
    if (told != names.end()) set_.nodes.push_back(std::move(out));
  }

  void no_parameters(const std::string& key, const Location& where, const std::string& node) {
    problems_.error(
        "no-ros-parameters", where, "'" + key + "' comes before any 'ros__parameters'",
        "write 'ros__parameters:' in a line of its own below '" + node + ":' and indent what follows");
  }

  void parameters(const Yaml::Entry& entry, const Path& path, const Path& keys) {
    if (entry.key != kParameters)
      problems_.error("unknown-key", entry.where, "'" + entry.key + "' is not a key of a parameter file",
                      "write 'ros__parameters:', with two underscores after ros");
    if (path.empty())
      return problems_.error("no-node-name", entry.where, "'ros__parameters' has no node above it",
                             "indent it below 'controller_manager:', and indent its content further");
    if (!entry.value.defined())
      return problems_.warning("no-value", entry.where, "'ros__parameters' of '" + path.back() + "' is empty",
                               "indent the lines that belong to it");
    if (!entry.value.is_map())
      return problems_.error("bad-value", entry.where, "'ros__parameters' holds no names and values here",
                             "write one 'name: value' in each line below it, indented");
    NodeParameters out{path, {}, entry.where};
    flatten("", entry.value, keys, path, out.parameters);
    set_.nodes.push_back(std::move(out));
  }

  void before_parameters(const Yaml::Entry& entry, const Path& path, std::optional<NodeParameters>& stray) {
    if (!stray) {
      no_parameters(entry.key, entry.where, path.empty() ? "NODE" : path.back());
      stray = NodeParameters{path, {}, entry.where};
    }
    stray->parameters.entries[entry.key] = leaf(entry, true);
  }

  void flatten(const std::string& prefix, const Yaml& node, const Path& keys, const Path& path,
               Parameters& out) {
    for (const Yaml::Entry& entry : pairs(node, keys.size())) {
      const std::string name = prefix.empty() ? entry.key : prefix + "." + entry.key;
      const Path inner_keys = keys + Path{entry.key};
      note_joint_limits(entry, inner_keys, path);
      if (entry.value.is_map())
        flatten(name, entry.value, inner_keys, path, out);
      else if (entry.key == kParameters || misspelled_parameters(entry.key))
        problems_.error("bad-value", entry.where, "'" + entry.key + "' is below another 'ros__parameters'",
                        "it belongs directly below a node's name");
      else
        value(name, entry, inner_keys, path, out);
    }
  }

  /// Maps in a list: their names are put directly below the list's name, as in ROS 2.
  void value(const std::string& name, const Yaml::Entry& entry, const Path& keys, const Path& path,
             Parameters& out) {
    Parameters::Entry read = leaf(entry, true);
    bool maps = false;
    if (entry.value.is_list())
      for (const Yaml& item : entry.value.items()) {
        if (!item.is_map()) continue;
        flatten(name, item, keys, path, out);
        maps = true;
      }
    if (!maps || !read.values.empty()) out.entries[name] = std::move(read);
  }

  /// The value of a scalar or list; of a list, only the scalar items.
  Parameters::Entry leaf(const Yaml::Entry& entry, bool ros2) {
    Parameters::Entry out{{}, entry.where, entry.value.is_list()};
    if (!entry.value.defined())
      problems_.warning("no-value", entry.where, "'" + entry.key + "' has no value",
                        "write one after the colon, or remove the line");
    for (const Yaml& item : entry.value.items()) {
      count(entry.where, 0);
      if (item.is_scalar())
        out.values.push_back(ros2 ? item.text() : in_radians(item.text()));
      else if (item.is_list() && ros2 && told_lists_.insert(entry.where.line).second)
        problems_.error("bad-value", item.where(), "'" + entry.key + "' holds lists within a list",
                        "a parameter is one value or a list of plain values");
    }
    return out;
  }

  void note_joint_limits(const Yaml::Entry& entry, const Path& keys, const Path& path) {
    if (entry.key != "joint_limits" || !entry.value.is_map()) return;
    set_.joint_limits.push_back({source_.file, source_.text, keys, join_name(path), entry.where});
  }

  // --- ROS 1 ---

  void plain_names(const Yaml& document) {
    const Path path = split_name(source_.ns);
    if (!path.empty() && path.back() == "joint_limits" && document.is_map())
      set_.joint_limits.push_back({source_.file, source_.text, {}, parent(path), document.where()});
    tree(document, set_.tree, path, {});
  }

  static std::string parent(const Path& path) { return join_name(Path(path.begin(), path.end() - 1)); }

  void tree(const Yaml& node, ParameterTree& root, const Path& path, const Path& keys) {
    if (path.size() > kDeepestParameter) count(node.where(), path.size());
    if (!node.is_map()) return put(root, path, {path.empty() ? "" : path.back(), node.where(), node}, keys);
    for (const Yaml::Entry& entry : pairs(node, keys.size())) {
      const Path names = split_name(entry.key);
      const Path inner = entry.key.starts_with('/') ? names : path + names;
      const Path inner_keys = keys + Path{entry.key};
      if (inner.empty() || inner.size() > kDeepestParameter) count(entry.where, inner.size());
      note_joint_limits(entry, inner_keys, path);
      if (entry.value.is_map()) {
        place(root, inner, entry.where);
        tree(entry.value, root, inner, inner_keys);
      } else if (!inner.empty()) {
        put(root, inner, entry, inner_keys);
      }
    }
  }

  static ParameterTree& place(ParameterTree& root, const Path& path, const Location& where) {
    ParameterTree* at = &root;
    for (const std::string& name : path) {
      at = &at->children[name];
      if (at->where.line == 0) at->where = where;
    }
    return *at;
  }

  /// A list of maps: the names of the maps become its values, and their members are put below those names.
  void put(ParameterTree& root, const Path& path, const Yaml::Entry& entry, const Path& keys) {
    ParameterTree& at = place(root, path, entry.where);
    at.value = leaf(entry, false);
    at.where = entry.where;
    if (!entry.value.is_list()) return;
    int index = 0;
    for (const Yaml& item : entry.value.items()) {
      const std::string number = std::to_string(index++);
      if (!item.is_map()) continue;
      const std::string name = item["name"].is_scalar() ? item["name"].text() : number;
      at.value->values.push_back(name);
      tree(item, root, path + Path{name}, keys + Path{number});
    }
  }

  const ParameterSource& source_;
  ParameterSet& set_;
  Problems& problems_;
  int visited_ = 0;
  bool ros2_ = false;
  std::set<int> told_twice_, told_lists_;
};

/// If a tab is the likely cause of a YAML error, returns an error that explains it.
Error explained(const Error& error, const std::string& text, const std::string& file) {
  int line = 0;
  for (std::size_t at = 0; at < text.size();) {
    ++line;
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::size_t first = std::min(text.find_first_not_of(' ', at), end);
    if (first < end && text[first] == '\t')
      return Error(Problem{"yaml-tab",
                           {file, line, static_cast<int>(first - at) + 1},
                           "the indentation contains a tab, which YAML does not allow",
                           "replace it by spaces"});
    at = end + 1;
  }
  return error;
}

void put_literal(const ParameterSource& source, ParameterSet& set) {
  const Path path = split_name(source.ns);
  if (path.empty() || path.size() > kDeepestParameter) return;
  ParameterTree* at = &set.tree;
  for (const std::string& name : path) {
    at = &at->children[name];
    if (at->where.line == 0) at->where = source.where;
  }
  at->value = Parameters::Entry{{in_radians(source.text.value_or(""))}, source.where};
}

void collect_flat(const ParameterTree& tree, const std::string& prefix, Parameters& out) {
  for (const auto& [name, child] : tree.children) {
    const std::string whole = prefix.empty() ? name : prefix + "." + name;
    if (child.value) out.entries[whole] = *child.value;
    collect_flat(child, whole, out);
  }
}
}  // namespace

const ParameterTree* ParameterTree::find(std::string_view child) const {
  const auto found = children.find(child);
  return found == children.end() ? nullptr : &found->second;
}

Parameters ParameterTree::flat(std::string_view skip) const {
  Parameters out;
  collect_flat(*this, "", out);
  if (!skip.empty()) out.entries.erase(std::string(skip));
  return out;
}

void read_parameters(const ParameterSource& source, ParameterSet& set, Problems& problems) {
  if (source.literal) return put_literal(source, set);
  std::string text = source.text ? *source.text : read_file(source.file);
  if (source.substitution)
    text = substitute_parameters(text, source.file.string(), *source.substitution, problems);
  Yaml document;
  try {
    document = Yaml::parse(text, source.file.string());
  } catch (const Error& error) {
    throw explained(error, text, source.file.string());
  }
  Reader(source, set, problems).read(document);
}

std::vector<std::string> split_name(std::string_view name) {
  return split_words(name, "/");
}

std::string join_name(const std::vector<std::string>& path) {
  std::string out;
  for (const std::string& name : path) out += "/" + name;
  return out.empty() ? "/" : out;
}

bool means_node(const std::vector<std::string>& path, const std::vector<std::string>& name) {
  std::size_t p = 0, n = 0, star = path.size(), resume = 0;
  while (n < name.size()) {
    if (p < path.size() && path[p] == "**") {
      star = p++;
      resume = n;
    } else if (p < path.size() && (path[p] == "*" || path[p] == name[n])) {
      ++p, ++n;
    } else if (star < path.size()) {
      p = star + 1;
      n = ++resume;
    } else {
      return false;
    }
  }
  while (p < path.size() && path[p] == "**") ++p;
  return p == path.size();
}

}  // namespace polyarm::ros_files
