#include "polyarm/hardware/driver_facts.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "polyarm/base/text.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::hardware {

namespace {
Location place_of(const ComponentContext& context) {
  for (const RobotInstance& robot : context.robots)
    for (const description::HardwareInfo& block : robot.hardware) return block.where;
  return {};
}

std::optional<bool> parse_boolean(const std::string& text) {
  for (const char* yes : {"true", "on", "yes", "1"})
    if (equal_ignoring_case(text, yes)) return true;
  for (const char* no : {"false", "off", "no", "0"})
    if (equal_ignoring_case(text, no)) return false;
  return std::nullopt;
}

std::string range_of(const DriverParameter& p) {
  const bool low = p.least > -std::numeric_limits<double>::infinity();
  const bool high = p.most < std::numeric_limits<double>::infinity();
  if (low && high) return "a number from " + format_number(p.least) + " to " + format_number(p.most);
  if (low) return "a number of at least " + format_number(p.least);
  return high ? "a number of at most " + format_number(p.most) : "a number";
}
}  // namespace

DriverParameters::DriverParameters(const DriverFacts& facts, const ComponentContext& context)
    : facts_(facts), values_(context.parameters), component_(context.name), where_(place_of(context)) {
  std::vector<std::string> names, unused;
  for (const DriverParameter& p : facts.parameters) {
    names.emplace_back(p.name);
    if (!values_.contains(p.name)) unused.emplace_back(p.name);
  }
  for (const auto& [name, value] : values_)
    if (std::find(names.begin(), names.end(), name) == names.end() && nearest_name(name, unused))
      problems_.error("unknown-key", where_,
                      "'" + component_ + "' has no parameter '" + name + "'" + did_you_mean(name, unused),
                      "its parameters are: " + join(names, ", "));
}

const DriverParameter& DriverParameters::declared(const char* name) const {
  const auto found = std::find_if(facts_.parameters.begin(), facts_.parameters.end(),
                                  [&](const DriverParameter& p) { return std::strcmp(p.name, name) == 0; });
  assert(found != facts_.parameters.end() && "a parameter that the driver does not declare");
  return *found;
}

bool DriverParameters::given(const char* name) const {
  return values_.contains(name);
}

std::string DriverParameters::written(const DriverParameter& p) {
  if (const auto found = values_.find(p.name); found != values_.end())
    return std::string(trim(found->second));
  if (p.fallback) return p.fallback;
  problems_.error("missing-key", where_, "'" + component_ + "' needs the parameter '" + p.name + "'",
                  p.meaning);
  return {};
}

void DriverParameters::refuse(const DriverParameter& p, const std::string& value, const std::string& why) {
  problems_.error("bad-value", where_, "'" + component_ + "': " + p.name + " is '" + value + "', not " + why,
                  p.meaning);
}

std::string DriverParameters::text(const char* name) {
  const DriverParameter& p = declared(name);
  const std::string value = written(p);
  if (!p.one_of || (value.empty() && !p.fallback)) return value;
  const std::vector<std::string> allowed = split_words(p.one_of);
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return value;
  refuse(p, value, "one of " + join(allowed, ", ") + did_you_mean(value, allowed));
  return p.fallback ? p.fallback : allowed.front();
}

double DriverParameters::number(const char* name) {
  const DriverParameter& p = declared(name);
  const std::string value = written(p);
  const auto number = parse_number(value);
  if (number && *number >= p.least && *number <= p.most) return *number;
  if (!value.empty() || p.fallback) refuse(p, value, range_of(p));
  return p.fallback ? parse_number(p.fallback).value_or(0) : 0;
}

bool DriverParameters::boolean(const char* name) {
  const DriverParameter& p = declared(name);
  const std::string value = written(p);
  if (const auto yes = parse_boolean(value)) return *yes;
  if (!value.empty() || p.fallback) refuse(p, value, "true or false");
  return p.fallback && parse_boolean(p.fallback).value_or(false);
}

}  // namespace polyarm::hardware
