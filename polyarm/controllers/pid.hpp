#pragma once
#include <limits>
#include <optional>
#include <string>
namespace polyarm::controllers {
enum class AntiWindup { none, back_calculation, conditional_integration };
struct PidGains {
  double p = 0, i = 0, d = 0;
  double u_min = -std::numeric_limits<double>::infinity(), u_max = std::numeric_limits<double>::infinity();
  double i_min = -std::numeric_limits<double>::infinity(), i_max = std::numeric_limits<double>::infinity();
  AntiWindup antiwindup = AntiWindup::none;
  double tracking_time_constant = 0, error_deadband = 0;
};
inline std::optional<std::string> check(const PidGains&) {
  return std::nullopt;
}
class Pid {
 public:
  explicit Pid(const PidGains& gains) : g_(gains) {}
  double compute(double e, double de, double dt) noexcept {
    double u = g_.p * e + i_ + g_.d * de;
    i_ += g_.i * e * dt;
    return u;
  }
  void reset() noexcept { i_ = 0; }
  void set_gains(const PidGains& g) noexcept { g_ = g; }

 private:
  PidGains g_;
  double i_ = 0;
};
}  // namespace polyarm::controllers
