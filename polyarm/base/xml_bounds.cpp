#include "polyarm/base/xml_bounds.hpp"

#include <algorithm>

#include "polyarm/base/error.hpp"

namespace polyarm {

namespace {
/// Behind the tag, comment or text that begins at `at` with '<'; counts the attributes of a tag.
std::size_t behind_tag(std::string_view text, std::size_t at, std::size_t& attributes) {
  const auto behind = [&](std::string_view end) {
    const std::size_t found = text.find(end, at);
    return found == std::string_view::npos ? text.size() : found + end.size();
  };
  if (text.substr(at).starts_with("<!--")) return behind("-->");
  if (text.substr(at).starts_with("<![CDATA[")) return behind("]]>");
  if (text.substr(at).starts_with("<?")) return behind("?>");
  for (++at; at < text.size() && text[at] != '>'; ++at) {
    if (text[at] != '"' && text[at] != '\'') continue;
    ++attributes;
    at = text.find(text[at], at + 1);
    if (at == std::string_view::npos) return text.size();
  }
  return std::min(at + 1, text.size());
}
}  // namespace

void check_xml_bounds(std::string_view text, const std::string& file, std::size_t most_bytes) {
  if (text.size() > most_bytes)
    throw Error(Problem{"too-large",
                        {file},
                        "the text has more than " + std::to_string(most_bytes) + " bytes",
                        "divide the file"});
  for (std::size_t at = text.find('<'); at != std::string_view::npos;) {
    std::size_t attributes = 0;
    const std::size_t next = behind_tag(text, at, attributes);
    if (attributes > bounds::kXmlAttributes)
      throw Error(
          Problem{"xml-syntax",
                  {file, static_cast<int>(1 + std::count(text.begin(), text.begin() + at, '\n'))},
                  "an element has more than " + std::to_string(bounds::kXmlAttributes) + " attributes",
                  "use elements instead of attributes"});
    at = text.find('<', next);
  }
}

std::string without_instructions(std::string_view text) {
  std::string out(text);
  if (text.find("<?") == std::string_view::npos) return out;
  for (std::size_t at = text.find('<'); at != std::string_view::npos;) {
    std::size_t ignored = 0;
    const std::size_t next = behind_tag(text, at, ignored);
    const std::string_view tag = text.substr(at, next - at);
    const bool declaration = tag.starts_with("<?xml") && tag.find_first_of(" \t\r\n?", 5) == 5;
    if (tag.starts_with("<?") && tag.ends_with("?>") && !declaration)
      std::replace_if(
          out.begin() + at, out.begin() + next, [](char c) { return c != '\n'; }, ' ');
    at = text.find('<', next);
  }
  return out;
}

}  // namespace polyarm
