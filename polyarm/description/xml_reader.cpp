#include "polyarm/description/xml_reader.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/base/xml_bounds.hpp"

namespace polyarm::description {

namespace {

bool holds(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string tag_of(const tinyxml2::XMLElement& e) {
  return std::string("<") + e.Name() + ">";
}

std::string tags(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "<" : ", <") + name + ">";
  return out;
}

}  // namespace

void XmlReader::parse(tinyxml2::XMLDocument& document, std::string_view text, const std::string& file) {
  check_xml_bounds(text, file);
  const std::string plain = without_instructions(text);
  if (document.Parse(plain.data(), plain.size()) != tinyxml2::XML_SUCCESS)
    throw Error(Problem{"xml-syntax",
                        {file, document.ErrorLineNum()},
                        "not valid XML: " + std::string(document.ErrorName()),
                        "check that every element is closed and every quote has its partner"});
}

std::string XmlReader::attribute(const Element& e, const char* name, const std::string& example) {
  std::string out = optional_attribute(e, name);
  if (out.empty())
    error(e, "missing-attribute", tag_of(e) + " has no attribute '" + name + "'",
          std::string("write ") + name + "=\"" + example + "\"");
  return out;
}

std::string XmlReader::optional_attribute(const Element& e, const char* name) {
  const char* value = e.Attribute(name);
  return std::string(trim(value ? value : ""));
}

std::optional<double> XmlReader::number(const Element* e, const char* name) {
  const char* value = e ? e->Attribute(name) : nullptr;
  if (!value) return std::nullopt;
  const auto out = parse_number(value);
  if (!out) error(*e, "bad-number", std::string(name) + "=\"" + value + "\" is not a number");
  return out;
}

std::optional<bool> XmlReader::boolean_of(const Element& e, const std::string& label, std::string_view text) {
  const std::string value = lower(trim(text));
  if (value == "true" || value == "1") return true;
  if (value == "false" || value == "0") return false;
  error(e, "bad-value", label + " is '" + value + "', which is neither true nor false",
        "write true or false");
  return std::nullopt;
}

std::optional<bool> XmlReader::boolean(const Element& e, const char* name) {
  const char* value = e.Attribute(name);
  if (!value) return std::nullopt;
  return boolean_of(e, std::string(name) + " of " + tag_of(e), value);
}

std::optional<int> XmlReader::whole(const Element& e, const char* name, int least) {
  const char* value = e.Attribute(name);
  if (!value) return std::nullopt;
  const auto out = parse_number(value);
  if (out && *out >= least && *out <= 1e9 && *out == std::floor(*out)) return static_cast<int>(*out);
  error(e, "bad-value",
        std::string(name) + "=\"" + value + "\" is not a whole number of at least " + std::to_string(least));
  return std::nullopt;
}

std::string XmlReader::text(const Element* e) {
  const char* inside = e ? e->GetText() : nullptr;
  return std::string(trim(inside ? inside : ""));
}

std::optional<double> XmlReader::number_inside(const Element& e) {
  const std::string inside = text(&e);
  const auto out = parse_number(inside);
  if (!out) error(e, "bad-number", tag_of(e) + " is '" + inside + "', which is not a number");
  return out;
}

std::optional<bool> XmlReader::boolean_inside(const Element& e) {
  return boolean_of(e, tag_of(e), text(&e));
}

XmlReader::Parameters XmlReader::parameters(const Element& e) {
  Parameters out;
  for (const Element* p = e.FirstChildElement("param"); p; p = p->NextSiblingElement("param")) {
    const std::string name = attribute(*p, "name");
    if (name.empty()) continue;
    if (!out.insert_or_assign(name, text(p)).second)
      warning(*p, "duplicate-name", "the parameter '" + name + "' is given twice; the last one counts");
  }
  return out;
}

void XmlReader::check_children(const Element& e, const std::vector<std::string>& known) {
  for (const Element* c = e.FirstChildElement(); c; c = c->NextSiblingElement()) {
    if (holds(known, c->Name())) continue;
    const std::string hint = suggest_(c->Name(), known);
    if (hint.empty())
      warning(*c, "unknown-tag", tag_of(*c) + " in " + tag_of(e) + " is ignored",
              "known here: " + tags(known));
    else
      error(*c, "unknown-tag", tag_of(*c) + " is unknown in " + tag_of(e) + hint,
            "known here: " + tags(known));
  }
}

void XmlReader::check_attributes(const Element& e, const std::vector<std::string>& known) {
  for (const tinyxml2::XMLAttribute* a = e.FirstAttribute(); a; a = a->Next()) {
    const std::string name = a->Name();
    if (name.find(':') != std::string::npos || name == "xmlns" || holds(known, name)) continue;
    warning(e, "unknown-attribute",
            "the attribute '" + name + "' of " + tag_of(e) + " is ignored" + suggest_(name, known));
  }
}

}  // namespace polyarm::description
