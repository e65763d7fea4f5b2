#pragma once
#include "message_filters/simple_filter.hpp"

namespace message_filters {
/// Gives on what it gets.
template <typename M>
class PassThrough : public SimpleFilter<M> {
 public:
  using typename SimpleFilter<M>::EventType;
  using typename SimpleFilter<M>::MConstPtr;
  PassThrough() = default;
  template <typename Filter>
  explicit PassThrough(Filter& from) {
    connectInput(from);
  }
  template <typename Filter>
  void connectInput(Filter& from) {
    input_.disconnect();
    input_ = from.registerCallback([this](const EventType& event) { add(event); });
  }
  void add(const MConstPtr& message) { this->signalMessage(message); }
  void add(const EventType& event) { this->signalMessage(event); }
  ~PassThrough() override { input_.disconnect(); }

 private:
  Connection input_;
};
}  // namespace message_filters
