#pragma once
/// Small functions on lists and maps.
#include <algorithm>
#include <map>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "polyarm_ros/standard.hpp"

namespace ros2_control {

template <typename Container>
struct HasKeys : std::false_type {};
template <typename Key, typename... Rest>
struct HasKeys<std::map<Key, Rest...>> : std::true_type {};
template <typename Key, typename... Rest>
struct HasKeys<std::unordered_map<Key, Rest...>> : std::true_type {};

/// A value of a list, or a key of a map.
template <typename Container, typename T>
auto get_item_iterator(const Container& container, const T& item) {
  if constexpr (HasKeys<Container>::value)
    return container.find(item);
  else
    return std::find(container.begin(), container.end(), item);
}
template <typename Container, typename T>
bool has_item(const Container& container, const T& item) {
  return get_item_iterator(container, item) != container.end();
}
template <typename T>
void add_item(std::vector<T>& to, const T& item) {
  if (!has_item(to, item)) to.push_back(item);
}
template <typename T>
void add_items(std::vector<T>& to, const std::vector<T>& items) {
  for (const T& item : items) add_item(to, item);
}
template <typename T>
bool remove_item(std::vector<T>& from, const T& item) {
  const auto found = std::find(from.begin(), from.end(), item);
  if (found == from.end()) return false;
  from.erase(found);
  return true;
}
template <typename T>
bool has_any_item(const std::vector<T>& container, const std::vector<T>& items) {
  return std::any_of(items.begin(), items.end(), [&](const T& item) { return has_item(container, item); });
}
template <typename T>
bool has_all_items(const std::vector<T>& container, const std::vector<T>& items) {
  return std::all_of(items.begin(), items.end(), [&](const T& item) { return has_item(container, item); });
}
inline std::string strip(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t\r\n"), end = text.find_last_not_of(" \t\r\n");
  return begin == std::string::npos ? std::string() : text.substr(begin, end - begin + 1);
}

}  // namespace ros2_control
