#pragma once
/// A value, or why there is none. The part of tl::expected that controllers use.
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <variant>

namespace tl {

template <class E>
class unexpected {
 public:
  explicit unexpected(E error) : error_(std::move(error)) {}
  const E& value() const& { return error_; }
  E& value() & { return error_; }
  E&& value() && { return std::move(error_); }

 private:
  E error_;
};
template <class E>
unexpected<std::decay_t<E>> make_unexpected(E&& error) {
  return unexpected<std::decay_t<E>>(std::forward<E>(error));
}

template <class E>
class bad_expected_access : public std::runtime_error {
 public:
  explicit bad_expected_access(E error)
      : std::runtime_error("there is no value"), error_(std::move(error)) {}
  const E& error() const { return error_; }

 private:
  E error_;
};

template <class T, class E>
class expected {
  using Value = std::conditional_t<std::is_void_v<T>, std::monostate, T>;
  using Reference = std::add_lvalue_reference_t<T>;

 public:
  using value_type = T;
  using error_type = E;
  expected() : held_(std::in_place_index<0>) {}
  template <class U, std::enable_if_t<std::is_constructible_v<Value, U&&> &&
                                          !std::is_same_v<std::decay_t<U>, expected> && !std::is_void_v<T>,
                                      int> = 0>
  expected(U&& value) : held_(std::in_place_index<0>, std::forward<U>(value)) {}  // NOLINT: implicit
  template <class Other>
  expected(const unexpected<Other>& e) : held_(std::in_place_index<1>, e.value()) {}  // NOLINT: implicit
  template <class Other>
  expected(unexpected<Other>&& e) : held_(std::in_place_index<1>, std::move(e).value()) {}  // NOLINT: implicit

  bool has_value() const { return held_.index() == 0; }
  explicit operator bool() const { return has_value(); }
  Reference value() {
    if (!has_value()) throw bad_expected_access<E>(error());
    if constexpr (!std::is_void_v<T>) return std::get<0>(held_);
  }
  std::add_lvalue_reference_t<const T> value() const {
    if (!has_value()) throw bad_expected_access<E>(error());
    if constexpr (!std::is_void_v<T>) return std::get<0>(held_);
  }
  template <class U>
  Value value_or(U&& otherwise) const {
    return has_value() ? std::get<0>(held_) : static_cast<Value>(std::forward<U>(otherwise));
  }
  Value& operator*() { return std::get<0>(held_); }
  const Value& operator*() const { return std::get<0>(held_); }
  Value* operator->() { return &std::get<0>(held_); }
  const Value* operator->() const { return &std::get<0>(held_); }
  const E& error() const { return std::get<1>(held_); }
  E& error() { return std::get<1>(held_); }

 private:
  std::variant<Value, E> held_;
};

}  // namespace tl
