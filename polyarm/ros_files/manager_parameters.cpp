#include "polyarm/ros_files/manager_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/superseded_keys.hpp"

namespace polyarm::ros_files {

namespace {
using M = ManagerParameters;

struct Whole {
  double M::*member;
  double least, most;
};
using Target = std::variant<bool M::*, double M::*, std::string M::*, std::vector<std::string> M::*,
                            std::vector<double> M::*, std::optional<bool> M::*, Whole>;

struct Field {
  const char* key;
  Target target;
};

const Field kFields[] = {
    {"update_rate", Whole{&M::update_rate, 1, 10000}},
    {"enforce_command_limits", &M::enforce_command_limits},
    {"hardware_components_initial_state.unconfigured", &M::unconfigured},
    {"hardware_components_initial_state.inactive", &M::inactive},
    {"defaults.switch_controller.strictness", &M::strictness},
    {"overruns.print_warnings", &M::overruns_print_warnings},
    {"thread_priority", Whole{&M::thread_priority, 1, 99}},
    {"cpu_affinity", &M::cpu_affinity},
    {"lock_memory", &M::lock_memory},
};

/// A boolean parameter whose value is fixed here.
struct Settled {
  const char* key;
  bool here;
  const char* why;
};
constexpr Settled kSettled[] = {
    {"handle_exceptions", true, "a controller that throws is stopped, and the process continues"},
    {"hardware_components_initial_state.shutdown_on_initial_state_failure", true,
     "a cell whose hardware does not reach its first state does not start"},
    {"defaults.allow_controller_activation_with_inactive_hardware", false,
     "a controller starts when the hardware that it commands is active"},
    {"defaults.deactivate_controllers_on_hardware_self_deactivate", true,
     "if hardware deactivates itself, its controllers stop"},
    {"overruns.manage", true, "after a late cycle, the next one comes at its normal time"},
    {"hardware_synchronization.expect_blocking_read_write", false, "the control loop keeps the time"},
};

struct WithoutEffect {
  const char* pattern;
  const char* why;
};
constexpr WithoutEffect kWithoutEffect[] = {
    {"diagnostics.*", "health figures are always kept and need no thresholds"},
    {"hardware_synchronization.minimum_cycle_time", "the control loop keeps the time"},
    {"use_sim_time", "a cell has one clock"},
    {"qos_overrides.*", "there are no topics in between"},
    {"start_type_description_service", "there is no such service"},
};

std::vector<std::string> known_keys() {
  std::vector<std::string> out;
  for (const Field& field : kFields) out.push_back(field.key);
  for (const Settled& row : kSettled) out.push_back(row.key);
  out.push_back("use_sim_time");
  return out;
}

const WithoutEffect* without_effect(std::string_view key) {
  for (const WithoutEffect& row : kWithoutEffect)
    if (matches_pattern(row.pattern, key)) return &row;
  return nullptr;
}

const Field* field_of(std::string_view key) {
  for (const Field& field : kFields)
    if (key == field.key) return &field;
  return nullptr;
}

const Settled* settled(std::string_view key) {
  for (const Settled& row : kSettled)
    if (key == row.key) return &row;
  return nullptr;
}

void compare(const Settled& row, const ParameterReader::Entry& entry, ParameterReader& reader,
             Problems& problems) {
  bool asked = row.here;
  reader.read(row.key, entry, asked);
  if (asked != row.here)
    problems.warning("no-effect", entry.where,
                     "'" + std::string(row.key) + (asked ? ": true'" : ": false'") + " changes nothing here",
                     row.why);
}

void set(const Field& field, const ParameterReader::Entry& entry, ParameterReader& reader, M& out) {
  std::visit(
      [&](const auto& target) {
        if constexpr (std::is_same_v<std::decay_t<decltype(target)>, Whole>)
          reader.whole(field.key, entry, target.least, target.most, out.*target.member);
        else if constexpr (std::is_same_v<std::decay_t<decltype(target)>, std::optional<bool> M::*>)
          reader.read(field.key, entry, (out.*target).emplace());
        else
          reader.read(field.key, entry, out.*target);
      },
      field.target);
}

void check_strictness(const ParameterReader::Entry& entry, M& out, Problems& problems) {
  static const std::vector<std::string> kKnown = {"best_effort", "strict", "auto", "force_auto"};
  out.strictness = lower(out.strictness);
  if (std::find(kKnown.begin(), kKnown.end(), out.strictness) != kKnown.end()) return;
  problems.error("bad-value", entry.where,
                 "'" + out.strictness + "' is not a strictness" + did_you_mean(out.strictness, kKnown),
                 "write one of " + join(kKnown, ", "));
  out.strictness.clear();
}

void unknown(const std::string& key, const Location& where, Problems& problems) {
  if (const char* instead = superseded("controller_manager", key))
    return problems.warning("superseded-key", where,
                            "'" + key + "' is no longer known to a controller manager", instead);
  problems.warning(
      "unknown-key", where,
      "'" + key + "' is not a parameter of a controller manager" + did_you_mean(key, known_keys()),
      "it is ignored");
}
}  // namespace

bool ParameterReader::single(const std::string& key, const Entry& entry, const char* wanted) {
  if (entry.values.empty() && !entry.list) return false;  // already reported by the file reader
  if (!entry.list && entry.values.size() == 1) return true;
  problems_.error("bad-value", entry.where, "'" + key + "' is a list of values here",
                  std::string("write ") + wanted);
  return false;
}

void ParameterReader::refuse(const std::string& key, const Entry& entry, const std::string& wanted) {
  problems_.error("bad-value", entry.where,
                  "'" + key + ": " + join(entry.values, ", ") + "' is not " + wanted, "write " + wanted);
}

void ParameterReader::read(const std::string& key, const Entry& entry, bool& out) {
  if (!single(key, entry, "true or false")) return;
  const std::string value = lower(entry.values.front());
  if (value == "true" || value == "yes" || value == "on")
    out = true;
  else if (value == "false" || value == "no" || value == "off")
    out = false;
  else
    refuse(key, entry, "true or false");
}

void ParameterReader::read(const std::string& key, const Entry& entry, double& out) {
  if (!single(key, entry, "a number")) return;
  if (const auto value = parse_number(entry.values.front()))
    out = *value;
  else
    refuse(key, entry, "a number");
}

void ParameterReader::read(const std::string& key, const Entry& entry, std::string& out) {
  if (single(key, entry, "one word")) out = entry.values.front();
}

void ParameterReader::read(const std::string&, const Entry& entry, std::vector<std::string>& out) {
  out.clear();
  for (const std::string& value : entry.values)
    if (!value.empty()) out.push_back(value);
}

void ParameterReader::read(const std::string& key, const Entry& entry, std::vector<double>& out) {
  out.clear();
  for (const std::string& text : entry.values) {
    const auto value = parse_number(text);
    if (!value || *value != std::floor(*value)) return refuse(key, entry, "a list of whole numbers");
    if (*value >= 0) out.push_back(*value);  // -1 means any core
  }
}

void ParameterReader::whole(const std::string& key, const Entry& entry, double least, double most,
                            double& out) {
  const std::string range = "a whole number from " + format_number(least) + " to " + format_number(most);
  if (!single(key, entry, range.c_str())) return;
  const std::string& text = entry.values.front();
  const auto value = parse_number(text);
  if (!value || *value != std::floor(*value) || *value < least || *value > most)
    return refuse(key, entry, range);
  out = *value;
  if (text.find_first_of(".eE") != std::string::npos)
    problems_.warning("bad-value", entry.where, "'" + key + ": " + text + "' is not a whole number to ROS",
                      "write " + format_number(*value));
}

ManagerParameters read_manager(const controllers::Parameters& parameters,
                               const std::function<bool(const std::string&)>& is_controller,
                               const std::function<bool(const std::string&)>& is_own,
                               std::vector<UnusedKey>& unused, Problems& problems) {
  ManagerParameters out;
  ParameterReader reader(problems);
  for (const auto& [key, entry] : parameters.entries) {
    if (const Field* field = field_of(key))
      set(*field, entry, reader, out);
    else if (const Settled* row = settled(key))
      compare(*row, entry, reader, problems);
    else if (const WithoutEffect* row = without_effect(key))
      unused.push_back({key, entry.where, row->why});
    else if (is_own(key) && !is_controller(key.substr(0, key.find('.'))))
      unknown(key, entry.where, problems);
    if (key == "defaults.switch_controller.strictness") check_strictness(entry, out, problems);
  }
  return out;
}

bool is_manager_key(std::string_view key) {
  return field_of(key) || settled(key) || without_effect(key);
}

}  // namespace polyarm::ros_files
