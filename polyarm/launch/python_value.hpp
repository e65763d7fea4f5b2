#pragma once
/// The value of an expression in a Python launch file, as far as it is known. Private to the room.
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/text.hpp"

namespace polyarm::ros_files::python {

constexpr int kDeepest = 64;
constexpr std::size_t kLongestText = 4096, kHeaviest = 10'000;
constexpr char kUnknown = '\x01';  ///< marks an unknown part ("gap") of a text
constexpr char kName = '\x02';     ///< before and behind the name of a gap that has one, after its kUnknown

/// A text may contain gaps (kUnknown). `builder` is a MoveItConfigsBuilder: `text` is the folder of its
/// package, `entries` are "file" and the mappings of its description.
struct Value {
  enum class Kind { unknown, text, list, map, builder } kind = Kind::unknown;
  std::string text;
  std::vector<Value> items;                            ///< of a list
  std::vector<std::pair<std::string, Value>> entries;  ///< of a map
  std::size_t weight = 1;                              ///< count of values in it, including itself; limits
                                                       ///< growth such as a = [a, a]

  static Value of(std::string text) {
    Value out;
    out.kind = Kind::text;
    out.text = text.size() > kLongestText ? std::string(1, kUnknown) : std::move(text);
    return out;
  }
  static Value gap() { return of(std::string(1, kUnknown)); }
  /// A gap from an argument of the launch file that has no value.
  static Value gap_of(const std::string& argument) {
    return of(std::string{kUnknown, kName} + argument + kName);
  }
  static Value truth(bool yes) { return of(yes ? "true" : "false"); }
  const Value* find(const std::string& key) const {
    for (const auto& [name, value] : entries)
      if (name == key) return &value;
    return nullptr;
  }
};

inline bool has_gap(const std::string& text) {
  return text.find(kUnknown) != std::string::npos;
}

/// The name in a gap from Value::gap_of; "" if there is none.
inline std::string argument_of_gap(const std::string& text) {
  const auto begin = text.find(std::string{kUnknown, kName});
  const auto end = begin == std::string::npos ? begin : text.find(kName, begin + 2);
  return end == std::string::npos ? std::string() : text.substr(begin + 2, end - begin - 2);
}

/// Fills in the fields of a text such as "a {b} {{c}}"; two equal braces become one. `fill` gets the index of
/// the brace that begins a field, appends the value to `out`, and returns the index of the closing brace.
template <typename Fill>
std::string with_fields(const std::string& text, Fill fill) {
  std::string out;
  for (std::size_t i = 0; i < text.size() && out.size() <= kLongestText; ++i) {
    const bool brace = text[i] == '{' || text[i] == '}';
    if (brace && i + 1 < text.size() && text[i + 1] == text[i])
      out += text[i++];
    else if (text[i] == '{')
      i = fill(i, out);
    else
      out += text[i];
  }
  return out;
}

/// A text, or a list of texts joined with `joint`, as one text.
inline std::string flat(const Value& value, const std::string& joint = "", int depth = 0) {
  if (value.kind == Value::Kind::text) return value.text;
  if (value.kind != Value::Kind::list || depth > kDeepest) return std::string(1, kUnknown);
  std::vector<std::string> parts;
  for (const Value& item : value.items) parts.push_back(flat(item, "", depth + 1));
  const std::string out = join(parts, joint);
  return out.size() > kLongestText ? std::string(1, kUnknown) : out;
}

/// a / b / c as in PathJoinSubstitution and os.path.join: an absolute part restarts the path.
inline std::string joined_path(const std::vector<std::string>& parts) {
  std::filesystem::path out;
  for (const std::string& part : parts) out /= std::filesystem::path(part);
  return out.string();
}

/// The arguments of a call.
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
  const Value* second_or(const std::string& name) const {
    return values.size() < 2 ? find(name) : &values[1];
  }
};

}  // namespace polyarm::ros_files::python
