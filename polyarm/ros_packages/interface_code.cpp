#include "polyarm/ros_packages/interface_code.hpp"

#include <cctype>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ros_packages {

namespace fs = std::filesystem;

namespace {
[[noreturn]] void refuse(const Location& where, std::string what) {
  throw Error(Problem{"bad-interface", where, std::move(what), "see the definition of ROS 2 interfaces"});
}

const std::map<std::string, std::string, std::less<>>& primitives() {
  static const std::map<std::string, std::string, std::less<>> all = {{"bool", "bool"},
                                                                      {"byte", "std::uint8_t"},
                                                                      {"char", "std::uint8_t"},
                                                                      {"int8", "std::int8_t"},
                                                                      {"uint8", "std::uint8_t"},
                                                                      {"int16", "std::int16_t"},
                                                                      {"uint16", "std::uint16_t"},
                                                                      {"int32", "std::int32_t"},
                                                                      {"uint32", "std::uint32_t"},
                                                                      {"int64", "std::int64_t"},
                                                                      {"uint64", "std::uint64_t"},
                                                                      {"float32", "float"},
                                                                      {"float64", "double"},
                                                                      {"string", "std::string"},
                                                                      {"wstring", "std::u16string"}};
  return all;
}

struct Member {
  std::string type, name, initial;
  bool constant = false;
};

/// One struct of an interface: a message, or a part of a service or action.
struct Struct {
  std::string name;
  std::vector<Member> members;
};

struct Writer {
  const Interface& interface;
  std::set<std::string> includes;
  std::vector<Struct> structs;

  /// C++ type of an element; notes the header that it needs.
  std::string element(std::string type, const Location& where) {
    if (const auto bound = type.find("<="); bound != std::string::npos) type.erase(bound);
    if (const auto found = primitives().find(type); found != primitives().end()) return found->second;
    if (type == "time" || type == "duration")
      type = "builtin_interfaces/" + std::string(type == "time" ? "Time" : "Duration");
    if (type == "Header") type = "std_msgs/Header";
    std::vector<std::string> words = split_words(type, "/");
    if (words.size() == 1) words.insert(words.begin(), interface.package);
    if (words.size() == 3) words.erase(words.begin() + 1);
    if (words.size() != 2) refuse(where, "'" + type + "' is not a type");
    for (const std::string& word : words) check_name(word, where);
    includes.insert(words[0] + "/msg/" + header_name(words[1]) + ".hpp");
    return words[0] + "::msg::" + words[1];
  }

  static void check_name(const std::string& name, const Location& where) {
    if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0])))
      refuse(where, "'" + name + "' is not a name");
    for (const char c : name)
      if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_')
        refuse(where, "'" + name + "' is not a name");
  }

  static bool is_text(const std::string& type) {
    return type.starts_with("string") || type.starts_with("wstring");
  }
  static std::string value(const std::string& type, std::string text) {
    if (type == "bool") return equal_ignoring_case(text, "true") || text == "1" ? "true" : "false";
    if (!is_text(type)) return text;
    if (text.size() >= 2 && (text[0] == '"' || text[0] == '\'')) text = text.substr(1, text.size() - 2);
    std::string out = type[0] == 'w' ? "u\"" : "\"";
    for (const char c : text) {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
    return out + "\"";
  }

  static void check_number(const std::string& text, const Location& where) {
    if (text.find_first_not_of("0123456789+-.eExXabcdefABCDEFinfINFnaNtrueTRUEfals") != std::string::npos)
      refuse(where, "'" + text + "' is not a value");
  }

  Member field(std::string_view line, const Location& where) {
    const auto blank = line.find_first_of(" \t");
    if (blank == std::string_view::npos) refuse(where, "'" + std::string(line) + "' has no name");
    std::string type(line.substr(0, blank));
    const std::string rest(trim(line.substr(blank)));
    const auto end = std::min(rest.find_first_of(" \t="), rest.size()),
               equal = rest.find_first_not_of(" \t", end);
    if (equal != std::string::npos && rest[equal] == '=')
      return constant(type, rest.substr(0, end), std::string(trim(rest.substr(equal + 1))), where);
    const auto after = rest.find_first_of(" \t");
    Member out;
    out.name = rest.substr(0, after);
    check_name(out.name, where);
    const std::string initial(after == std::string::npos ? "" : trim(rest.substr(after)));
    const auto bracket = type.find('[');
    if (bracket == std::string::npos) {
      out.type = element(type, where);
      if (!initial.empty() && !is_text(type)) check_number(initial, where);
      if (!initial.empty()) out.initial = value(type, initial);
      return out;
    }
    const std::string one = element(type.substr(0, bracket), where);
    const std::string size = type.substr(bracket + 1, type.find(']', bracket) - bracket - 1);
    const bool fixed = !size.empty() && size.find_first_not_of("0123456789") == std::string::npos;
    out.type = fixed ? "std::array<" + one + ", " + size + ">" : "std::vector<" + one + ">";
    out.initial = list(type.substr(0, bracket), initial, where);
    return out;
  }
  /// The default of an array, "[1, 2]", as it stands between braces.
  static std::string list(const std::string& type, const std::string& text, const Location& where) {
    if (text.empty()) return {};
    if (text.front() != '[' || text.back() != ']') refuse(where, "'" + text + "' is not a list of values");
    std::string out, one;
    char quote = 0;
    const auto take = [&] {
      const std::string item(trim(one));
      if (!is_text(type)) check_number(item, where);
      if (!item.empty()) out += (out.empty() ? "" : ", ") + value(type, item);
      one.clear();
    };
    for (const char c : text.substr(1, text.size() - 2)) {
      if (quote == 0 && c == ',') {
        take();
        continue;
      }
      if (c == '"' || c == '\'') quote = quote == 0 ? c : quote == c ? char{0} : quote;
      one += c;
    }
    take();
    return out;
  }
  Member constant(const std::string& type, const std::string& name, const std::string& text,
                  const Location& where) {
    check_name(name, where);
    if (!primitives().contains(type)) refuse(where, "a constant cannot be a '" + type + "'");
    if (!is_text(type)) check_number(text, where);
    return {element(type, where), name, value(type, text), true};
  }

  void read() {
    const bool message = interface.kind == "msg";
    const std::vector<std::string> names = message ? std::vector<std::string>{interface.name}
                                           : interface.kind == "srv"
                                               ? std::vector<std::string>{"Request", "Response"}
                                               : std::vector<std::string>{"Goal", "Result", "Feedback"};
    for (const std::string& name : names)
      structs.push_back({message ? name : interface.name + "_" + name, {}});
    std::size_t part = 0;
    Location where = interface.where;
    for (const std::string& line : split_fields(interface.text, '\n')) {
      std::string_view words = line;
      if (words.starts_with("---")) {
        if (++part >= structs.size()) refuse(where, "there is a part too many");
      } else {
        bool quoted = false;
        for (std::size_t i = 0; i < words.size(); ++i) {
          if (words[i] == '"') quoted = !quoted;
          if (words[i] == '#' && !quoted) words = words.substr(0, i);
        }
        words = trim(words);
        if (!words.empty() && words[0] != '@') structs[part].members.push_back(field(words, where));
      }
      ++where.line;
    }
  }

  /// What CDR code needs (polyarm_ros/cdr.hpp), and text (rosidl_runtime_cpp/traits.hpp). An empty struct is
  /// one byte on the wire.
  static std::string fields_code(const Struct& made, const std::string& type) {
    std::string visits, names;
    for (const Member& m : made.members) {
      if (m.constant) continue;
      visits += " visit_(" + m.name + ");";
      names += (names.empty() ? "" : " ") + m.name;
    }
    if (visits.empty()) visits = " std::uint8_t none_ = 0; visit_(none_);";
    std::string out = "  static constexpr const char* polyarm_type() { return \"" + type +
                      "\"; }\n  static constexpr const char* polyarm_names() { return \"" + names + "\"; }\n";
    for (const char* constant : {"", "const "})
      out += std::string("  template <typename Visit>\n  void polyarm_fields(Visit& visit_) ") + constant +
             "{" + visits + " }\n";
    return out;
  }

  /// Names that fields had in an earlier release: each is the field itself, so the message on the wire has
  /// the fields of today.
  static std::string earlier_names(const Struct& made, const std::string& type) {
    static const std::map<std::string, std::vector<std::pair<std::string, std::string>>> all{
        {"control_msgs/msg/JointTrajectoryControllerState",
         {{"desired", "reference"},
          {"actual", "feedback"},
          {"multi_dof_desired", "multi_dof_reference"},
          {"multi_dof_actual", "multi_dof_feedback"}}}};
    const auto found = all.find(type);
    if (found == all.end()) return "";
    std::string out, copies, moves;
    for (const auto& [earlier, today] : found->second)
      for (const Member& m : made.members)
        if (m.name == today) out += "  " + m.type + "& " + earlier + " = " + today + ";\n";
    for (const Member& m : made.members) {
      if (m.constant) continue;
      copies += " " + m.name + " = other_." + m.name + ";";
      moves += " " + m.name + " = std::move(other_." + m.name + ");";
    }
    const std::string& n = made.name;
    return out + "  " + n + "(const " + n + "& other_) { *this = other_; }\n  " + n + "(" + n +
           "&& other_) noexcept { *this = std::move(other_); }\n  " + n + "& operator=(const " + n +
           "& other_) {" + copies + " return *this; }\n  " + n + "& operator=(" + n +
           "&& other_) noexcept {" + moves + " return *this; }\n";
  }

  std::string code_of(const Struct& made) const {
    std::string out = "struct " + made.name + " {\n";
    for (const std::string pointer : {"SharedPtr", "ConstSharedPtr"})
      out += "  using " + pointer + " = std::shared_ptr<" + (pointer[0] == 'C' ? "const " : "") + made.name +
             ">;\n";
    out += "  " + made.name + "() = default;\n  explicit " + made.name +
           "(rosidl_runtime_cpp::MessageInitialization) {}\n";
    out += "  using UniquePtr = std::unique_ptr<" + made.name + ">;\n";
    for (const Member& m : made.members)
      if (m.constant)
        out += (m.type.ends_with("string") ? "  static inline const " : "  static constexpr ") + m.type +
               " " + m.name + " = " + m.initial + ";\n";
    std::string equal, setters;
    for (const Member& m : made.members)
      if (!m.constant) {
        out += "  " + m.type + " " + m.name + "{" + m.initial + "};\n";
        setters += "  " + made.name + "& set__" + m.name + "(const " + m.type + "& given_) { return " +
                   m.name + " = given_, *this; }\n";
        equal += (equal.empty() ? "" : " && ") + m.name + " == other_." + m.name;
      }
    const std::string type = interface.package + "/" + interface.kind + "/" + made.name;
    out += earlier_names(made, type);
    out += setters;
    out += fields_code(made, type);
    out += "  bool operator==(const " + made.name + "& " + (equal.empty() ? "" : "other_") +
           ") const { return " + (equal.empty() ? "true" : equal) + "; }\n";
    out += "  bool operator!=(const " + made.name + "& other_) const { return !(*this == other_); }\n};\n";
    out += "template <typename> using " + made.name + "_ = " + made.name +
           ";  // ROS has one for each allocator\n";
    return out;
  }

  std::string code() {
    read();
    std::string out =
        "#pragma once\n// Made by `polyarm plugin`.\n#include <array>\n#include <cstdint>\n#include "
        "<memory>\n"
        "#include <string>\n#include <utility>\n#include <vector>\n\n#include "
        "\"rosidl_runtime_cpp/message_initialization.hpp\"\n#include \"rosidl_runtime_cpp/traits.hpp\"\n";
    for (const std::string& header : includes) out += "#include \"" + header + "\"\n";
    out += "\nnamespace " + interface.package + "::" + interface.kind + " {\n\n";
    for (const char* function : {"to_yaml", "to_flow_style_yaml", "to_block_style_yaml"})
      out += std::string("using rosidl_generator_traits::") + function + ";\n";
    out += "\n";
    for (const Struct& made : structs) out += code_of(made) + "\n";
    if (interface.kind != "msg") {
      out += "struct " + interface.name + " {\n";
      for (const Struct& made : structs)
        out += "  using " + made.name.substr(interface.name.size() + 1) + " = " + made.name + ";\n";
      out += "  static constexpr const char* polyarm_type() { return \"" + interface.package + "/" +
             interface.kind + "/" + interface.name + "\"; }\n";
      out += "};\n\n";
    }
    return out + "}  // namespace " + interface.package + "::" + interface.kind + "\n";
  }
};
}  // namespace

Interface read_interface(const std::string& package, const fs::path& file) {
  Interface out{package, file.extension().string(), file.stem().string(), "", {file.string(), 1}};
  if (out.kind != ".msg" && out.kind != ".srv" && out.kind != ".action")
    refuse(out.where, "an interface is a .msg, .srv or .action file");
  out.kind.erase(0, 1);
  Writer::check_name(out.name, out.where);
  Writer::check_name(package, out.where);
  out.text = read_file(file, kLargestInterface);
  return out;
}

std::vector<Interface> read_interface_list(const fs::path& file) {
  std::vector<Interface> out;
  bool takes = false;
  int number = 0;
  std::istringstream lines(read_file(file, kLargestInterface));
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    if (line[0] == ' ') {
      if (takes) out.back().text += std::string(trim(line)) + "\n";
      continue;
    }
    const std::vector<std::string> words = split_words(line), name = split_words(words.back(), "/");
    takes = words.size() == 1;
    if (name.size() != 3) refuse({file.string(), number}, "'" + line + "' is not package/kind/Name");
    if (takes) out.push_back({name[0], name[1], name[2], "", {file.string(), number + 1}});
  }
  return out;
}

std::string header_name(std::string_view name) {
  std::string out;
  const auto upper = [&](std::size_t i) {
    return i < name.size() && std::isupper(static_cast<unsigned char>(name[i]));
  };
  const auto small = [&](std::size_t i) {
    return i < name.size() && (std::islower(static_cast<unsigned char>(name[i])) ||
                               std::isdigit(static_cast<unsigned char>(name[i])));
  };
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (i > 0 && upper(i) &&
        (small(i - 1) ||
         (upper(i - 1) && i + 1 < name.size() && std::islower(static_cast<unsigned char>(name[i + 1])))))
      out += '_';
    out += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
  }
  return out;
}

std::string header_code(const Interface& interface) {
  Writer writer{interface, {}, {}};
  return writer.code();
}

std::vector<std::string> header_names(const Interface& interface) {
  const std::string begin = interface.package + "/" + interface.kind + "/",
                    name = header_name(interface.name);
  return {begin + name + ".hpp", begin + "detail/" + name + "__struct.hpp",
          begin + "detail/" + name + "__builder.hpp", begin + "detail/" + name + "__traits.hpp",
          begin + name + ".h"};  // of C in ROS; editors put it into code of C++
}

void write_headers(const std::vector<Interface>& all, const fs::path& folder) {
  const auto write = [](const fs::path& file, const std::string& code) {
    std::error_code error;
    if (fs::is_regular_file(file, error) && read_file(file, kLargestInterface) == code) return;
    fs::create_directories(file.parent_path(), error);
    write_file_atomically(file, code);
  };
  for (const Interface& each : all) {
    const std::vector<std::string> names = header_names(each);
    write(folder / names[0], header_code(each));
    for (std::size_t i = 1; i < names.size(); ++i)
      write(folder / names[i], "#pragma once\n#include \"" + names[0] + "\"\n");
  }
}

}  // namespace polyarm::ros_packages
