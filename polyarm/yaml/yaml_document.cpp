#include "polyarm/yaml/yaml_document.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "polyarm/base/bounds.hpp"

namespace polyarm {

namespace {
constexpr std::size_t kMostYamlBytes = bounds::kYamlBytes, kMostYamlValues = bounds::kYamlValues;
constexpr int kDeepestYaml = bounds::kYamlNesting;
/// Maps with fewer entries are searched linearly, which costs less than building an index.
constexpr std::size_t kSmallMap = 16;

Location marked_place(const YAML::Mark& mark, const std::string& file) {
  return mark.is_null() ? Location{file} : Location{file, mark.line + 1, mark.column + 1};
}

/// Rejects nesting that is deeper than in any real file, before recursion over it can exhaust the stack.
void check_yaml_depth(std::string_view text, const std::string& file) {
  int depth = 0, line = 1;
  for (const char c : text) {
    if (c == '\n') ++line;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > kDeepestYaml)
      throw Error(Problem{"yaml-syntax", {file, line, 0}, "brackets are nested more than 64 deep", {}});
  }
}

/// The first of the first `lines` lines that is indented with a tab, counted from 1; 0: none.
int line_with_tab(std::string_view text, int lines) {
  for (int line = 1; line <= lines && !text.empty(); ++line) {
    const std::string_view one = text.substr(0, text.find('\n'));
    const auto first = one.find_first_not_of(" \t\r");
    if (first != std::string_view::npos && one.substr(0, first).find('\t') != std::string_view::npos)
      return line;
    text.remove_prefix(std::min(text.size(), one.size() + 1));
  }
  return 0;
}

/// Builds the nodes, and counts the values of the file as if every alias were written out.
class YamlBuilder : public YAML::EventHandler {
 public:
  explicit YamlBuilder(YamlDocument& out) : out_(out) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    leaf(make(YamlNode::Kind::null, mark, {}), anchor);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    YamlNode& node = make(YamlNode::Kind::scalar, mark, tag);
    node.scalar = value;
    leaf(node, anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = named_.find(anchor);
    if (known == named_.end())
      throw Error(Problem{"yaml-syntax", marked_place(mark, out_.file),
                          "this alias is inside the node that it names", "write the values out"});
    add(*known->second.node, known->second.values);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open_.push_back({&make(YamlNode::Kind::list, mark, tag), anchor});
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open_.push_back({&make(YamlNode::Kind::map, mark, tag), anchor});
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    YamlNode* node;
    YAML::anchor_t anchor;
    const YamlNode* key = nullptr;
    std::size_t values = 1;
  };
  struct Named {
    const YamlNode* node;
    std::size_t values;
  };

  YamlNode& make(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag) {
    YamlNode& node = out_.nodes.emplace_back();
    node.kind = kind;
    if (!mark.is_null()) node.line = mark.line + 1, node.column = mark.column + 1;
    node.tag = tag;
    return node;
  }
  void leaf(const YamlNode& node, YAML::anchor_t anchor) { done(node, anchor, 1); }
  void close() {
    const Open closed = open_.back();
    open_.pop_back();
    closed.node->index();
    done(*closed.node, closed.anchor, closed.values);
  }
  void done(const YamlNode& node, YAML::anchor_t anchor, std::size_t values) {
    if (anchor != 0) named_[anchor] = {&node, values};
    add(node, values);
  }
  void add(const YamlNode& node, std::size_t values) {
    if (open_.empty()) {
      out_.root = &node;
      return;
    }
    Open& in = open_.back();
    in.values += values;
    if (in.values > kMostYamlValues)
      throw Error(Problem{"too-large",
                          {out_.file},
                          "with its aliases written out the file has more than " +
                              std::to_string(kMostYamlValues) + " values",
                          "divide the file, or name fewer aliases within what other aliases name"});
    if (in.node->kind == YamlNode::Kind::list)
      in.node->entries.emplace_back(nullptr, &node);
    else if (!in.key)
      in.key = &node;
    else
      in.node->entries.emplace_back(std::exchange(in.key, nullptr), &node);
  }

  YamlDocument& out_;
  std::vector<Open> open_;
  std::unordered_map<YAML::anchor_t, Named> named_;
};
}  // namespace

void YamlNode::index() {
  if (kind != Kind::map || entries.size() <= kSmallMap) return;
  found_ = std::make_unique<std::unordered_map<std::string_view, Found>>();
  found_->reserve(entries.size());
  for (const auto& [key, value] : entries) {
    if (key->kind != Kind::scalar) continue;
    const auto [at, first] = found_->try_emplace(key->scalar, Found{key, value});
    if (!first) at->second.value = value;
  }
}

const YamlNode* YamlNode::value_of(std::string_view key) const {
  if (found_) {
    const auto at = found_->find(key);
    return at == found_->end() ? nullptr : at->second.value;
  }
  const auto at = std::find_if(entries.rbegin(), entries.rend(), [&](const auto& entry) {
    return entry.first->kind == Kind::scalar && entry.first->scalar == key;
  });
  return at == entries.rend() ? nullptr : at->second;
}

const YamlNode* YamlNode::key_of(std::string_view key) const {
  if (found_) {
    const auto at = found_->find(key);
    return at == found_->end() ? nullptr : at->second.key;
  }
  const auto at = std::find_if(entries.begin(), entries.end(), [&](const auto& entry) {
    return entry.first->kind == Kind::scalar && entry.first->scalar == key;
  });
  return at == entries.end() ? nullptr : at->first;
}

std::shared_ptr<const YamlDocument> YamlDocument::parse(std::string_view text, std::string file) {
  auto out = std::make_shared<YamlDocument>();
  out->file = std::move(file);
  if (text.size() > kMostYamlBytes)
    throw Error(Problem{"too-large",
                        {out->file},
                        "the text has more than " + std::to_string(kMostYamlBytes) + " bytes",
                        "divide the file"});
  check_yaml_depth(text, out->file);
  std::istringstream in{std::string(text)};
  try {
    YAML::Parser parser(in);
    YamlBuilder builder(*out);
    parser.HandleNextDocument(builder);
  } catch (const YAML::Exception& e) {
    if (const int line = line_with_tab(text, e.mark.line + 1); line > 0)
      throw Error(Problem{"yaml-syntax",
                          {out->file, line, 1},
                          "not valid YAML: a tab indents this line",
                          "write blanks: YAML takes no tabs there"});
    throw Error(Problem{"yaml-syntax", marked_place(e.mark, out->file), "not valid YAML: " + e.msg,
                        "check indentation, colons and quotes on this line and the one before"});
  }
  if (!out->root) out->root = &out->nodes.emplace_back();
  return out;
}

}  // namespace polyarm
