#pragma once
#include "control_filters/node_filter.hpp"
#include "control_toolbox/exponential_filter.hpp"

namespace control_filters {
/// Parameter: alpha, the share of the new value.
template <typename T>
class ExponentialFilter : public NodeFilter<T> {
 public:
  bool configure() override {
    filter_.set_params(this->number("alpha"));
    return filter_.configure();
  }
  bool update(const T& in, T& out) override { return filter_.update(in, out); }

 private:
  control_toolbox::ExponentialFilter<T> filter_;
};
}  // namespace control_filters
