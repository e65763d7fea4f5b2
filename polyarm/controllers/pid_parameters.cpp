#include "polyarm/controllers/pid_parameters.hpp"

#include <cmath>
#include <cstddef>

namespace polyarm::controllers {

namespace {

Location place_of(const Parameters& parameters, const std::string& prefix) {
  for (const auto& [key, entry] : parameters.entries)
    if (key.starts_with(prefix + ".")) return entry.where;
  return {};
}

void read_antiwindup(Parameters& p, const std::string& prefix, PidGains& gains) {
  std::string strategy = "none";
  p.read(prefix + ".antiwindup_strategy", strategy,
         {.text = "what keeps the integral from growing while the output is limited",
          .choices = {"none", "back_calculation", "conditional_integration", "legacy"}});
  if (strategy == "back_calculation") gains.antiwindup = AntiWindup::back_calculation;
  if (strategy == "conditional_integration") gains.antiwindup = AntiWindup::conditional_integration;
}

}  // namespace

void read_pid_gains(Parameters& p, const std::string& prefix, PidGains& gains) {
  const auto number = [&](const char* key, double& value, const char* text) {
    p.read(prefix + "." + key, value, {.text = text, .changeable = true});
  };
  number("p", gains.p, "proportional gain");
  number("i", gains.i, "integral gain");
  number("d", gains.d, "derivative gain");
  if (p.has(prefix + ".i_clamp")) {
    double clamp = 0;
    p.read(prefix + ".i_clamp", clamp, {.text = "limit of the integral term, both ways", .least = 0});
    gains.i_max = clamp;
    gains.i_min = -clamp;
  }
  number("u_clamp_max", gains.u_max, "largest output");
  number("u_clamp_min", gains.u_min, "smallest output");
  number("i_clamp_max", gains.i_max, "largest integral term");
  number("i_clamp_min", gains.i_min, "smallest integral term");
  number("tracking_time_constant", gains.tracking_time_constant,
         "s in which back calculation takes the excess back; 0: from the gains");
  number("error_deadband", gains.error_deadband, "errors below this are not integrated");
  read_antiwindup(p, prefix, gains);
  p.superseded((prefix + ".antiwindup").c_str(),
               "write antiwindup_strategy: none, back_calculation or conditional_integration");
  if (const auto why = check(gains))
    p.problems().error("bad-value", place_of(p, prefix), prefix + ": " + *why);
}

std::string refuse_pid_changes(const std::vector<ParameterChange>& changes,
                               const std::vector<PidGains>& gains) {
  for (const PidGains& present : gains) {
    PidGains wanted = present;
    const auto* first = reinterpret_cast<const std::byte*>(&present);
    bool touched = false;
    for (const ParameterChange& change : changes) {
      const auto* cell = static_cast<const std::byte*>(change.cell);
      if (cell < first || cell >= first + sizeof(PidGains)) continue;
      *reinterpret_cast<double*>(reinterpret_cast<std::byte*>(&wanted) + (cell - first)) = change.value;
      touched = true;
    }
    if (!touched) continue;
    if (const auto why = check(wanted)) return *why;
  }
  return {};
}

}  // namespace polyarm::controllers
