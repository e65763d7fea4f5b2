#include "polyarm/server/events.hpp"

#include <filesystem>
#include <utility>

#include "polyarm/server/documents.hpp"

namespace polyarm::server {

namespace {

Text text_of(const Json& json) {
  return std::make_shared<const std::string>(dump(json));
}

Json place_json(const Location& where) {
  return {{"file", where.file}, {"line", where.line}, {"column", where.column}};
}

/// As the cell's folder has it.
std::string in_folder(const cell::Cell& cell, const std::string& file) {
  const auto inside = std::filesystem::path(file).lexically_relative(cell.file().folder);
  return inside.empty() || inside.string().starts_with("..") ? file : inside.generic_string();
}

Json program_json(const cell::Cell& cell, const cell::Task& task, bool begun = true) {
  const program::TaskStatus& status = task.status();
  return {{"file", in_folder(cell, task.interpreter().program().file)},
          {"state", program::name(task.interpreter().state())},
          {"line", status.where.line},
          {"where", place_json(status.where)},
          {"source", status.source},
          {"cycle", status.passes},
          {"paused", task.interpreter().paused()},
          {"begun", begun},
          {"ended", task.ended()},
          {"tasks", task.interpreter().status().size()},
          {"waits_for", status.waiting.text},
          {"problem", status.problem ? Json(status.problem->text()) : Json()}};
}

bool same_place(const hardware::PartState& a, const hardware::PartState& b) {
  return a.pose == b.pose && a.in_world == b.in_world && a.held_by == b.held_by;
}

}  // namespace

Json status_of(cell::Cell& cell, const Journal& journal) {
  const control::Snapshot& seen = cell.snapshot();
  const control::Supervisor& supervisor = cell.loop().supervisor();
  const bool running = seen.state == control::RunState::running;
  Json bases = Json::object(), jogged = Json::array();
  for (std::size_t i = 0; i < cell.robots().size(); ++i) {
    bases[cell.robots()[i]->entry.name] = pose_json(cell.robots()[i]->entry.base);
    if (cell.jogging().engaged(i)) jogged.push_back(cell.robots()[i]->entry.name);
  }
  return {{"event", "status"},
          {"cell", cell.file().name},
          {"state", control::name(seen.state)},
          {"cause", control::name(seen.cause)},
          {"held", running ? "" : control::name(seen.cause)},
          {"standing", seen.standing},
          {"armed", cell.arming().armed()},
          {"needs_arming", cell.arming().needed()},
          {"simulated", !cell.arming().needed()},
          {"profile", cell.profile()},
          {"reduced", cell.arming().reduced()},
          {"override", 100 * supervisor.override_share()},
          {"allowed", 100 * supervisor.share()},
          {"control", cell.control_holder()},
          {"jogged", jogged},
          {"program", cell.program() ? program_json(cell, *cell.program(), cell.program_begun()) : Json()},
          {"plc", cell.plc() ? program_json(cell, *cell.plc()) : Json()},
          {"failure", cell.failure() ? Json(cell.failure()->problem.text()) : Json()},
          {"alarms", journal.last_alarm()},
          {"bases", bases}};
}

Json TagEvents::value_of(const std::string& name) const {
  const data::Value& value = *cell_.store().find(name);
  const auto facts = cell_.store().facts(name);
  const auto link = cell_.links().source_of(name);
  Json out{{"text", value.text()},
           {"quality", link ? link->quality : "good"},
           {"forced", facts->forced},
           {"by", facts->changed_by},
           {"since", facts->changed_at >= 0 ? Json(seconds(facts->changed_at)) : Json()}};
  if (const bool* flag = value.as_boolean())
    out["value"] = *flag;
  else if (const data::Number* number = value.as_number())
    out["value"] = number->value;
  else
    out["value"] = value.text();
  return out;
}

Text TagEvents::changes(bool look) {
  const std::uint64_t version = cell_.store().version(), groups = cell_.store().groups_version();
  places_ = std::exchange(groups_version_, groups) != groups || places_;
  if (version == version_ && !look) return nullptr;
  std::vector<std::string> names;
  const auto changed = cell_.store().changes_since(version_);
  for (const data::Change& change : changed)
    places_ = places_ || (change.now && change.now->is_place()) || (change.old && change.old->is_place());
  if (look || version_ == ~0ull || changed.size() >= data::DataStore::kChangesKept) {
    names = cell_.store().names();
  } else {
    for (const data::Change& change : changed) names.push_back(change.name);
  }
  version_ = version;
  Json values = Json::object();
  for (const std::string& name : names) {
    const data::Value* value = cell_.store().find(name);
    if (value && value->is_place()) continue;
    Json now = value ? value_of(name) : Json();
    Json& told = told_[name];
    if (told == now) continue;
    told = now;
    values[name] = std::move(now);
  }
  if (values.empty()) return nullptr;
  return text_of({{"event", "tags"}, {"values", values}, {"full", false}});
}

Text TagEvents::full() {
  Json values = Json::object();
  for (const std::string& name : cell_.store().names())
    if (!cell_.store().find(name)->is_place()) values[name] = value_of(name);
  return text_of({{"event", "tags"}, {"values", values}, {"full", true}});
}

Text PartEvents::tell(bool full) {
  const auto& parts = cell_.snapshot().world.parts;
  told_.resize(parts.size());
  Json list = Json::array();
  for (std::size_t i = 0; i < parts.size() && i < cell_.scene().parts.size(); ++i) {
    if (!full && same_place(parts[i], told_[i])) continue;
    Json each = pose_json(parts[i].pose);
    each["name"] = cell_.scene().parts[i].name;
    each["in_world"] = parts[i].in_world;
    each["held_by"] = parts[i].held_by >= 0
                          ? Json(cell_.robots()[static_cast<std::size_t>(parts[i].held_by)]->entry.name)
                          : Json();
    list.push_back(std::move(each));
    if (!full) told_[i] = parts[i];
  }
  if (list.empty()) return nullptr;
  return text_of({{"event", "parts"}, {"parts", list}, {"full", full}});
}

Text PartEvents::changes() {
  return tell(false);
}
Text PartEvents::full() {
  return tell(true);
}

Text log_event(const Journal& journal, std::uint64_t after) {
  Json lines = Json::array();
  for (const Journal::Line& line : journal.lines())
    if (line.number > after)
      lines.push_back(
          {{"number", line.number}, {"time", line.time}, {"level", line.level}, {"text", line.text}});
  if (lines.empty()) return nullptr;
  return text_of({{"event", "log"}, {"lines", lines}});
}

Text alarm_event(const Journal::Alarm& alarm) {
  const Problem& p = alarm.problem;
  return text_of({{"event", "alarm"},
                  {"number", alarm.number},
                  {"time", alarm.time},
                  {"code", p.code},
                  {"what", p.what},
                  {"where", place_json(p.where)},
                  {"advice", p.advice},
                  {"severity", p.severity == Severity::error ? "error" : "warning"}});
}

}  // namespace polyarm::server
