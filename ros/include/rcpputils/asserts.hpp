#pragma once
#include <stdexcept>
#include <string>

#include "polyarm_ros/standard.hpp"

namespace rcpputils {
class AssertionException : public std::logic_error {
 public:
  explicit AssertionException(const char* text) : std::logic_error(text) {}
};
class IllegalStateException : public std::logic_error {
 public:
  explicit IllegalStateException(const char* text) : std::logic_error(text) {}
};
inline void require_true(bool holds, const std::string& text = "invalid argument passed") {
  if (!holds) throw std::invalid_argument(text);
}
inline void check_true(bool holds, const std::string& text = "check reported invalid state") {
  if (!holds) throw IllegalStateException(text.c_str());
}
/// Nothing in a build without debugging.
inline void assert_true([[maybe_unused]] bool holds,
                        [[maybe_unused]] const std::string& text = "assertion failed") {
#ifndef NDEBUG
  if (!holds) throw AssertionException(text.c_str());
#endif
}
}  // namespace rcpputils
