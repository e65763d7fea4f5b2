#include "polyarm/controllers/pid_parameters.hpp"

#include <cmath>
#include <cstddef>
#include <optional>

namespace polyarm::controllers {

namespace {

Location place_of_prefix(const Parameters& parameters, const std::string& prefix) {
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
    p.problems().error("bad-value", place_of_prefix(p, prefix), prefix + ": " + *why);
}

PidGains RosControlParameters::gains() const noexcept {
  RosControlGains stated{p, i, d, i_clamp, {}, {}, antiwindup};
  if (!std::isnan(i_clamp_min)) stated.i_clamp_min = i_clamp_min;
  if (!std::isnan(i_clamp_max)) stated.i_clamp_max = i_clamp_max;
  PidGains out = gains_of(stated);
  out.u_min = u_min;
  out.u_max = u_max;
  return out;
}

void read_ros_control_gains(Parameters& p, const std::string& prefix, RosControlParameters& gains) {
  const auto number = [&](const char* key, double& value, const char* text) {
    p.read(prefix + "." + key, value, {.text = text, .changeable = true});
  };
  number("p", gains.p, "proportional gain");
  number("i", gains.i, "integral gain");
  number("d", gains.d, "derivative gain");
  number("i_clamp", gains.i_clamp, "limit of the integral's share of the output, both ways");
  number("i_clamp_max", gains.i_clamp_max, "the upper limit, if it differs");
  number("i_clamp_min", gains.i_clamp_min, "the lower limit, if it differs");
  number("u_clamp_max", gains.u_max, "largest output");
  number("u_clamp_min", gains.u_min, "smallest output");
  p.read(prefix + ".antiwindup", gains.antiwindup,
         {.text = "the integral itself is clamped, not only its share of the output", .changeable = true});
  bool publish_state = false;
  p.read(prefix + ".publish_state", publish_state, {"the state can always be watched"});
  const PidGains read = gains.gains();
  if (!p.has(prefix + ".p"))
    p.problems().error("missing-parameter", place_of_prefix(p, prefix), "'" + prefix + "' states no gain p",
                       "write " + prefix + ": {p: 100, i: 10, d: 1, i_clamp: 20}");
  else if (const auto why = check(read))
    p.problems().error("bad-value", place_of_prefix(p, prefix), prefix + ": " + *why);
  else if (const auto idle = without_effect(read))
    p.problems().warning("no-effect", place_of_prefix(p, prefix), prefix + ": " + *idle);
}

namespace {
const PidGains& gains_in(const PidGains& gains) {
  return gains;
}
PidGains gains_in(const RosControlParameters& parameters) {
  return parameters.gains();
}

/// `present` with the changes whose cells lie in it; nothing where none does.
template <typename Gains>
std::optional<Gains> changed(const Gains& present, const std::vector<ParameterChange>& changes) {
  Gains wanted = present;
  const auto* first = reinterpret_cast<const std::byte*>(&present);
  bool touched = false;
  for (ParameterChange change : changes) {
    const auto* cell = static_cast<const std::byte*>(change.cell);
    if (cell < first || cell >= first + sizeof(Gains)) continue;
    change.cell = reinterpret_cast<std::byte*>(&wanted) + (cell - first);
    change.apply();
    touched = true;
  }
  return touched ? std::optional(wanted) : std::nullopt;
}

template <typename Gains>
std::string refuse(const std::vector<ParameterChange>& changes, const std::vector<Gains>& all) {
  for (const Gains& present : all)
    if (const auto wanted = changed(present, changes))
      if (const auto why = check(gains_in(*wanted))) return *why;
  return {};
}
}  // namespace

std::string refuse_pid_changes(const std::vector<ParameterChange>& changes,
                               const std::vector<PidGains>& gains) {
  return refuse(changes, gains);
}

std::string refuse_pid_changes(const std::vector<ParameterChange>& changes,
                               const std::vector<RosControlParameters>& gains) {
  return refuse(changes, gains);
}

}  // namespace polyarm::controllers
