#pragma once
/// The small XML that controllers send in a datagram or over a stream. Any thread; the reader allocates
/// nothing.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "polyarm/base/bounds.hpp"

namespace polyarm::wire {

/// One document: elements with attributes and text, in their order. No entities, comments, DTDs or sections
/// of CDATA; a declaration (`<?xml …?>`) may precede the root. The texts are parts of what was read.
class XmlDocument {
 public:
  static constexpr std::size_t kMostElements = bounds::kWireXmlElements,
                               kMostAttributes = bounds::kWireXmlAttributes,
                               kMostDepth = bounds::kWireXmlNesting;
  enum class Result : std::uint8_t { whole, incomplete, bad };

  /// Reads the first document of `text`. Only a whole document is kept.
  Result read(std::string_view text) noexcept;
  /// Characters up to the end of the document.
  std::size_t size() const noexcept { return size_; }

  struct Element {
    std::string_view name, text;
    int depth = 0;
    std::size_t first = 0, count = 0;  ///< of its attributes
  };
  const Element& root() const noexcept { return elements_[0]; }
  /// The first element below the root with this name; null without one.
  const Element* find(std::string_view name) const noexcept;
  std::optional<std::string_view> attribute(const Element& element, std::string_view name) const noexcept;
  /// Finite numbers only.
  std::optional<double> number(const Element& element, std::string_view attribute) const noexcept;
  std::optional<std::int64_t> integer(const Element& element, std::string_view attribute) const noexcept;

 private:
  struct Attribute {
    std::string_view name, value;
  };
  class Parser;
  std::array<Element, kMostElements> elements_;
  std::array<Attribute, kMostAttributes> attributes_;
  std::size_t element_count_ = 0, attribute_count_ = 0, size_ = 0;
};

std::optional<double> xml_number(std::string_view text) noexcept;
std::optional<std::int64_t> xml_integer(std::string_view text) noexcept;
/// The characters of a text that may stand in an attribute; others become spaces.
std::string xml_text(std::string_view text);

}  // namespace polyarm::wire
