#include "polyarm/ros_files/parameter_substitution.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "polyarm/base/text.hpp"

namespace polyarm::ros_files {

namespace {
constexpr int kMostInLine = 1000;          ///< limit of replacements in one line
constexpr std::size_t kLongest = 1 << 20;  ///< limit for a line after replacement, bytes

/// Start of a comment in a line of YAML: # after a blank, outside of quotes. Looks at this line only.
std::size_t comment_of(std::string_view line) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quote != 0)
      quote = line[i] == quote ? '\0' : quote;
    else if (line[i] == '#' && (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t'))
      return i;
    else if ((line[i] == '"' || line[i] == '\'') &&
             (i == 0 || std::string_view(" \t[{,:").find(line[i - 1]) != std::string_view::npos))
      quote = line[i];
  }
  return line.size();
}

class Line {
 public:
  Line(std::string_view text, const std::string& file, const ParameterSubstitution& with)
      : file_(file), with_(with), whole_(text) {}

  std::string replaced() {
    const std::size_t end = comment_of(whole_);
    std::string text(whole_.substr(0, end));
    std::size_t from = 0;  // text before this is done
    for (int count = 0;; ++count) {
      const std::size_t close = text.find(')', from);
      if (close == std::string::npos) break;
      const std::size_t open = text.rfind("$(", close);
      if (open == std::string::npos || text.find(')', open) != close) {
        from = close + 1;
        continue;
      }
      if (count == kMostInLine || text.size() > kLongest)
        throw Error("bad-substitution", "the line has too many $(…), or they make it too long");
      const std::string value = value_of(split_words(text.substr(open + 2, close - open - 2), " \t"));
      if (value.find_first_of("\r\n") != std::string::npos)
        throw Error("bad-substitution",
                    "'" + text.substr(open, close + 1 - open) + "' has a value of more than one line",
                    "give it a value of one line");
      text.replace(open, close + 1 - open, value);
    }
    if (const std::size_t open = text.find("$("); open != std::string::npos)
      throw Error("bad-substitution", "'" + text.substr(open) + "' has no end", "write ')' behind it");
    return text + std::string(whole_.substr(end));
  }

 private:
  std::string value_of(const std::vector<std::string>& words) const {
    const std::string kind = words.empty() ? "" : words.front();
    const std::string name = words.size() > 1 ? unquoted(words[1]) : "";
    if (kind == "dirname" && words.size() == 1) return std::filesystem::path(file_).parent_path().string();
    if (kind == "var" && words.size() >= 2) return variable(name, words);
    if (kind == "env" && words.size() >= 2) return environment(name, words);
    if (kind == "find-pkg-share" && words.size() == 2) return package(name);
    throw Error(
        "bad-substitution", "'$(" + join(words, " ") + ")' is not followed",
        "$(var NAME), $(env NAME DEFAULT), $(find-pkg-share NAME) and $(dirname) are; write the value");
  }

  static std::string unquoted(const std::string& word) {
    const bool quoted = word.size() > 1 && (word.front() == '\'' || word.front() == '"');
    return quoted && word.back() == word.front() ? word.substr(1, word.size() - 2) : word;
  }

  std::string variable(const std::string& name, const std::vector<std::string>& words) const {
    const std::optional<std::string> value = with_.var ? with_.var(name) : std::nullopt;
    if (value) return *value;
    if (words.size() > 2) return unquoted(words[2]);
    throw Error("unknown-arg", "'$(var " + name + ")' has no value here",
                "a launch file gives it one; give it as " + name + ":=VALUE, or in the cell's arguments:");
  }

  static std::string environment(const std::string& name, const std::vector<std::string>& words) {
    if (const char* value = std::getenv(name.c_str())) return value;
    if (words.size() > 2) return unquoted(words[2]);
    throw Error("no-variable", "the environment variable '" + name + "' is not set", "set it");
  }

  std::string package(const std::string& name) const {
    const std::filesystem::path folder = with_.find ? with_.find(name) : std::filesystem::path();
    if (!folder.empty()) return folder.string();
    throw Error("no-package", "the ROS package '" + name + "' is not found",
                "name the folders of packages in POLYARM_PACKAGES");
  }

  const std::string& file_;
  const ParameterSubstitution& with_;
  std::string_view whole_;
};
}  // namespace

std::string substitute_parameters(std::string_view text, const std::string& file,
                                  const ParameterSubstitution& with, Problems& problems) {
  if (text.find("$(") == std::string_view::npos) return std::string(text);
  std::string out;
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    ++number;
    const std::size_t mark = line.find("$(");
    if (mark == std::string_view::npos) {
      out += line;
    } else {
      try {
        out += Line(line, file, with).replaced();
      } catch (const Error& error) {
        for (Problem problem : error.problems()) {
          if (problem.where.line == 0) problem.where = {file, number, static_cast<int>(mark) + 1};
          problems.add(std::move(problem));
        }
        out += line;
      }
    }
    if (end < text.size()) out += '\n';
    at = end + 1;
  }
  return out;
}

}  // namespace polyarm::ros_files
