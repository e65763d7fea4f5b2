#pragma once
/// Shared base of the readers of XML descriptions: values of elements, and problems with line numbers.
#include <tinyxml2.h>

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/description/suggestions.hpp"

namespace polyarm::description {

/// Base class of the readers, private to this room. Unusable input is added to `problems`, ignored input to
/// `warnings`; both may be the same list.
class XmlReader {
 protected:
  using Element = tinyxml2::XMLElement;
  using Parameters = std::map<std::string, std::string>;

  XmlReader(std::string file, Problems& problems, Problems& warnings)
      : file_(std::move(file)), problems_(problems), warnings_(warnings) {}

  /// Throws Error("xml-syntax") with the line.
  static void parse(tinyxml2::XMLDocument& document, std::string_view text, const std::string& file);

  Location at(const Element& e) const { return {file_, e.GetLineNum()}; }
  void error(const Element& e, std::string code, std::string what, std::string advice = {}) {
    problems_.error(std::move(code), at(e), std::move(what), std::move(advice));
  }
  void warning(const Element& e, std::string code, std::string what, std::string advice = {}) {
    warnings_.warning(std::move(code), at(e), std::move(what), std::move(advice));
  }

  /// Trimmed; a missing or empty attribute is a problem with a hint.
  std::string attribute(const Element& e, const char* name, const std::string& example = "…");
  /// Trimmed; empty if it is missing.
  static std::string optional_attribute(const Element& e, const char* name);
  /// Empty if `e` is null or has no such attribute; a problem if it is not a finite number.
  std::optional<double> number(const Element* e, const char* name);
  std::optional<bool> boolean(const Element& e, const char* name);
  /// An integer of at least `least`.
  std::optional<int> whole(const Element& e, const char* name, int least);

  /// The trimmed text inside; empty if `e` is null.
  static std::string text(const Element* e);
  static std::string text(const Element& parent, const char* child) {
    return text(parent.FirstChildElement(child));
  }
  /// The number inside; a problem if there is none.
  std::optional<double> number_inside(const Element& e);
  std::optional<bool> boolean_inside(const Element& e);
  std::optional<bool> boolean_of(const Element& e, const std::string& label, std::string_view text);
  /// `<param name="…">text</param>`
  Parameters parameters(const Element& e);

  /// A child that is not in `known` is a problem if it looks like a misspelled known one, else a warning.
  void check_children(const Element& e, const std::vector<std::string>& known);
  /// An attribute that is not in `known` is a warning.
  void check_attributes(const Element& e, const std::vector<std::string>& known);

  std::string file_;
  Problems& problems_;
  Problems& warnings_;
  Suggestions suggest_;
};

}  // namespace polyarm::description
