#include "polyarm/controllers/controller.hpp"

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {
const Parameters::Entry* look_up(const Parameters& parameters, std::string_view key) {
  const auto found = parameters.entries.find(std::string(key));
  return found == parameters.entries.end() || found->second.values.empty() ? nullptr : &found->second;
}

[[noreturn]] void refuse(const Parameters::Entry& entry, std::string_view key, const char* wanted) {
  throw Error(Problem{"bad-value",
                      entry.where,
                      "'" + std::string(key) + ": " + entry.values.front() + "' is not " + wanted,
                      {}});
}
}  // namespace

bool Parameters::has(std::string_view key) const {
  return look_up(*this, key) != nullptr;
}

std::string Parameters::text(std::string_view key, std::string fallback) const {
  const Entry* entry = look_up(*this, key);
  return entry ? entry->values.front() : std::move(fallback);
}

double Parameters::number(std::string_view key, double fallback) const {
  const Entry* entry = look_up(*this, key);
  if (!entry) return fallback;
  const auto value = parse_number(entry->values.front());
  if (!value) refuse(*entry, key, "a number");
  return *value;
}

bool Parameters::boolean(std::string_view key, bool fallback) const {
  const Entry* entry = look_up(*this, key);
  if (!entry) return fallback;
  const std::string value = lower(entry->values.front());
  if (value == "true") return true;
  if (value == "false") return false;
  refuse(*entry, key, "true or false");
}

std::vector<std::string> Parameters::list(std::string_view key) const {
  const Entry* entry = look_up(*this, key);
  return entry ? entry->values : std::vector<std::string>{};
}

const JointFacts* ControllerContext::find_joint(std::string_view whole_name) const {
  for (const JointFacts& joint : joints)
    if (joint.name == whole_name) return &joint;
  return nullptr;
}

}  // namespace polyarm::controllers
