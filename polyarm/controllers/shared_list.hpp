#pragma once
/// A list that many controllers of a cell have in common: copies share one content, and looking up a name does
/// not look at every entry. Cell thread.
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

namespace polyarm::controllers {

inline const std::string& name_in_list(const std::string& name) {
  return name;
}

/// T is a text, or name_in_list(T) is its name. Of equal names the first is found.
template <typename T>
class SharedList {
 public:
  SharedList() : content_{std::make_shared<Content>()} {}
  SharedList(std::vector<T> list) : SharedList() { content_->list = std::move(list); }  // as a vector is given
  SharedList(std::initializer_list<T> list) : SharedList(std::vector<T>(list)) {}

  const T* begin() const { return data(); }
  const T* end() const { return data() + size(); }
  const T* data() const { return content_->list.data(); }
  std::size_t size() const { return content_->list.size(); }
  bool empty() const { return content_->list.empty(); }
  const T& operator[](std::size_t i) const { return content_->list[i]; }
  const T& front() const { return content_->list.front(); }
  const T& back() const { return content_->list.back(); }
  operator const std::vector<T>&() const { return content_->list; }

  /// Null: there is none of this name.
  const T* find(std::string_view name) const {
    Content& content = *content_;
    if (content.places.empty())
      for (std::size_t i = 0; i < size(); ++i) content.places.emplace(name_in_list(content.list[i]), i);
    const auto found = content.places.find(name);
    return found == content.places.end() ? nullptr : &content.list[found->second];
  }

  /// The list to change; other copies keep theirs. Until the next call of find().
  std::vector<T>& edit() {
    if (content_.use_count() > 1) content_ = std::make_shared<Content>(Content{content_->list, {}});
    content_->places.clear();
    return content_->list;
  }
  void push_back(T entry) { edit().push_back(std::move(entry)); }

 private:
  struct Content {
    std::vector<T> list;
    std::unordered_map<std::string_view, std::size_t> places;  ///< made by the first find()
  };
  std::shared_ptr<Content> content_;
};

}  // namespace polyarm::controllers
