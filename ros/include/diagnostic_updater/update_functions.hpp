#pragma once
/// Tasks that watch how often something happens. What they report leads nowhere, as all diagnostics.
#include <map>

#include "diagnostic_updater/diagnostic_updater.hpp"
#include "rclcpp/clock.hpp"
#include "rclcpp/time.hpp"

namespace diagnostic_updater {

struct FrequencyStatusParam {
  FrequencyStatusParam(double* least, double* most, double tolerance = 0.1, int window = 5)
      : min_freq_(least), max_freq_(most), tolerance_(tolerance), window_size_(window) {}
  double *min_freq_, *max_freq_;
  double tolerance_;
  int window_size_;
};
struct TimeStampStatusParam {
  explicit TimeStampStatusParam(double least = -1, double most = 5)
      : max_acceptable_(most), min_acceptable_(least) {}
  double max_acceptable_, min_acceptable_;
};
class FrequencyStatus : public DiagnosticTask {
 public:
  explicit FrequencyStatus(const FrequencyStatusParam&, const std::string& name = "FrequencyStatus")
      : DiagnosticTask(name) {}
  void tick() {}
  void clear() {}
  void run(DiagnosticStatusWrapper& status) override { status.summary(0, ""); }
};
class TimeStampStatus : public DiagnosticTask {
 public:
  explicit TimeStampStatus(const TimeStampStatusParam& = TimeStampStatusParam(),
                           const std::string& name = "Timestamp Status")
      : DiagnosticTask(name) {}
  template <typename Stamp>
  void tick(const Stamp&) {}
  void run(DiagnosticStatusWrapper& status) override { status.summary(0, ""); }
};
class Heartbeat : public DiagnosticTask {
 public:
  Heartbeat() : DiagnosticTask("Heartbeat") {}
  void run(DiagnosticStatusWrapper& status) override { status.summary(0, "Alive"); }
};

}  // namespace diagnostic_updater
