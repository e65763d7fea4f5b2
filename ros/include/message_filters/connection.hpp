#pragma once
#include <functional>
#include <utility>

#include "polyarm_ros/standard.hpp"

namespace message_filters {
/// A registered callback. It stays registered when this object ends.
class Connection {
 public:
  Connection() = default;
  explicit Connection(std::function<void()> end) : end_(std::move(end)) {}
  void disconnect() {
    if (const auto end = std::exchange(end_, nullptr)) end();
  }

 private:
  std::function<void()> end_;
};
}  // namespace message_filters
