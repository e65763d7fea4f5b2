#pragma once
#include "control_filters/node_filter.hpp"
#include "control_toolbox/low_pass_filter.hpp"

namespace control_filters {
/// Parameters: sampling_frequency, damping_frequency (Hz) and damping_intensity.
template <typename T>
class LowPassFilter : public NodeFilter<T> {
 public:
  bool configure() override {
    filter_.set_params(this->number("sampling_frequency"), this->number("damping_frequency"),
                       this->number("damping_intensity"));
    return filter_.configure();
  }
  bool update(const T& in, T& out) override { return filter_.update(in, out); }

 private:
  control_toolbox::LowPassFilter<T> filter_;
};
}  // namespace control_filters
