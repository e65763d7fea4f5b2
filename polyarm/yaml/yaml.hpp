#pragma once
/// Reads YAML and keeps the place of each node, so that every error names file, line and column.
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/quantity.hpp"

namespace polyarm {

/// A node (map, list, scalar or undefined) of a YAML document. Copies are cheap and share the document.
/// Accessors throw Error("bad-value" | "missing-key") with the node's place.
class Yaml {
 public:
  /// Reads a file in one of Polyarm's own formats. A key that a map defines twice is an error
  /// ("duplicate-name").
  static Yaml load(const std::string& path);
  /// Of a repeated key the last value counts, as in ROS. `check_repeats` reports repeated keys.
  static Yaml parse(std::string_view text, std::string name);
  Yaml();
  Yaml(const Yaml&);
  Yaml(Yaml&&) noexcept;
  Yaml& operator=(const Yaml&);
  Yaml& operator=(Yaml&&) noexcept;
  ~Yaml();

  bool defined() const;  ///< present and not null
  bool is_map() const;
  bool is_list() const;
  bool is_scalar() const;
  Location where() const;

  /// The value of `key`; an undefined node if the key is missing or this is not a map.
  Yaml operator[](std::string_view key) const;
  /// The same, but a missing key is an error.
  Yaml required(std::string_view key) const;
  bool has(std::string_view key) const { return (*this)[key].defined(); }
  std::vector<std::string> keys() const;  ///< in the order of the file
  Location key_location(std::string_view key) const;
  struct Entry;
  /// The pairs of a map in file order, including duplicate keys; empty if this is not a map.
  std::vector<Entry> entries() const;
  std::vector<Yaml> items() const;  ///< of a list; a scalar counts as a list of one item, undefined as an
                                    ///< empty list

  /// The tag of the node ("!degrees"); empty if there is none.
  std::string tag() const;
  std::string text() const;
  std::string text(std::string fallback) const;
  double number(Dimension dimension = Dimension::none) const;
  double number(Dimension dimension, double fallback) const;
  bool boolean() const;
  bool boolean(bool fallback) const;
  std::vector<double> numbers(Dimension dimension = Dimension::none) const;
  std::vector<std::string> texts() const;
  /// A list of three.
  Vec3 vec3(Dimension dimension = Dimension::length) const;
  /// A map with `xyz` or `at` (metres) and `rpy` (radians) or `quaternion` (x y z w), or a list of 3, 6 or 7.
  Pose pose() const;

  /// For messages: named() is the key of this node ("'hardware'"), kind() is what it contains ("a list of 2
  /// values").
  std::string named() const;
  std::string kind() const;

  /// Reports every key of this map that is not in `known` as a problem, with the nearest known name.
  void check_keys(const std::vector<std::string>& known, Problems& problems) const;

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

struct Yaml::Entry {
  std::string key;
  Location where;  ///< of the key
  Yaml value;      ///< undefined if the file has `key:` without a value
};

}  // namespace polyarm
