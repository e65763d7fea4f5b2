#pragma once
/// The nodes of a YAML text as a tree that is made in one pass, keeps the order and the places of the file,
/// and finds a key of a large map without walking it.
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
  /// Of a map keys and values, of a list values without keys; in the order of the file.
  std::vector<std::pair<const YamlNode*, const YamlNode*>> entries;

  /// The last value behind `key`, and the first place that the key stands at; null where the map has none.
  const YamlNode* value_of(std::string_view key) const;
  const YamlNode* key_of(std::string_view key) const;
  /// To be called when the entries are complete.
  void index();

 private:
  struct Found {
    const YamlNode *key, *value;
  };
  std::unique_ptr<std::unordered_map<std::string_view, Found>> found_;  ///< of a large map
};

/// A document owns its nodes; aliases share them, and none contains itself.
struct YamlDocument {
  std::string file;
  std::deque<YamlNode> nodes;
  const YamlNode* root = nullptr;

  Location where(const YamlNode& node) const { return {file, node.line, node.column}; }

  /// The first document of the text. Throws Error("yaml-syntax" | "too-large").
  static std::shared_ptr<const YamlDocument> parse(std::string_view text, std::string file);
};

}  // namespace polyarm
