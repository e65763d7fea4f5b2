#pragma once
/// Reads the tags of an XML text one after the other, without a tree: files with millions of elements need no
/// memory. Knows no entities besides those of the XML standard and refuses DOCTYPE, so nothing unfolds.
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace polyarm::meshes {

class TagScanner {
 public:
  /// `text` outlives the scanner. `name` is for errors.
  TagScanner(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

  /// Advances to the next tag. False at the end. Throws Error("bad-mesh").
  bool next();

  // The tag; names are without their prefix.
  std::string_view element() const { return element_; }
  bool opens() const { return opens_; }    ///< <a> or <a/>
  bool closes() const { return closes_; }  ///< </a> or <a/>
  /// Empty if there is no such attribute.
  std::string_view attribute(std::string_view name) const;
  /// Throws Error("bad-mesh") for what is no number. `fallback` if there is no such attribute.
  double number(std::string_view name, std::optional<double> fallback = {}) const;
  int line() const;

  [[noreturn]] void refuse(const std::string& why) const;

 private:
  void skip_past(std::string_view end);
  void read_attributes(std::string_view inside);

  std::string_view text_;
  std::string name_;
  std::size_t at_ = 0, begin_ = 0;
  std::string_view element_;
  bool opens_ = false, closes_ = false;
  std::vector<std::pair<std::string_view, std::string_view>> attributes_;
};

}  // namespace polyarm::meshes
