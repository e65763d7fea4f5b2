#pragma once
/// What the programs in tests/program/cases say that there is before they start.
#include <string>
#include <vector>

#include "fake_host.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/language/lexer.hpp"

namespace polyarm::program {

/// True | 3 | 5mm | "text" | point | point 1 2 3 | joints
inline data::Value given_value(const std::string& text) {
  if (text == "True" || text == "False") return text == "True";
  if (text == "point") return data::Point{};
  if (text == "joints") return data::JointState{{"elbow"}, {0.5}};
  if (text.starts_with("point ")) {
    const auto parts = split_words(text);
    return data::Point{{{std::stod(parts.at(1)), std::stod(parts.at(2)), std::stod(parts.at(3))}, {}}, false};
  }
  if (text.starts_with('"')) return text.substr(1, text.size() - 2);
  const auto tokens = read_tokens(text, {1, 1});
  return data::Number{tokens[0].number, tokens[0].dimension};
}

/// # given NAME: VALUE, where there is no such name yet.
inline void give(FakeHost& host, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    if (!line.starts_with("# given ")) continue;
    const auto colon = line.find(':');
    const std::string name(trim(std::string_view(line).substr(8, colon - 8)));
    if (host.store.find(name)) continue;
    host.store.declare_tag(name, given_value(std::string(trim(std::string_view(line).substr(colon + 1)))));
  }
}

}  // namespace polyarm::program
