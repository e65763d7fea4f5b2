#pragma once
/// The nodes of a YAML text as a tree. It is built in one pass, keeps the order and places of the file, and
/// finds keys of large maps without a linear search.
#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm {

struct YamlNode {
  enum class Kind : unsigned char { null, scalar, list, map };
  Kind kind = Kind::null;
  int line = 0, column = 0;  ///< 1-based; 0: unknown
  std::string scalar, tag;
  /// A map has keys and values; a list has values without keys. In file order.
  std::vector<std::pair<const YamlNode*, const YamlNode*>> entries;

  /// The last value of `key` and the first place of the key; null if the map does not contain it.
  const YamlNode* value_of(std::string_view key) const;
  const YamlNode* key_of(std::string_view key) const;
  /// Call it when the entries are complete.
  void index();

 private:
  struct Found {
    const YamlNode *key, *value;
  };
  std::unique_ptr<std::unordered_map<std::string_view, Found>> found_;  ///< only for large maps
};

/// A document owns its nodes. Aliases share nodes; no node contains itself.
struct YamlDocument {
  std::string file;
  std::deque<YamlNode> nodes;
  const YamlNode* root = nullptr;

  Location where(const YamlNode& node) const { return {file, node.line, node.column}; }

  /// The first document of the text. Throws Error("yaml-syntax" | "too-large").
  static std::shared_ptr<const YamlDocument> parse(std::string_view text, std::string file);
};

}  // namespace polyarm
