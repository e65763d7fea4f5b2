#include "polyarm/controllers/parameters.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {

/// Keys that every controller understands, whoever reads them.
constexpr const char* kCommonKeys[] = {"type",         "update_rate",       "is_async",
                                       "params_file",  "node_options_args", "fallback_controllers",
                                       "use_sim_time", "robot_description"};
constexpr const char* kCommonPrefixes[] = {"async_parameters.", "qos_overrides.", "introspection.",
                                           "diagnostic_updater."};

bool is_common(const std::string& key) {
  return std::any_of(std::begin(kCommonKeys), std::end(kCommonKeys),
                     [&](const char* k) { return key == k; }) ||
         std::any_of(std::begin(kCommonPrefixes), std::end(kCommonPrefixes),
                     [&](const char* p) { return key.starts_with(p); });
}

std::optional<bool> boolean_of(const std::string& text) {
  const std::string value = lower(text);
  if (value == "true" || value == "yes" || value == "on") return true;
  if (value == "false" || value == "no" || value == "off") return false;
  return std::nullopt;
}

/// YAML's words for numbers that are not finite.
std::optional<double> number_of(const std::string& text) {
  const std::string value = lower(text);
  if (value == ".nan" || value == "nan") return std::numeric_limits<double>::quiet_NaN();
  if (value == ".inf" || value == "inf" || value == "+.inf") return std::numeric_limits<double>::infinity();
  if (value == "-.inf" || value == "-inf") return -std::numeric_limits<double>::infinity();
  return parse_number(text);
}

std::string written(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  return format_number(value);
}

std::string written(const std::vector<std::string>& values) {
  return "[" + join(values, ", ") + "]";
}

std::string written(const std::vector<double>& values) {
  std::vector<std::string> words;
  for (const double value : values) words.push_back(written(value));
  return written(words);
}

std::string range_text(const ParameterNote& note) {
  if (!std::isfinite(note.least) && !std::isfinite(note.most)) return "a finite number";
  if (std::isfinite(note.least) && std::isfinite(note.most))
    return "a number from " + format_number(note.least) + " to " + format_number(note.most);
  if (std::isfinite(note.least)) return "a number of at least " + format_number(note.least);
  return "a number of at most " + format_number(note.most);
}

/// NaN is a value only where it is the default ("not stated"), infinity only where the default or a bound
/// tells that it may be.
bool within(const Declared& declared, double value) {
  const double usual = number_of(declared.fallback).value_or(0);
  if (std::isnan(value)) return std::isnan(usual);
  const bool bounded = std::isfinite(declared.note.least) || std::isfinite(declared.note.most);
  if (std::isinf(value) && !bounded && std::isfinite(usual)) return false;
  return value >= declared.note.least && value <= declared.note.most;
}

}  // namespace

const char* name(ParameterType type) {
  constexpr const char* kNames[] = {"true or false", "a whole number",    "a number",
                                    "a text",        "a list of numbers", "a list of texts"};
  return kNames[static_cast<std::size_t>(type)];
}

void ParameterChange::apply() const noexcept {
  if (type == ParameterType::boolean)
    *static_cast<bool*>(cell) = value != 0;
  else if (type == ParameterType::integer)
    *static_cast<int*>(cell) = static_cast<int>(value);
  else
    *static_cast<double*>(cell) = value;
}

bool Parameters::has(std::string_view key) const {
  const auto found = entries.find(std::string(key));
  return found != entries.end() && !found->second.values.empty();
}

namespace {
const Parameters::Entry* find_name(const Parameters& parameters, std::string_view key) {
  const auto found = parameters.entries.find(std::string(key));
  return found == parameters.entries.end() || found->second.values.empty() ? nullptr : &found->second;
}

Problem refusal(const Parameters::Entry& entry, std::string_view key, const std::string& wanted) {
  const std::string value = entry.list ? written(entry.values) : entry.values.front();
  return {"bad-value", entry.where, "'" + std::string(key) + ": " + value + "' is not " + wanted, {}};
}
}  // namespace

std::string Parameters::text(std::string_view key, std::string fallback) const {
  const Entry* entry = find_name(*this, key);
  return entry ? entry->values.front() : std::move(fallback);
}

double Parameters::number(std::string_view key, double fallback) const {
  const Entry* entry = find_name(*this, key);
  if (!entry) return fallback;
  const auto value = number_of(entry->values.front());
  if (!value) throw Error(refusal(*entry, key, "a number"));
  return *value;
}

bool Parameters::boolean(std::string_view key, bool fallback) const {
  const Entry* entry = find_name(*this, key);
  if (!entry) return fallback;
  const auto value = boolean_of(entry->values.front());
  if (!value) throw Error(refusal(*entry, key, "true or false"));
  return *value;
}

std::vector<std::string> Parameters::list(std::string_view key) const {
  const auto found = entries.find(std::string(key));
  return found == entries.end() ? std::vector<std::string>{} : found->second.values;
}

void Parameters::set(const std::string& key, std::vector<std::string> values) {
  Entry entry;
  entry.list = values.size() != 1;
  entry.values = std::move(values);
  entries.try_emplace(key, std::move(entry));
}

const Parameters::Entry* Parameters::declare(const std::string& key, ParameterType type, std::string fallback,
                                             ParameterNote note, void* cell) {
  Declared declared{key, type, std::move(note), fallback, fallback, cell};
  if (!declared.note.changeable) declared.cell = nullptr;
  declared_.push_back(std::move(declared));
  const auto found = entries.find(key);
  if (found == entries.end()) return nullptr;
  const bool many = type == ParameterType::numbers || type == ParameterType::texts;
  if (many || found->second.values.size() == 1) return &found->second;
  if (!found->second.values.empty()) refuse(found->second, key, name(type));
  return nullptr;
}

void Parameters::refuse(const Entry& entry, const std::string& key, const std::string& wanted) {
  problems_.add(refusal(entry, key, wanted));
}

bool Parameters::in_range(const Entry& entry, const Declared& declared, double value) {
  if (within(declared, value)) return true;
  refuse(entry, declared.key, range_text(declared.note));
  return false;
}

void Parameters::read(const std::string& key, bool& value, ParameterNote note) {
  const Entry* entry =
      declare(key, ParameterType::boolean, value ? "true" : "false", std::move(note), &value);
  if (!entry) return;
  if (const auto given = boolean_of(entry->values.front()))
    value = *given;
  else
    refuse(*entry, key, "true or false");
  declared_.back().value = value ? "true" : "false";
}

void Parameters::read(const std::string& key, int& value, ParameterNote note) {
  const Entry* entry = declare(key, ParameterType::integer, std::to_string(value), std::move(note), &value);
  if (!entry) return;
  const auto given = number_of(entry->values.front());
  if (!given || *given != std::floor(*given) || std::abs(*given) > 2e9)
    refuse(*entry, key, "a whole number");
  else if (in_range(*entry, declared_.back(), *given))
    value = static_cast<int>(*given);
  declared_.back().value = std::to_string(value);
}

void Parameters::read(const std::string& key, double& value, ParameterNote note) {
  const Entry* entry = declare(key, ParameterType::number, written(value), std::move(note), &value);
  if (!entry) return;
  const auto given = number_of(entry->values.front());
  if (!given)
    refuse(*entry, key, "a number");
  else if (in_range(*entry, declared_.back(), *given))
    value = *given;
  declared_.back().value = written(value);
}

void Parameters::read(const std::string& key, std::string& value, ParameterNote note) {
  const Entry* entry = declare(key, ParameterType::text, value, std::move(note), nullptr);
  if (!entry) return;
  const std::vector<std::string>& choices = declared_.back().note.choices;
  const std::string& given = entry->values.front();
  if (!choices.empty() && std::find(choices.begin(), choices.end(), given) == choices.end())
    refuse(*entry, key, "one of " + join(choices, ", ") + did_you_mean(given, choices));
  else
    value = given;
  declared_.back().value = value;
}

void Parameters::read(const std::string& key, std::vector<double>& value, ParameterNote note) {
  const Entry* entry = declare(key, ParameterType::numbers, written(value), std::move(note), nullptr);
  if (!entry) return;
  std::vector<double> out;
  for (const std::string& word : entry->values) {
    const auto given = number_of(word);
    if (!given) return refuse(*entry, key, "a list of numbers");
    out.push_back(*given);
  }
  value = std::move(out);
  declared_.back().value = written(value);
}

void Parameters::read(const std::string& key, std::vector<std::string>& value, ParameterNote note) {
  const Entry* entry = declare(key, ParameterType::texts, written(value), std::move(note), nullptr);
  if (!entry) return;
  const std::vector<std::string>& choices = declared_.back().note.choices;
  for (const std::string& word : entry->values)
    if (!choices.empty() && std::find(choices.begin(), choices.end(), word) == choices.end())
      return refuse(*entry, key, "a list out of " + join(choices, ", ") + did_you_mean(word, choices));
  value = entry->values;
  declared_.back().value = written(value);
}

void Parameters::superseded(const std::string& key, const char* instead) {
  const auto found = entries.find(key);
  if (found == entries.end()) return;
  problems_.warning("superseded-key", found->second.where, "'" + key + "' has no effect any more", instead);
  entries.erase(found);
}

void Parameters::begin() {
  declared_.clear();
  problems_ = {};
}

void Parameters::finish(const std::string& controller) {
  std::vector<std::string> known;
  for (const Declared& declared : declared_) known.push_back(declared.key);
  for (const auto& [key, entry] : entries) {
    if (is_common(key) || find_declared(key) || entry.where.file.empty()) continue;
    problems_.warning(
        "unknown-key", entry.where,
        "the controller '" + controller + "' has no parameter '" + key + "'" + did_you_mean(key, known),
        "it has no effect");
  }
}

const Declared* Parameters::find_declared(std::string_view key) const {
  for (const Declared& declared : declared_)
    if (declared.key == key) return &declared;
  return nullptr;
}

ParameterChange Parameters::change(const std::string& key, const std::string& value) const {
  const Declared* declared = find_declared(key);
  if (!declared) {
    std::vector<std::string> known;
    for (const Declared& d : declared_) known.push_back(d.key);
    throw Error("unknown-parameter", "there is no parameter '" + key + "'" + did_you_mean(key, known));
  }
  if (!declared->cell)
    throw Error("not-changeable", "'" + key + "' cannot be changed while the controller exists",
                "write it into the controllers file and load the controller again");
  const auto given = declared->type == ParameterType::boolean ? [&]() -> std::optional<double> {
    const auto flag = boolean_of(value);
    if (!flag) return std::nullopt;
    return *flag ? 1.0 : 0.0;
  }()
      : number_of(value);
  if (!given || (declared->type == ParameterType::integer && *given != std::floor(*given)))
    throw Error("bad-value", "'" + key + ": " + value + "' is not " + name(declared->type));
  if (!within(*declared, *given))
    throw Error("bad-value", "'" + key + ": " + value + "' is not " + range_text(declared->note));
  return {key, declared->type, declared->cell, *given};
}

void Parameters::note_changed(const ParameterChange& change) {
  for (Declared& declared : declared_)
    if (declared.key == change.key)
      declared.value = change.type == ParameterType::boolean ? (change.value != 0 ? "true" : "false")
                                                             : written(change.value);
}

void refuse_no_joints(Parameters& parameters) {
  const auto entry = parameters.entries.find("joints");
  const bool written = entry != parameters.entries.end();
  parameters.problems().error("missing-parameter", written ? entry->second.where : Location{},
                              written ? "'joints' names no joint" : "the controller has no joints",
                              "write joints: [NAME, …]");
}

}  // namespace polyarm::controllers
