#include "polyarm/controllers/filters.hpp"

#include <numbers>

namespace polyarm::controllers {

FirstOrderFilter FirstOrderFilter::low_pass(double sampling_frequency, double damping_frequency,
                                            double intensity) {
  const double decay = 2 * std::numbers::pi * damping_frequency / sampling_frequency;
  const double a = std::exp(-decay * std::pow(10, intensity / 10));
  return {a, 1 - a, 0};
}

}  // namespace polyarm::controllers
