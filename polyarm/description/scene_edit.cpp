#include "polyarm/description/scene_edit.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::description {

namespace {

constexpr std::size_t kLongestName = 64;

std::string list_of(const Vec3& v) {
  return "[" + format_number(v.x) + ", " + format_number(v.y) + ", " + format_number(v.z) + "]";
}

/// In quotes, so that no file name is read as anything else.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

bool is_word(const std::string& name) {
  const auto letter = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  return !name.empty() && name.size() <= kLongestName && !std::isdigit(static_cast<unsigned char>(name[0])) &&
         std::all_of(name.begin(), name.end(), letter);
}

/// Sections and the names of their entries, in order.
std::map<std::string, std::vector<std::string>> entries_of(const Yaml& scene) {
  std::map<std::string, std::vector<std::string>> out;
  for (const std::string& section : scene.keys())
    out[section] = scene[section].is_map() ? scene[section].keys() : std::vector<std::string>();
  return out;
}

/// The byte at which the line of a place begins.
std::size_t begin_of_line(const std::string& text, int line) {
  std::size_t at = 0;
  for (int i = 1; i < line; ++i) {
    const auto end = text.find('\n', at);
    if (end == std::string::npos) return text.size();
    at = end + 1;
  }
  return at;
}

/// Above the first entry of the section; a new section at the end. Unchanged if the section is there without
/// entries.
std::string inserted(const std::string& text, const Yaml& scene, const std::string& section,
                     const std::string& line) {
  const Yaml found = scene[section];
  std::string out = text;
  if (!found.is_map() || found.keys().empty()) {
    const std::vector<std::string> sections = scene.keys();
    if (std::find(sections.begin(), sections.end(), section) != sections.end())
      return text;  // cannot be there twice
    if (!out.empty() && out.back() != '\n') out += '\n';
    return out + section + ":\n  " + line + "\n";
  }
  const Location first = found.key_location(found.keys().front());
  const std::size_t begin = begin_of_line(text, first.line),
                    at = begin + static_cast<std::size_t>(std::max(0, first.column - 1));
  const std::string before = text.substr(begin, at - begin);
  // A map in braces may begin on a line of its own.
  const std::size_t last = at > 0 ? text.find_last_not_of(" \t\r\n", at - 1) : std::string::npos;
  const bool in_flow = last != std::string::npos && text[last] == '{';
  return in_flow ? out.insert(at, line + ", ") : out.insert(begin, before + line + "\n");
}

}  // namespace

std::string line_of(const MeshEntry& entry) {
  std::string out = entry.name + ": {mesh: {file: " + quoted(entry.file) + ", unit: " + entry.unit;
  if (entry.scale != 1) out += ", scale: " + format_number(entry.scale);
  out += "}, at: " + list_of(entry.at);
  if (!(entry.rpy == Vec3{})) out += ", rpy: " + list_of(entry.rpy);
  if (entry.mass > 0) out += ", mass: " + format_number(entry.mass) + "kg";
  return out + "}";
}

std::string with_mesh(const std::string& text, const std::string& file, const MeshEntry& entry) {
  const std::string section = entry.mass > 0 ? "parts" : "fixtures";
  if (!is_word(entry.name))
    throw Error("bad-name", "'" + shortened(entry.name) + "' is not a name",
                "write letters, digits and _, a letter first");
  const Yaml scene = Yaml::parse(text, file);
  std::map<std::string, std::vector<std::string>> wanted = entries_of(scene);
  for (const auto& [other, names] : wanted)
    if ((other == "parts" || other == "fixtures") &&
        std::find(names.begin(), names.end(), entry.name) != names.end())
      throw Error("exists", "the scene has a thing called '" + entry.name + "' already", "give another name");
  wanted[section].push_back(entry.name);
  const std::string out = inserted(text, scene, section, line_of(entry));
  std::map<std::string, std::vector<std::string>> found;
  bool reads = true;
  try {
    found = entries_of(Yaml::parse(out, file));
  } catch (const Error&) {
    reads = false;
  }
  for (auto* each : {&wanted, &found})
    for (auto& [name, names] : *each) std::sort(names.begin(), names.end());
  if (!reads || found != wanted)
    throw Error("cannot-keep",
                "nothing can be added to the '" + section + "' of " + file + "; nothing was changed",
                "write it yourself: " + line_of(entry));
  return out;
}

}  // namespace polyarm::description
