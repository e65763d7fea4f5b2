#pragma once
#include <memory>
#include <type_traits>

#include "polyarm_ros/standard.hpp"

namespace rcpputils {
template <typename T>
struct is_pointer : std::is_pointer<std::remove_cv_t<T>> {};
template <typename T>
struct is_pointer<std::shared_ptr<T>> : std::true_type {};
template <typename T, typename D>
struct is_pointer<std::unique_ptr<T, D>> : std::true_type {};
template <typename T>
struct remove_pointer : std::remove_pointer<T> {};
template <typename T>
struct remove_pointer<std::shared_ptr<T>> {
  using type = T;
};
template <typename T, typename D>
struct remove_pointer<std::unique_ptr<T, D>> {
  using type = T;
};
}  // namespace rcpputils
