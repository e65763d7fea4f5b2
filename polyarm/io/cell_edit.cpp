#include "polyarm/io/cell_edit.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/set_edit.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::cell {

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
                      "name one of them"});
}

bool begins_with_bracket(const std::string& text, const Yaml& entry) {
  const std::size_t begin = offset_of(text, entry.where());
  return begin < text.size() && text[begin] == '{';
}

struct Span {
  std::size_t begin = 0, end = 0;
};
/// The bytes of the value of a key that the entry has.
Span value_span(const std::string& text, const Yaml& entry, const std::string& key) {
  std::size_t at = text.find(':', offset_of(text, entry.key_location(key)));
  at = std::min(text.find_first_not_of(' ', at + 1), text.size());
  std::size_t end = end_of_value(text, at, begins_with_bracket(text, entry));
  while (end > at && text[end - 1] == ' ') --end;
  return {at, end};
}

/// True if `now` is `before` with another value of the key, or with the key added, and nothing else.
bool differs_only_in(const std::string& before, const std::string& now, const std::string& file,
                     const std::string& robot, const std::string& key) {
  try {
    const Yaml entry = robot_in(Yaml::parse(now, file), file, robot);
    if (!entry.has(key)) return false;
    const Span value = value_span(now, entry, key);
    return with_robot_key(before, file, robot, key, now.substr(value.begin, value.end - value.begin)) == now;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

std::string with_robot_key(const std::string& text, const std::string& file, const std::string& robot,
                           const std::string& key, const std::string& value) {
  const Yaml entry = robot_in(Yaml::parse(text, file), file, robot);
  std::string out = text;
  const std::size_t begin = offset_of(text, entry.where());
  if (entry.has(key)) {
    const Span old = value_span(text, entry, key);
    out.replace(old.begin, old.end - old.begin, value);
  } else if (begins_with_bracket(text, entry)) {
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

std::string undo_robot_key(const std::filesystem::path& cell) {
  const std::filesystem::path file = cell_file_of(cell);
  data::require_history(file, 1);
  const data::SetVersion last = data::history(file).back();
  const auto of = last.what.find(" of ");
  if (of == std::string::npos)
    throw Error(Problem{"no-history", {file.string()}, "its last change is another one: " + last.what, {}});
  const std::string key = last.what.substr(0, of), robot = last.what.substr(of + 4);
  if (!differs_only_in(read_file(last.file), read_file(file), file.string(), robot, key))
    throw Error(Problem{"changed-meanwhile",
                        {file.string()},
                        "the file was changed after '" + key + "' of '" + robot + "' was written",
                        "change '" + key + "' yourself; nothing was changed"});
  data::undo(file, 1);
  return last.what;
}

}  // namespace polyarm::cell
