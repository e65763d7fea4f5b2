#include "apps/cell_edit.hpp"

#include <algorithm>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/set_edit.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::apps {

namespace {

/// The byte of a place in a text.
std::size_t offset_of(const std::string& text, const Location& where) {
  std::size_t at = 0;
  for (int line = 1; line < where.line; ++line) {
    const auto end = text.find('\n', at);
    if (end == std::string::npos) return text.size();
    at = end + 1;
  }
  return std::min(text.size(), at + static_cast<std::size_t>(std::max(0, where.column - 1)));
}

/// The end of a value that begins at `at`: behind its bracket, or where the line or the surrounding map ends.
std::size_t end_of_value(const std::string& text, std::size_t at, bool in_flow) {
  int depth = 0;
  for (std::size_t i = at; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '{' || c == '[') ++depth;
    if (c == '}' || c == ']') {
      if (depth == 0) return i;
      if (--depth == 0) return i + 1;
    }
    if (depth > 0) continue;
    if (c == '\n' || (in_flow && c == ',') || (c == '#' && i > 0 && text[i - 1] == ' ')) return i;
  }
  return text.size();
}

Yaml robot_in(const Yaml& cell, const std::string& file, const std::string& robot) {
  const Yaml found = cell["robots"][robot];
  if (found.is_map()) return found;
  throw Error(Problem{"unknown-robot",
                      {file},
                      "the cell has no robot '" + robot + "'" + did_you_mean(robot, cell["robots"].keys()),
                      "--arm NAME"});
}

}  // namespace

std::string with_robot_key(const std::string& text, const std::string& file, const std::string& robot,
                           const std::string& key, const std::string& value) {
  const Yaml entry = robot_in(Yaml::parse(text, file), file, robot);
  std::string out = text;
  const std::size_t begin = offset_of(text, entry.where());
  const bool in_flow = begin < text.size() && text[begin] == '{';
  if (entry.has(key)) {
    std::size_t at = text.find(':', offset_of(text, entry.key_location(key)));
    at = std::min(text.find_first_not_of(' ', at + 1), text.size());
    std::size_t end = end_of_value(text, at, in_flow);
    while (end > at && text[end - 1] == ' ') --end;
    out.replace(at, end - at, value);
  } else if (in_flow) {
    out.insert(begin + 1, key + ": " + value + ", ");
  } else {
    const std::size_t line = text.rfind('\n', begin) + 1;  // npos + 1 is 0
    out.insert(begin, key + ": " + value + "\n" + std::string(begin - line, ' '));
  }
  std::vector<std::string> wanted = entry.keys();
  if (!entry.has(key)) wanted.push_back(key);
  std::vector<std::string> found;
  bool reads = true;
  try {
    found = robot_in(Yaml::parse(out, file), file, robot).keys();
  } catch (const Error&) {
    reads = false;
  }
  std::sort(wanted.begin(), wanted.end());
  std::sort(found.begin(), found.end());
  if (!reads || found != wanted)
    throw Error(
        Problem{"cannot-keep", entry.where(),
                "the key '" + key + "' of '" + robot + "' cannot be changed here; nothing was changed",
                "write it yourself: " + key + ": " + value});
  return out;
}

std::filesystem::path cell_file_of(const std::filesystem::path& cell) {
  std::error_code ignored;
  return std::filesystem::is_directory(cell, ignored) ? cell / "cell.yaml" : cell;
}

void set_robot_key(const std::filesystem::path& cell, const std::string& robot, const std::string& key,
                   const std::string& value) {
  const std::filesystem::path file = cell_file_of(cell);
  data::edit_text(file, key + " of " + robot, [&](const std::string& text) {
    if (text.empty())
      throw Error(Problem{"no-file", {file.string()}, "there is no such cell", "--cell FOLDER"});
    return with_robot_key(text, file.string(), robot, key, value);
  });
}

}  // namespace polyarm::apps
