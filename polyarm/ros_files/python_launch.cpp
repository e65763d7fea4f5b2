#include "polyarm/ros_files/python_launch.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/python_text.hpp"

namespace polyarm::ros_files {

namespace python_launch {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 64;
constexpr int kPasses = 3;  // a value may be used above the line that states it
constexpr std::size_t kLongestText = 4096, kMostFound = 200, kHeaviest = 10'000;
constexpr char kUnknown = '\x01';  // within a text: here stands what is not known

/// What an expression means, as far as that is written down. A text may have gaps (kUnknown).
struct Value {
  enum class Kind { unknown, text, list, map } kind = Kind::unknown;
  std::string text;
  std::vector<Value> items;                            // of a list
  std::vector<std::pair<std::string, Value>> entries;  // of a map
  std::size_t weight = 1;                              // values in it, itself too: a = [a, a] doubles
  static Value of(std::string text) {
    Value out;
    out.kind = Kind::text;
    out.text = text.size() > kLongestText ? std::string(1, kUnknown) : std::move(text);
    return out;
  }
};

bool has_gap(const std::string& text) {
  return text.find(kUnknown) != std::string::npos;
}

/// One text of a text or a list of texts, which `joint` stands between.
std::string flat(const Value& value, const std::string& joint = "", int depth = 0) {
  if (value.kind == Value::Kind::text) return value.text;
  if (value.kind != Value::Kind::list || depth > kDeepest) return std::string(1, kUnknown);
  std::vector<std::string> parts;
  for (const Value& item : value.items) parts.push_back(flat(item, "", depth + 1));
  const std::string out = join(parts, joint);
  return out.size() > kLongestText ? std::string(1, kUnknown) : out;
}

/// a / b / c as PathJoinSubstitution and os.path.join have it: an absolute part begins anew.
std::string joined_path(const std::vector<std::string>& parts) {
  fs::path out;
  for (const std::string& part : parts) out /= fs::path(part);
  return out.string();
}

struct Arguments {
  std::vector<Value> values;
  std::vector<std::pair<std::string, Value>> named;
  const Value* find(const std::string& name) const {
    for (const auto& [key, value] : named)
      if (key == name) return &value;
    return nullptr;
  }
  const Value* first_or(const std::string& name) const {
    return values.empty() ? find(name) : &values.front();
  }
};

class Reader {
 public:
  Reader(std::string_view text, const fs::path& path, const std::map<std::string, std::string>& given,
         const PackageSearch& find)
      : path_{path}, given_{given}, find_{find}, tokens_{python_tokens(text)} {}

  PythonLaunch read() {
    for (int pass = 0; pass < kPasses; ++pass) {
      out_ = {};
      variables_.clear();
      last_ = pass + 1 == kPasses;
      at_ = 0;
      while (at_ < tokens_.size()) statement();
    }
    list_arguments();
    return std::move(out_);
  }

 private:
  // --- tokens ---

  const PythonToken& token(std::size_t ahead = 0) const {
    static const PythonToken end;
    return at_ + ahead < tokens_.size() ? tokens_[at_ + ahead] : end;
  }
  bool is(const char* sign, std::size_t ahead = 0) const {
    return token(ahead).kind == PythonToken::Kind::sign && token(ahead).text == sign;
  }
  bool is_name(std::size_t ahead = 0) const { return token(ahead).kind == PythonToken::Kind::name; }
  Location here() const { return {path_.string(), token().line}; }

  /// To the bracket that closes what is open at `depth` 0, or to a comma there; false at the end of the text.
  void skip_element() {
    for (int depth = 0; at_ < tokens_.size(); ++at_) {
      if (is("(") || is("[") || is("{")) ++depth;
      if (is(")") || is("]") || is("}"))
        if (depth-- == 0) return;
      if (depth == 0 && is(",")) return;
    }
  }

  // --- statements ---

  void statement() {
    if (is_name() && is("=", 1)) {
      const std::string name = token().text;
      at_ += 2;
      const std::size_t begin = at_;
      Value value = expression(0);
      if (at_ == begin) ++at_;
      if (is_name() && token().text == "if") value = {};  // a if c else b
      variables_[name] = std::move(value);
      return;
    }
    const std::size_t begin = at_;
    if (is_name() && !is_keyword(token().text)) expression(0);
    if (at_ == begin) ++at_;
  }

  static bool is_keyword(const std::string& word) {
    static const std::set<std::string> kWords = {"return", "if",     "elif", "else", "for",  "while",  "in",
                                                 "not",    "and",    "or",   "def",  "from", "import", "as",
                                                 "with",   "lambda", "try",  "pass", "class"};
    return kWords.contains(word);
  }

  // --- expressions ---

  Value expression(int depth) {
    if (depth > kDeepest) return {};
    Value out = operand(depth);
    while (is("+") || is("/") || is("%") || is("*") || is("-")) {
      const std::string sign = token().text;
      ++at_;
      const Value other = operand(depth + 1);
      if (sign == "+")
        out = sum(out, other);
      else if (sign == "/" && out.kind != Value::Kind::unknown)
        out = Value::of(joined_path({flat(out, "/"), flat(other, "/")}));
      else
        out = {};
    }
    return out;
  }

  static Value sum(const Value& a, const Value& b) {
    if (a.kind == Value::Kind::list && b.kind == Value::Kind::list) {
      if (a.weight + b.weight > kHeaviest) return {};
      Value out = a;
      out.items.insert(out.items.end(), b.items.begin(), b.items.end());
      out.weight += b.weight;
      return out;
    }
    if (a.kind == Value::Kind::unknown && b.kind == Value::Kind::unknown) return {};
    return Value::of(flat(a) + flat(b));
  }

  Value operand(int depth) {
    using Kind = PythonToken::Kind;
    if (token().kind == Kind::string) return strings(depth);
    if (token().kind == Kind::number) return Value::of(tokens_[at_++].text);
    if (is("[")) return followed(sequence("]", depth), depth);
    if (is("(")) return followed(parenthesised(depth), depth);
    if (is("{")) return map(depth);
    if (is_name() && !is_keyword(token().text)) return name(depth);
    return {};
  }

  /// Literals beside each other are one.
  Value strings(int depth) {
    std::string out;
    for (; token().kind == PythonToken::Kind::string; ++at_)
      out += token().formatted ? formatted(token().text) : token().text;
    return followed(Value::of(out), depth);
  }

  /// f"…{name}…": variables that are known, a gap for what is computed.
  std::string formatted(const std::string& text) const {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != '{') {
        out += text[i];
        continue;
      }
      const auto end = std::min(text.find('}', i), text.size());
      const auto found = variables_.find(text.substr(i + 1, end - i - 1));
      out += found == variables_.end() ? std::string(1, kUnknown) : flat(found->second);
      i = end;
    }
    return out;
  }

  Value sequence(const char* close, int depth) {
    Value out;
    out.kind = Value::Kind::list;
    ++at_;
    while (at_ < tokens_.size() && !is(close)) {
      const std::size_t begin = at_;
      Value item = expression(depth + 1);
      if (!is(",") && !is(close)) {  // a condition, a comprehension, a name with =
        skip_element();
        item = {};
      }
      if (add(out, item)) out.items.push_back(std::move(item));
      if (is(",")) ++at_;
      if (at_ == begin) ++at_;
    }
    ++at_;
    return out;
  }

  static bool add(Value& to, const Value& inner) {
    if (to.weight + inner.weight > kHeaviest) return false;
    to.weight += inner.weight;
    return true;
  }

  /// (x) is x, (x,) and (x, y) are lists.
  Value parenthesised(int depth) {
    const std::size_t begin = at_;
    Value list = sequence(")", depth);
    const bool tuple = list.items.size() != 1 ||
                       (at_ >= begin + 2 && at_ - 2 < tokens_.size() && tokens_[at_ - 2].text == ",");
    return tuple ? list : std::move(list.items.front());
  }

  Value map(int depth) {
    Value out;
    out.kind = Value::Kind::map;
    ++at_;
    while (at_ < tokens_.size() && !is("}")) {
      const std::size_t begin = at_;
      const Value key = expression(depth + 1);
      if (is(":")) {
        ++at_;
        Value value = expression(depth + 1);
        if (!is(",") && !is("}")) {
          skip_element();
          value = {};
        }
        if (add(out, value)) out.entries.emplace_back(flat(key), std::move(value));
      } else if (!is(",") && !is("}")) {
        skip_element();
      }
      if (is(",")) ++at_;
      if (at_ == begin) ++at_;
    }
    ++at_;
    return out;
  }

  /// A dotted name, which may be called; only its last word counts ("launch.actions.Node").
  Value name(int depth) {
    const Location where = here();
    std::string last = token().text;
    std::string whole = last;
    ++at_;
    while (is(".") && is_name(1)) {
      last = token(1).text;
      whole += "." + last;
      at_ += 2;
    }
    if (is("(")) return followed(call(whole, last, where, depth), depth);
    const auto found = variables_.find(whole);
    if (found != variables_.end()) return followed(found->second, depth);
    if (whole == "True" || whole == "False") return Value::of(lower(whole));
    return followed({}, depth);
  }

  /// What stands behind a value: methods that leave it as it is, or find a package.
  Value followed(Value value, int depth) {
    if (depth > kDeepest) return {};
    while (is(".") || is("[") || is("(")) {
      if (is("[")) {
        sequence("]", depth + 1);
        value = {};
        continue;
      }
      if (is("(")) {
        sequence(")", depth + 1);
        value = {};
        continue;
      }
      const std::string method = token(1).text;
      at_ += 2;
      if (!is("(")) {
        value = {};
        continue;
      }
      const Arguments arguments = called_with(depth + 1);
      static const std::set<std::string> kSame = {"perform", "as_posix", "toxml", "resolve", "strip"};
      if (method == "find" && arguments.values.size() == 1)
        value = package(flat(arguments.values.front()));
      else if (!kSame.contains(method))
        value = {};
    }
    return value;
  }

  Arguments called_with(int depth) {
    Arguments out;
    ++at_;
    while (at_ < tokens_.size() && !is(")")) {
      const std::size_t begin = at_;
      const bool named = is_name() && is("=", 1);
      const std::string key = named ? token().text : "";
      if (named) at_ += 2;
      Value value = expression(depth + 1);
      if (!is(",") && !is(")")) {
        skip_element();
        value = {};
      }
      if (named)
        out.named.emplace_back(key, std::move(value));
      else
        out.values.push_back(std::move(value));
      if (is(",")) ++at_;
      if (at_ == begin) ++at_;
    }
    ++at_;
    return out;
  }

  // --- calls that mean something ---

  Value call(const std::string& whole, const std::string& function, const Location& where, int depth) {
    const Arguments a = called_with(depth + 1);
    if (function == "LaunchConfiguration") return a.values.empty() ? Value{} : argument(flat(a.values[0]));
    if (function == "DeclareLaunchArgument") declare(a);
    if (function == "FindPackageShare" || function == "get_package_share_directory" ||
        function == "get_package_share_path") {
      const Value* name = a.find("package_name") ? a.find("package_name") : a.first_or("package");
      return name ? package(flat(*name)) : Value{};
    }
    if (function == "FindExecutable") return own_argument(a, "name");
    if (function == "PathJoinSubstitution" || function == "PathSubstitution" || function == "Path")
      return path_of(a);
    if (whole.ends_with("path.join")) return path_of(a);
    if (function == "Command") return command(a, where);
    if (function == "process_file") return process_file(a, where);
    if (function == "ParameterFile") return own_argument(a, "param_file");
    if (function == "ParameterValue" || function == "str") return own_argument(a, "value");
    if (function == "TextSubstitution") return own_argument(a, "text");
    if (function == "Node") node(a, where);
    return {};
  }

  static Value own_argument(const Arguments& a, const char* name) {
    const Value* value = a.first_or(name);
    return value ? *value : Value{};
  }

  static Value path_of(const Arguments& a) {
    std::vector<std::string> parts;
    for (const Value& value : a.values) {
      if (value.kind != Value::Kind::list) {
        parts.push_back(flat(value));
        continue;
      }
      for (const Value& item : value.items) parts.push_back(flat(item));
    }
    return parts.empty() ? Value{} : Value::of(joined_path(parts));
  }

  Value argument(const std::string& name) const {
    if (const auto given = given_.find(name); given != given_.end()) return Value::of(given->second);
    const auto declared = declared_.find(name);
    return declared == declared_.end() || !declared->second ? Value::of(std::string(1, kUnknown))
                                                            : Value::of(*declared->second);
  }

  void declare(const Arguments& a) {
    const Value* name = a.first_or("name");
    if (!name || has_gap(flat(*name)) || declared_.size() > kMostFound) return;
    const Value* fallback = a.find("default_value");
    std::optional<std::string> value;
    if (fallback && !has_gap(flat(*fallback))) value = flat(*fallback);
    declared_[flat(*name)] = value;
    if (std::find(order_.begin(), order_.end(), flat(*name)) == order_.end()) order_.push_back(flat(*name));
  }

  Value package(const std::string& name) {
    const fs::path folder = has_gap(name) ? fs::path{} : find_(name);
    if (!folder.empty()) return Value::of(folder.string());
    if (!has_gap(name)) missing_.insert(name);
    return Value::of(std::string(1, kUnknown));
  }

  void not_taken(const Location& where, std::string what) {
    if (!last_ || out_.not_taken.size() >= kMostFound) return;
    const auto same = [&](const auto& other) { return other.second == what; };
    if (std::none_of(out_.not_taken.begin(), out_.not_taken.end(), same))
      out_.not_taken.emplace_back(where, std::move(what));
  }

  // --- descriptions and parameter files ---

  /// Command(["xacro ", FILE, " ", "name:=", VALUE, …])
  Value command(const Arguments& a, const Location& where) {
    const std::string text = a.values.empty() ? "" : flat(a.values.front());
    std::vector<std::string> words = split_words(text);
    if (words.empty() || fs::path(words.front()).filename() != "xacro") {
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
    if (const Value* mappings = a.find("mappings"))
      for (const auto& [key, value] : mappings->entries) add_argument(found, key, flat(value));
    keep(std::move(found));
    return {};
  }

  void add_argument(PythonLaunchDescription& to, const std::string& name, std::string value) {
    if (value.size() > 1 && (value.front() == '"' || value.front() == '\'') && value.back() == value.front())
      value = value.substr(1, value.size() - 2);
    if (has_gap(name) || has_gap(value))
      not_taken(to.where, "the value of '" + (has_gap(name) ? std::string("an argument") : name) +
                              "' for the description is not written down");
    else
      to.arguments.emplace_back(name, std::move(value));
  }

  void keep(PythonLaunchDescription found) {
    if (has_gap(found.file.string()) || found.file.empty())
      return not_taken(found.where, unknown_file("description"));
    const bool again = std::any_of(
        out_.descriptions.begin(), out_.descriptions.end(),
        [&](const auto& other) { return other.file == found.file && other.arguments == found.arguments; });
    if (!again && out_.descriptions.size() < kMostFound) out_.descriptions.push_back(std::move(found));
  }

  std::string unknown_file(const std::string& what) const {
    std::string out = "the file of a " + what + " is not written down";
    if (!missing_.empty())
      out += ", or in a package that is not here (" +
             join(std::vector<std::string>(missing_.begin(), missing_.end()), ", ") + ")";
    return out;
  }

  /// parameters=[FILE, {…}] and arguments=["--param-file", FILE] of a node that has to do with controllers.
  void node(const Arguments& a, const Location& where) {
    const Value* package = a.find("package");
    const std::string name = package ? flat(*package) : "";
    if (name != "controller_manager" && name != "ros_gz_sim" && name != "mujoco_ros2_control") return;
    for (const char* key : {"parameters", "arguments", "ros_arguments"})
      if (const Value* list = a.find(key)) parameter_files(*list, where, key == std::string("parameters"));
  }

  void parameter_files(const Value& value, const Location& where, bool each_is_one) {
    if (value.kind == Value::Kind::unknown) return not_taken(where, "a list of parameters is computed");
    for (const Value& item : value.items) {
      if (item.kind == Value::Kind::map) continue;
      const std::string text = flat(item);
      if (has_gap(text)) {
        if (each_is_one) not_taken(where, unknown_file("node's parameters"));
      } else if (text.ends_with(".yaml") || text.ends_with(".yml")) {
        const bool again = std::any_of(out_.parameters.begin(), out_.parameters.end(),
                                       [&](const auto& other) { return other.file == text; });
        if (!again && out_.parameters.size() < kMostFound) out_.parameters.push_back({text, where});
      }
    }
  }

  void list_arguments() {
    for (const std::string& name : order_) {
      const auto given = given_.find(name);
      const auto& fallback = declared_[name];
      const bool is_given = given != given_.end();
      out_.arguments.push_back({name, is_given ? given->second : fallback.value_or(""),
                                is_given || fallback.has_value(), is_given});
      if (!out_.arguments.back().known)
        not_taken({path_.string()}, "the argument '" + name + "' has no default that is written down");
    }
  }

  const fs::path& path_;
  const std::map<std::string, std::string>& given_;
  const PackageSearch& find_;
  std::vector<PythonToken> tokens_;
  std::size_t at_ = 0;
  bool last_ = false;
  std::map<std::string, Value> variables_;
  std::map<std::string, std::optional<std::string>> declared_;
  std::vector<std::string> order_;
  std::set<std::string> missing_;
  PythonLaunch out_;
};

std::string quoted(const std::string& word) {
  const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::isalnum(c) ||
           std::string_view("/._-:=+,@%").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace
}  // namespace python_launch

std::vector<std::pair<std::string, std::string>> PythonLaunch::variables() const {
  std::vector<std::pair<std::string, std::string>> out;
  for (const PythonLaunchArgument& argument : arguments)
    for (const PythonLaunchFile& parameter : parameters) {
      std::error_code error;
      if (!argument.known || !std::filesystem::is_regular_file(parameter.file, error)) continue;
      if (read_file(parameter.file).find("$(var " + argument.name + ")") == std::string::npos) continue;
      out.emplace_back(argument.name, argument.value);
      break;
    }
  return out;
}

namespace {
/// A node of Gazebo gets the topics of its bridge as a YAML file, too. What is not there is left in: its name
/// is what somebody has to look for.
bool can_have_controllers(const std::filesystem::path& file) {
  std::error_code error;
  return !std::filesystem::is_regular_file(file, error) ||
         read_file(file).find("ros__parameters") != std::string::npos;
}
}  // namespace

std::string PythonLaunch::line() const {
  if (descriptions.empty()) return "";
  const PythonLaunchDescription& description = descriptions.front();
  std::string out = "polyarm run --description " + python_launch::quoted(description.file.string());
  for (const PythonLaunchFile& file : parameters)
    if (can_have_controllers(file.file)) out += " --controllers " + python_launch::quoted(file.file.string());
  std::set<std::string> said;
  for (const auto& [name, value] : description.arguments)
    if (said.insert(name).second) out += " " + python_launch::quoted(name + ":=" + value);
  for (const auto& [name, value] : variables())
    if (said.insert(name).second) out += " " + python_launch::quoted(name + ":=" + value);
  return out;
}

PythonLaunch read_python_launch(std::string_view text, const std::filesystem::path& path,
                                const std::map<std::string, std::string>& args, const PackageSearch& find) {
  return python_launch::Reader(text, path, args, find).read();
}

}  // namespace polyarm::ros_files
