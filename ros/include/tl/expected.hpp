#pragma once
/// A value, or an error in its place: tl::expected with its chains (map, and_then, or_else, map_error).
#include <functional>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <variant>

namespace tl {

template <class E>
class unexpected {
 public:
  unexpected() = delete;
  explicit unexpected(E error) : error_(std::move(error)) {}
  const E& value() const& { return error_; }
  E& value() & { return error_; }
  E&& value() && { return std::move(error_); }
  const E& error() const& { return error_; }

 private:
  E error_;
};
template <class E>
unexpected(E) -> unexpected<E>;
template <class E>
unexpected<std::decay_t<E>> make_unexpected(E&& error) {
  return unexpected<std::decay_t<E>>(std::forward<E>(error));
}
struct unexpect_t {
  explicit unexpect_t() = default;
};
inline constexpr unexpect_t unexpect{};
using in_place_t = std::in_place_t;
inline constexpr in_place_t in_place{};

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
class expected;

namespace detail {
template <class T>
struct is_expected : std::false_type {};
template <class T, class E>
struct is_expected<expected<T, E>> : std::true_type {};
template <class T>
struct is_unexpected : std::false_type {};
template <class E>
struct is_unexpected<unexpected<E>> : std::true_type {};

/// Calls `f` with the value of `from`, or with nothing where that is void.
template <class T, class From, class F>
decltype(auto) call(From&& from, F&& f) {
  if constexpr (std::is_void_v<T>)
    return std::invoke(std::forward<F>(f));
  else
    return std::invoke(std::forward<F>(f), *std::forward<From>(from));
}
template <class T, class From, class F>
auto map(From&& from, F&& f) {
  using E = typename std::decay_t<From>::error_type;
  using Made = std::decay_t<decltype(call<T>(std::forward<From>(from), std::forward<F>(f)))>;
  using Out = expected<Made, E>;
  if (!from.has_value()) return Out(unexpect, std::forward<From>(from).error());
  if constexpr (std::is_void_v<Made>) {
    call<T>(std::forward<From>(from), std::forward<F>(f));
    return Out();
  } else {
    return Out(call<T>(std::forward<From>(from), std::forward<F>(f)));
  }
}
template <class T, class From, class F>
auto and_then(From&& from, F&& f) {
  using Out = std::decay_t<decltype(call<T>(std::forward<From>(from), std::forward<F>(f)))>;
  static_assert(is_expected<Out>::value, "and_then takes a function that returns an expected");
  return from.has_value() ? call<T>(std::forward<From>(from), std::forward<F>(f))
                          : Out(unexpect, std::forward<From>(from).error());
}
template <class T, class From, class F>
auto map_error(From&& from, F&& f) {
  using Out = expected<T, std::decay_t<decltype(std::invoke(f, std::forward<From>(from).error()))>>;
  if (!from.has_value())
    return Out(unexpect, std::invoke(std::forward<F>(f), std::forward<From>(from).error()));
  if constexpr (std::is_void_v<T>)
    return Out();
  else
    return Out(*std::forward<From>(from));
}
/// A function that returns nothing leaves the error as it is.
template <class From, class F>
std::decay_t<From> or_else(From&& from, F&& f) {
  if (from.has_value()) return std::forward<From>(from);
  if constexpr (std::is_void_v<decltype(std::invoke(f, std::forward<From>(from).error()))>) {
    std::invoke(std::forward<F>(f), from.error());
    return std::forward<From>(from);
  } else {
    return std::invoke(std::forward<F>(f), std::forward<From>(from).error());
  }
}
}  // namespace detail

template <class T, class E>
class expected {
  using Value = std::conditional_t<std::is_void_v<T>, std::monostate, T>;
  template <class U>
  static constexpr bool kIsValue =
      std::is_constructible_v<Value, U&&> && !std::is_void_v<T> &&
      !std::is_same_v<std::decay_t<U>, expected> && !std::is_same_v<std::decay_t<U>, std::in_place_t> &&
      !std::is_same_v<std::decay_t<U>, unexpect_t> && !detail::is_unexpected<std::decay_t<U>>::value;

 public:
  using value_type = T;
  using error_type = E;
  using unexpected_type = unexpected<E>;
  expected() : held_(std::in_place_index<0>) {}
  template <class U = T, std::enable_if_t<kIsValue<U>, int> = 0>
  expected(U&& value) : held_(std::in_place_index<0>, std::forward<U>(value)) {}  // NOLINT: implicit
  template <class... Given>
  explicit expected(std::in_place_t, Given&&... given)
      : held_(std::in_place_index<0>, std::forward<Given>(given)...) {}
  template <class... Given>
  explicit expected(unexpect_t, Given&&... given)
      : held_(std::in_place_index<1>, std::forward<Given>(given)...) {}
  template <class Other>
  expected(const unexpected<Other>& e) : held_(std::in_place_index<1>, e.value()) {}  // NOLINT: implicit
  template <class Other>
  expected(unexpected<Other>&& e) : held_(std::in_place_index<1>, std::move(e).value()) {}  // NOLINT: implicit

  bool has_value() const { return held_.index() == 0; }
  explicit operator bool() const { return has_value(); }
  std::add_lvalue_reference_t<T> value() & {
    require();
    if constexpr (!std::is_void_v<T>) return std::get<0>(held_);
  }
  std::add_lvalue_reference_t<const T> value() const& {
    require();
    if constexpr (!std::is_void_v<T>) return std::get<0>(held_);
  }
  std::add_rvalue_reference_t<T> value() && {
    require();
    if constexpr (!std::is_void_v<T>) return std::move(std::get<0>(held_));
  }
  template <class U>
  Value value_or(U&& otherwise) const& {
    return has_value() ? std::get<0>(held_) : static_cast<Value>(std::forward<U>(otherwise));
  }
  template <class U>
  Value value_or(U&& otherwise) && {
    return has_value() ? std::move(std::get<0>(held_)) : static_cast<Value>(std::forward<U>(otherwise));
  }
  template <class... Given>
  Value& emplace(Given&&... given) {
    return held_.template emplace<0>(std::forward<Given>(given)...);
  }
  Value& operator*() & { return std::get<0>(held_); }
  const Value& operator*() const& { return std::get<0>(held_); }
  Value&& operator*() && { return std::move(std::get<0>(held_)); }
  Value* operator->() { return &std::get<0>(held_); }
  const Value* operator->() const { return &std::get<0>(held_); }
  const E& error() const& { return std::get<1>(held_); }
  E& error() & { return std::get<1>(held_); }
  E&& error() && { return std::move(std::get<1>(held_)); }

  template <class F>
  auto map(F&& f) const& {
    return detail::map<T>(*this, std::forward<F>(f));
  }
  template <class F>
  auto map(F&& f) && {
    return detail::map<T>(std::move(*this), std::forward<F>(f));
  }
  template <class F>
  auto transform(F&& f) const& {
    return detail::map<T>(*this, std::forward<F>(f));
  }
  template <class F>
  auto transform(F&& f) && {
    return detail::map<T>(std::move(*this), std::forward<F>(f));
  }
  template <class F>
  auto and_then(F&& f) const& {
    return detail::and_then<T>(*this, std::forward<F>(f));
  }
  template <class F>
  auto and_then(F&& f) && {
    return detail::and_then<T>(std::move(*this), std::forward<F>(f));
  }
  template <class F>
  auto map_error(F&& f) const& {
    return detail::map_error<T>(*this, std::forward<F>(f));
  }
  template <class F>
  auto map_error(F&& f) && {
    return detail::map_error<T>(std::move(*this), std::forward<F>(f));
  }
  template <class F>
  expected or_else(F&& f) const& {
    return detail::or_else(*this, std::forward<F>(f));
  }
  template <class F>
  expected or_else(F&& f) && {
    return detail::or_else(std::move(*this), std::forward<F>(f));
  }
  bool operator==(const expected& other) const { return held_ == other.held_; }
  bool operator!=(const expected& other) const { return held_ != other.held_; }

 private:
  void require() const {
    if (!has_value()) throw bad_expected_access<E>(error());
  }
  std::variant<Value, E> held_;
};

}  // namespace tl
