#include "polyarm/broadcasters/chained_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/text.hpp"
#include "polyarm/broadcasters/sensor_interfaces.hpp"
#include "polyarm/controllers/filters.hpp"

namespace polyarm::controllers {

namespace {

using Step = ChainedFilter::Step;

/// The last values, for a mean or a median; fewer at the beginning.
class WindowStep : public Step {
 public:
  WindowStep(std::size_t count, bool median) : values_(count), sorted_(count), median_(median) {}
  double update(double value) noexcept override {
    values_[next_] = value;
    next_ = (next_ + 1) % values_.size();
    count_ = std::min(count_ + 1, values_.size());
    const auto end = values_.begin() + static_cast<std::ptrdiff_t>(count_);
    if (!median_) {
      double sum = 0;
      for (auto at = values_.begin(); at != end; ++at) sum += *at;
      return sum / static_cast<double>(count_);
    }
    std::copy(values_.begin(), end, sorted_.begin());
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(count_ / 2);
    std::nth_element(sorted_.begin(), middle, sorted_.begin() + static_cast<std::ptrdiff_t>(count_));
    return *middle;
  }
  void reset() noexcept override { next_ = count_ = 0; }

 private:
  std::vector<double> values_, sorted_;
  std::size_t next_ = 0, count_ = 0;
  bool median_;
};

class FirstOrderStep : public Step {
 public:
  explicit FirstOrderStep(FirstOrderFilter filter) : filter_(filter) {}
  double update(double value) noexcept override { return filter_.update(value); }
  void reset() noexcept override { filter_.reset(); }

 private:
  FirstOrderFilter filter_;
};

double read_positive(Parameters& p, const std::string& key, double fallback, const char* text) {
  double value = fallback;
  p.read(key, value, {text});
  if (std::isfinite(value) && value > 0) return value;
  p.problems().error("bad-value", place_of(p, key), "'" + key + "' must be a number above 0");
  return 1;
}

std::unique_ptr<Step> make_step(ControllerContext& context, const std::string& prefix,
                                const std::string& type) {
  Parameters& p = context.parameters;
  const std::string at = prefix + "params.";
  if (type.find("MeanFilter") != std::string::npos || type.find("MedianFilter") != std::string::npos) {
    int count = 1;
    p.read(at + "number_of_observations", count, {.text = "values that count", .least = 1, .most = 10000});
    return std::make_unique<WindowStep>(count, type.find("Median") != std::string::npos);
  }
  if (type.find("LowPassFilter") != std::string::npos) {
    const double sampling = read_positive(p, at + "sampling_frequency", 1 / seconds(context.period), "Hz");
    const double damping = read_positive(p, at + "damping_frequency", 1, "Hz");
    double intensity = 0;
    p.read(at + "damping_intensity", intensity, {.text = "dB", .least = -300, .most = 300});
    return std::make_unique<FirstOrderStep>(FirstOrderFilter::low_pass(sampling, damping, intensity));
  }
  if (type.find("ExponentialFilter") != std::string::npos) {
    double alpha = 0.5;
    p.read(at + "alpha", alpha, {.text = "share of the newest value", .least = 0, .most = 1});
    return std::make_unique<FirstOrderStep>(FirstOrderFilter::exponential(alpha));
  }
  p.problems().error("unknown-filter", place_of(p, prefix + "type"), "there is no filter '" + type + "'",
                     "there are filters/MeanFilterDouble, filters/MedianFilterDouble, "
                     "control_filters/LowPassFilterDouble and control_filters/ExponentialFilterDouble");
  return nullptr;
}

}  // namespace

void ChainedFilter::read_chain(ControllerContext& context, const std::string& prefix, Way& way) {
  Parameters& p = context.parameters;
  for (int n = 1;; ++n) {
    const std::string at = prefix + "filter" + std::to_string(n) + ".";
    if (!p.has(at + "type")) break;
    std::string type, name;
    p.read(at + "type", type, {"the filter"});
    p.read(at + "name", name, {"what it is called"});
    if (auto step = make_step(context, at, type)) way.steps.push_back(std::move(step));
  }
  if (way.steps.empty() && !p.problems().has_errors())
    p.problems().error("bad-value", {}, "'" + prefix + "filter1.type' is missing",
                       "write filter_chain: {filter1: {type: filters/MeanFilterDouble, …}}");
}

CallbackReturn ChainedFilter::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::vector<std::string> inputs, outputs;
  p.read("input_interfaces", inputs, {"the states to filter"});
  p.read("output_interfaces", outputs, {"the states that are exported, as many"});
  if (inputs.empty() || inputs.size() != outputs.size())
    throw Error(Problem{"bad-value", place_of(p, "output_interfaces"),
                        "there are " + std::to_string(inputs.size()) + " input_interfaces and " +
                            std::to_string(outputs.size()) + " output_interfaces",
                        "name as many of each, at least one"});
  const bool shared = p.has("filter_chain.filter1.type");
  ways_.clear();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    Way& way = ways_.emplace_back();
    const std::string whole = context.whole_name(inputs[i]);
    if (context.has_state(whole))
      way.input = claim_state(whole);
    else
      p.problems().error("unknown-interface", place_of(p, "input_interfaces"),
                         "there is no state '" + inputs[i] + "'" + did_you_mean(whole, context.state_names));
    way.output = export_state(context.name + "/" + outputs[i]);
    read_chain(context, shared ? "filter_chain." : inputs[i] + ".filter_chain.", way);
  }
  return p.problems().has_errors() ? CallbackReturn::failure : CallbackReturn::success;
}

CallbackReturn ChainedFilter::on_activate(const Cycle&) noexcept {
  for (Way& way : ways_) {
    for (const auto& step : way.steps) step->reset();
    set_exported(way.output, std::numeric_limits<double>::quiet_NaN());
  }
  return CallbackReturn::success;
}

ReturnType ChainedFilter::update(const Cycle&, const Verdict&) noexcept {
  for (Way& way : ways_) {
    double value = state(way.input);
    if (!std::isfinite(value)) continue;
    for (const auto& step : way.steps) value = step->update(value);
    set_exported(way.output, value);
  }
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
