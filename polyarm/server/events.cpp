#include "polyarm/server/events.hpp"

#include <algorithm>
#include <cmath>
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

/// Rounded to 0.1 mm and about 0.1 deg, so noise of a base at rest is not reported as a change.
protocol::BasePose rounded(const Pose& pose) {
  const auto to = [](double value, double steps) { return std::round(value * steps) / steps + 0.0; };
  const Vec3& p = pose.position;
  const Quaternion& q = pose.rotation;
  return {{to(p.x, 1e4), to(p.y, 1e4), to(p.z, 1e4)}, {to(q.x, 1e3), to(q.y, 1e3), to(q.z, 1e3), to(q.w, 1e3)}};
}

bool same_place(const hardware::PartState& a, const hardware::PartState& b) {
  return a.pose == b.pose && a.in_world == b.in_world && a.held_by == b.held_by;
}

/// If the robot can be moved but no active controller commands its joints: the inactive controller that
/// could. Else empty.
std::string idle_mover(cell::CellView& cell, std::size_t robot) {
  if (!cell.motion(robot)) return {};
  const auto& joints = cell.robots()[robot]->joints;
  for (const controllers::JointFacts& joint : joints)
    for (const char* what : {"/position", "/velocity", "/effort"})
      if (!cell.controllers().holder_of(joint.name + what).empty()) return {};
  for (const control::ListedController& each : cell.controllers().list())
    for (const std::string& command : each.required_commands)
      if (each.state == hardware::LifecycleState::inactive && command.starts_with(joints.front().name + "/"))
        return each.name;
  return {};
}

}  // namespace

protocol::CellStatus status_of(cell::CellView& cell, const Journal& journal) {
  const control::Snapshot& seen = cell.snapshot();
  const control::Supervisor& supervisor = cell.supervisor();
  protocol::CellStatus out;
  out.cell = cell.file().name;
  out.state = control::name(seen.state);
  const Problem cause = cell.stop_cause();
  out.cause = cause.what;
  out.cause_code = cause.code;
  out.cause_facts = protocol::fact_values(cause.facts);
  if (seen.state != control::RunState::running) out.held = out.cause;
  out.can = cell.possible_now();
  out.contacts = cell.contacts();
  out.standing = seen.standing;
  out.motion_left = cell.motion_left();
  out.armed = cell.arming().armed();
  out.needs_arming = cell.arming().needed();
  out.simulated = !out.needs_arming;
  out.profile = cell.profile();
  out.reduced = cell.arming().reduced();
  out.override_ = 100 * supervisor.override_share();
  out.allowed = 100 * supervisor.share();
  out.control = cell.control_holder();
  out.program = cell.program_overview();
  out.plc = cell.plc_overview();
  if (cell.failure()) out.failure = cell.failure()->problem.text();
  out.alarms = journal.last_alarm();
  const hardware::Hardware& hardware = cell.hardware();
  for (std::size_t i = 0; i < hardware.size(); ++i)
    if (hardware.takes_commands(i) && hardware.state_of(i) != hardware::LifecycleState::active)
      out.inactive.push_back(hardware.component_name(i));
  for (std::size_t i = 0; i < cell.robots().size(); ++i) {
    const std::string& robot = cell.robots()[i]->entry.name;
    if (const std::string mover = idle_mover(cell, i); !mover.empty()) out.inactive.push_back(mover);
    if (cell.jogged(i)) out.jogged.push_back(robot);
    out.bases[robot] = rounded(cell.base(i).pose(seen));
  }
  return out;
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
    Json& told = announced_[name];
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
  announced_.resize(parts.size());
  Json list = Json::array();
  for (std::size_t i = 0; i < parts.size() && i < cell_.scene().parts.size(); ++i) {
    if (!full && same_place(parts[i], announced_[i])) continue;
    Json each = pose_json(parts[i].pose);
    each["name"] = cell_.scene().parts[i].name;
    each["in_world"] = parts[i].in_world;
    each["taken"] = parts[i].entered && !parts[i].in_world;
    each["held_by"] = parts[i].held_by >= 0
                          ? Json(cell_.robots()[static_cast<std::size_t>(parts[i].held_by)]->entry.name)
                          : Json();
    list.push_back(std::move(each));
    if (!full) announced_[i] = parts[i];
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

namespace {

int samples_of(const timing::TimedPath& path) {
  constexpr double kEvery = 0.02;
  constexpr int kLeast = 20, kMost = 200;
  return std::clamp(static_cast<int>(path.duration() / kEvery), kLeast, kMost);
}

/// Samples of the TCP along the path, rounded to 0.1 mm.
Json path_of(const moves::RobotMotion::UnderWay& way) {
  const timing::TimedPath& path = way.motion->path;
  const int samples = samples_of(path);
  Json out = Json::array();
  std::vector<double> q(path.joints());
  std::size_t hint = 0;
  for (int k = 0; k <= samples; ++k) {
    path.sample(path.duration() * k / samples, q, {}, {}, {}, hint);
    const Vec3 at = way.robot->chain.forward(q).position;
    Json place = Json::array();
    for (const double x : {at.x, at.y, at.z}) place.push_back(std::round(x * 1e4) / 1e4);
    out.push_back(std::move(place));
  }
  return out;
}

Json joints_at(const moves::RobotMotion::UnderWay& way, double time) {
  std::vector<double> q(way.motion->path.joints());
  std::size_t hint = 0;
  way.motion->path.sample(time, q, {}, {}, {}, hint);
  Json out = Json::object();
  for (std::size_t j = 0; j < q.size(); ++j) out[way.robot->chain.names()[j]] = std::round(q[j] * 1e5) / 1e5;
  return out;
}

}  // namespace

void PlanEvents::look(std::size_t robot, Way& way) const {
  const moves::RobotMotion* motion = cell_.motion(robot);
  const auto now = motion ? motion->under_way() : std::nullopt;
  if (!now) {
    way = {};
    return;
  }
  const std::vector<double>& ends = now->motion->ends;
  const auto next = std::upper_bound(ends.begin(), ends.end(), now->time);
  const auto move = static_cast<std::size_t>(next - ends.begin());
  if (now->goal == way.goal && move == way.move) return;
  if (now->goal != way.goal) {
    way.told = {{"path", path_of(*now)}};
    way.places = way.told["path"].size();
    way.clear.clear();
  }
  way.goal = now->goal;
  way.move = move;
  const double end = next == ends.end() ? now->motion->path.duration() : *next;
  way.told["target"] = {{"joints", joints_at(*now, end)}};
}

bool PlanEvents::measure(std::size_t robot, Way& way) const {
  constexpr std::size_t kAtOnce = 8;
  if (way.goal == 0 || way.clear.size() >= way.places) return false;
  const moves::RobotMotion* motion = cell_.motion(robot);
  const auto now = motion ? motion->under_way() : std::nullopt;
  if (!now || now->goal != way.goal) return false;
  const timing::TimedPath& path = now->motion->path;
  std::vector<double> q(path.joints());
  for (std::size_t i = 0; i < kAtOnce && way.clear.size() < way.places; ++i) {
    std::size_t hint = 0;
    path.sample(path.duration() * static_cast<double>(way.clear.size()) / static_cast<double>(way.places - 1),
                q, {}, {}, {}, hint);
    const std::optional<double> clear = cell_.clearance_at(robot, q);
    if (!clear) return false;
    way.clear.push_back(std::round(*clear * 1e4) / 1e4);
  }
  if (way.clear.size() < way.places) return false;
  way.told["clear"] = way.clear;
  return true;
}

Text PlanEvents::tell() const {
  Json plans = Json::object();
  for (std::size_t i = 0; i < ways_.size(); ++i)
    if (ways_[i].goal != 0) plans[cell_.robots()[i]->entry.name] = ways_[i].told;
  return text_of({{"event", "plan"}, {"plans", plans}});
}

Text PlanEvents::changes() {
  ways_.resize(cell_.robots().size());
  bool news = false;
  for (std::size_t i = 0; i < ways_.size(); ++i) {
    const std::pair before(ways_[i].goal, ways_[i].move);
    look(i, ways_[i]);
    news = measure(i, ways_[i]) || news || before != std::pair(ways_[i].goal, ways_[i].move);
  }
  return news ? tell() : nullptr;
}

Text PlanEvents::full() {
  const bool any = std::any_of(ways_.begin(), ways_.end(), [](const Way& way) { return way.goal != 0; });
  return any ? tell() : nullptr;
}

Text NearEvents::changes() {
  const auto rounded = [](double v) { return std::round(v * 1e4) / 1e4; };
  const auto place = [&](const Vec3& p) { return Json{rounded(p.x), rounded(p.y), rounded(p.z)}; };
  Json robots = Json::object();
  for (std::size_t i = 0; i < cell_.robots().size(); ++i) {
    const auto near = cell_.near(i);
    if (!near) continue;
    robots[cell_.robots()[i]->entry.name] = {{"a", near->mine},
                                             {"b", near->other},
                                             {"distance", rounded(near->distance)},
                                             {"kept", near->kept > 0 ? Json(rounded(near->kept)) : Json()},
                                             {"on_a", place(near->on_mine)},
                                             {"on_b", place(near->on_other)},
                                             {"pace", std::round(cell_.pace(i) * 100) / 100}};
  }
  Json event{{"event", "near"}, {"robots", robots}};
  std::string text = dump(event);  // names of bodies may have any bytes
  if (text == told_ || (told_.empty() && robots.empty())) return nullptr;
  told_ = std::move(text);
  return full();
}

void ProgramEvents::watch() {
  announced_->on = true;
  cell_.requests().ask(protocol::ProgramWatch{}, [watch = std::weak_ptr(announced_)](const protocol::Reply& reply) {
    const auto to = watch.lock();
    if (!to) return false;
    to->on = reply.answer.has_value();
    if (!to->on) return false;
    Json event = reply.answer->any().json();
    event["event"] = "program";
    to->text = text_of(event);
    return to->fresh = true;
  });
}

Text ProgramEvents::changes(double now) {
  constexpr double kAgain = 1;
  if (!announced_->on && cell_.program() && now - asked_ >= kAgain) {
    asked_ = now;
    watch();
  }
  return std::exchange(announced_->fresh, false) ? announced_->text : nullptr;
}

Text log_event(const Journal& journal, std::uint64_t after) {
  Json lines = Json::array();
  for (const Journal::Line& line : journal.lines())
    if (line.number > after)
      lines.push_back({{"number", line.number},
                       {"time", line.time},
                       {"level", line.level},
                       {"text", line.text},
                       {"code", line.code},
                       {"facts", protocol::any_of(protocol::fact_values(line.facts)).json()}});
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
                  {"facts", protocol::any_of(protocol::fact_values(p.facts)).json()},
                  {"severity", p.severity == Severity::error ? "error" : "warning"}});
}

bool is_due(double& last, double every, double now) {
  if (now - last < every) return false;
  last = now;
  return true;
}

CellEvents::CellEvents(cell::CellView& cell)
    : tags_(cell), parts_(cell), plans_(cell), near_(cell), program_(cell) {}

void CellEvents::report(double now, const Broadcast& broadcast) {
  constexpr double kTagsEvery = 0.1, kLookEvery = 1, kPartsEvery = 1.0 / 30, kPlansEvery = 0.05,
                   kNearEvery = 0.1, kPointsEvery = 0.2;
  if (is_due(sent_tags_, kTagsEvery, now))
    broadcast(Kind::tags, tags_.changes(is_due(looked_, kLookEvery, now)), [this] { return tags_.full(); });
  if (tags_.places_changed() && is_due(sent_points_, kPointsEvery, now)) {
    tags_.take_places_changed();
    broadcast(Kind::points, std::make_shared<const std::string>(R"({"event":"points"})"), {});
  }
  if (is_due(sent_parts_, kPartsEvery, now))
    broadcast(Kind::parts, parts_.changes(), [this] { return parts_.full(); });
  if (is_due(sent_plans_, kPlansEvery, now)) broadcast(Kind::plan, plans_.changes(), {});
  if (is_due(sent_near_, kNearEvery, now)) broadcast(Kind::near, near_.changes(), {});
  broadcast(Kind::program, program_.changes(now), {});
}

void CellEvents::greet(const std::function<void(Kind, const Text&)>& put) {
  put(Kind::tags, tags_.full());
  put(Kind::parts, parts_.full());
  put(Kind::plan, plans_.full());
  put(Kind::near, near_.full());
  put(Kind::program, program_.full());
}

}  // namespace polyarm::server
