#include "polyarm/launch/python_source.hpp"

#include <set>
#include <string>

namespace polyarm::ros_files::python {

PythonSource::PythonSource(std::string_view text)
    : tokens{python_tokens(text)},
      close(tokens.size(), tokens.size()),
      loop(tokens.size(), 0),
      line_end(tokens.size(), tokens.size()) {
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const PythonToken& token = tokens[i];
    if (token.kind == PythonToken::Kind::name && token.text == "for" && !open.empty() && !loop[open.back()])
      loop[open.back()] = i;
    if (token.kind != PythonToken::Kind::sign) continue;
    if (token.text == "(" || token.text == "[" || token.text == "{") open.push_back(i);
    if ((token.text == ")" || token.text == "]" || token.text == "}") && !open.empty()) {
      close[open.back()] = i;
      open.pop_back();
    }
  }
  for (std::size_t i = tokens.size(); i-- > 1;) line_end[i - 1] = tokens[i].first ? i : line_end[i];
}

bool is_keyword(const std::string& word) {
  static const std::set<std::string> kWords = {
      "return", "if",   "elif", "else",  "for",    "while",   "in",     "not",   "and",    "or",
      "def",    "from", "as",   "with",  "lambda", "try",     "pass",   "is",    "import", "class",
      "except", "del",  "else", "raise", "yield",  "finally", "global", "async", "await",  "assert"};
  return kWords.contains(word);
}

}  // namespace polyarm::ros_files::python
