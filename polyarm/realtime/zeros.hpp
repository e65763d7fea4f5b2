#pragma once
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace polyarm::realtime {

/// An array of zeros. Any thread makes it; it throws std::bad_alloc.
template <typename T>
class Zeros {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Zeros() = default;
  /// `at_once`: all memory is there when this returns, and no later write waits for it. Else the system gives
  /// large memory page by page, when it is first written.
  Zeros(std::size_t size, bool at_once) : size_(size) {
    if (size == 0) return;
    data_.reset(static_cast<T*>(std::calloc(size, sizeof(T))));
    if (!data_) throw std::bad_alloc();
    constexpr std::size_t kPage = 4096;
    auto* bytes = reinterpret_cast<volatile unsigned char*>(data_.get());
    if (at_once)
      for (std::size_t i = 0; i < size * sizeof(T); i += kPage) bytes[i] = 0;
  }
  std::size_t size() const noexcept { return size_; }
  T* data() noexcept { return data_.get(); }
  const T* data() const noexcept { return data_.get(); }
  T& operator[](std::size_t i) noexcept { return data_.get()[i]; }
  const T& operator[](std::size_t i) const noexcept { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(T* data) const noexcept { std::free(data); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};

}  // namespace polyarm::realtime
