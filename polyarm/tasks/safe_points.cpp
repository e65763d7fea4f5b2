#include "polyarm/tasks/safe_points.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "polyarm/base/file.hpp"

namespace polyarm::cell {

namespace {

using Json = nlohmann::json;
using data::Value;
using program::SavedSlot;
using program::SavedTask;

/// Minimum interval when only the line has changed, ns.
constexpr Nanoseconds kBetween = 250'000'000;

Json from_pose(const Pose& p) {
  return {p.position.x, p.position.y, p.position.z, p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w};
}
Pose to_pose(const Json& j) {
  return {{j.at(0), j.at(1), j.at(2)}, {j.at(3), j.at(4), j.at(5), j.at(6)}};
}

Json from_number(const data::Number& n) {
  return {n.value, static_cast<int>(n.dimension)};
}
Dimension to_dimension(const Json& j) {
  const int dimension = j;
  if (dimension < 0 || dimension > static_cast<int>(Dimension::angular_acceleration))
    throw Error("bad-state", "a number of an unknown dimension");
  return static_cast<Dimension>(dimension);
}
data::Number to_number(const Json& j) {
  return {j.at(0).get<double>(), to_dimension(j.at(1))};
}

Json from_joints(const data::JointState& joints) {
  Json out{{"joints", joints.names}, {"positions", joints.positions}};
  for (const Dimension unit : joints.given) out["given"].push_back(static_cast<int>(unit));
  return out;
}
data::JointState to_joints(const Json& j) {
  data::JointState out{j["joints"].get<std::vector<std::string>>(),
                       j.at("positions").get<std::vector<double>>()};
  if (const auto given = j.find("given"); given != j.end())
    for (std::size_t i = 0; i < given->size() && i < out.positions.size(); ++i)
      out.note_given(i, to_dimension(given->at(i)));
  return out;
}

Json from_value(const Value& value) {
  const auto all = [](const data::List& list) {
    Json out = Json::array();
    for (const Value& each : list) out.push_back(from_value(each));
    return out;
  };
  if (const bool* truth = value.as_boolean()) return {{"boolean", *truth}};
  if (const auto* number = value.as_number()) return {{"number", from_number(*number)}};
  if (const auto* text = value.as_text()) return {{"text", *text}};
  if (const auto* list = value.as_list()) return {{"list", all(*list)}};
  if (const auto* joints = value.as_joints()) return from_joints(*joints);
  if (const auto* point = value.as_point()) {
    Json out{{"pose", from_pose(point->pose)}, {"quaternion", point->quaternion_given}};
    if (const data::Taught* t = point->taught.get())
      out["taught"] = {
          t->frame, t->tool, t->robot, t->joints.names, t->joints.positions, from_pose({{}, t->axes})};
    return out;
  }
  const data::Record& record = *value.as_record();
  return {{"record", record.names}, {"values", all(record.values)}};
}

Value to_value(const Json& j) {
  const auto all = [](const Json& list) {
    data::List out;
    for (const Json& each : list) out.push_back(to_value(each));
    return out;
  };
  if (j.contains("boolean")) return j["boolean"].get<bool>();
  if (j.contains("number")) return to_number(j["number"]);
  if (j.contains("text")) return j["text"].get<std::string>();
  if (j.contains("list")) return all(j["list"]);
  if (j.contains("joints")) return to_joints(j);
  if (j.contains("pose")) {
    data::Point out{to_pose(j["pose"]), j.at("quaternion").get<bool>()};
    if (const auto t = j.find("taught"); t != j.end())
      out.taught = std::make_shared<data::Taught>(
          data::Taught{t->at(0),
                       t->at(1),
                       t->at(2),
                       {t->at(3).get<std::vector<std::string>>(), t->at(4).get<std::vector<double>>()},
                       t->size() > 5 ? to_pose(t->at(5)).rotation : Quaternion{}});
    return out;
  }
  data::Record record{j.at("record").get<std::vector<std::string>>(), all(j.at("values"))};
  if (record.names.size() != record.values.size())
    throw Error("bad-state", "a record with other names than values");
  return record;
}

Json from_slots(const std::vector<SavedSlot>& slots) {
  Json out = Json::array();
  for (const SavedSlot& slot : slots) {
    Json one = slot.set ? from_value(slot.value) : Json::object();
    if (!slot.origin.empty()) one["origin"] = slot.origin;
    out.push_back(std::move(one));
  }
  return out;
}

std::vector<SavedSlot> to_slots(const Json& j) {
  std::vector<SavedSlot> out;
  for (const Json& one : j) {
    SavedSlot slot;
    slot.origin = one.value("origin", "");
    slot.set = one.size() > (slot.origin.empty() ? 0u : 1u);
    if (slot.set) slot.value = to_value(one);
    out.push_back(std::move(slot));
  }
  return out;
}

Json from_uses(const program::MoveDefaults& use) {
  Json out{{"robot", use.robot}, {"tool", use.tool}, {"frame", use.frame}, {"exact", use.exact}};
  const auto some = [&](const char* name, const std::optional<data::Number>& value) {
    if (value) out[name] = from_number(*value);
  };
  some("speed", use.speed), some("accel", use.accel), some("blend", use.blend), some("payload", use.payload);
  if (use.around) out["around"] = *use.around;
  if (use.frame_pose) out["pose"] = from_pose(*use.frame_pose);
  if (!use.pose_in.empty()) out["pose_in"] = use.pose_in;
  return out;
}

program::MoveDefaults to_uses(const Json& j) {
  program::MoveDefaults out;
  out.robot = j.at("robot"), out.tool = j.at("tool"), out.frame = j.at("frame"), out.exact = j.at("exact");
  const auto some = [&](const char* name, std::optional<data::Number>& value) {
    if (j.contains(name)) value = to_number(j[name]);
  };
  some("speed", out.speed), some("accel", out.accel), some("blend", out.blend), some("payload", out.payload);
  if (j.contains("around")) out.around = j["around"].get<bool>();
  if (j.contains("pose")) out.frame_pose = to_pose(j["pose"]);
  if (j.contains("pose_in")) out.pose_in = j["pose_in"].get<std::string>();
  return out;
}

Json from_task(const SavedTask& t) {
  Json frames = Json::array(), handlers = Json::array(), uses = Json::array();
  for (const auto& f : t.frames) frames.push_back({f.return_to, f.base, f.uses, f.locks, f.handlers});
  for (const auto& h : t.handlers) handlers.push_back({h.step, h.stack, h.frames, h.uses, h.locks});
  for (const auto& use : t.uses) uses.push_back(from_uses(use));
  Json out{{"id", t.id},
           {"name", t.name},
           {"shown", t.shown},
           {"apart", t.apart},
           {"met", t.met},
           {"was_true", t.was_true},
           {"state", static_cast<int>(t.state)},
           {"step", t.step},
           {"stack", from_slots(t.stack)},
           {"frames", frames},
           {"uses", uses},
           {"locks", t.locks},
           {"handlers", handlers},
           {"waits", static_cast<int>(t.waits)},
           {"waits_at", t.waits_at},
           {"passes", t.passes}};
  if (t.waits_for) out["waits_for"] = *t.waits_for;
  if (t.deadline) out["deadline"] = *t.deadline;
  if (t.trap >= 0) out["trap"] = {t.trap, t.owner, t.sprung};
  if (t.next_due) out["next_due"] = *t.next_due;
  out["commanded"] = t.commanded;
  return out;
}

SavedTask to_task(const Json& j) {
  SavedTask t;
  t.id = j.at("id"), t.name = j.at("name"), t.shown = j.at("shown"), t.apart = j.at("apart");
  t.met = j.at("met"), t.was_true = j.at("was_true"), t.step = j.at("step");
  t.state = static_cast<program::TaskState>(j.at("state").get<int>());
  t.stack = to_slots(j.at("stack"));
  for (const Json& f : j.at("frames")) t.frames.push_back({f.at(0), f.at(1), f.at(2), f.at(3), f.at(4)});
  for (const Json& h : j.at("handlers")) t.handlers.push_back({h.at(0), h.at(1), h.at(2), h.at(3), h.at(4)});
  for (const Json& use : j.at("uses")) t.uses.push_back(to_uses(use));
  t.locks = j.at("locks").get<std::vector<std::string>>();
  t.waits = static_cast<program::WaitKind>(j.at("waits").get<int>());
  t.waits_at = j.at("waits_at"), t.passes = j.at("passes");
  if (j.contains("waits_for")) t.waits_for = j["waits_for"].get<Nanoseconds>();
  if (j.contains("deadline")) t.deadline = j["deadline"].get<Nanoseconds>();
  if (j.contains("trap")) t.trap = j["trap"].at(0), t.owner = j["trap"].at(1), t.sprung = j["trap"].at(2);
  if (j.contains("next_due")) t.next_due = j["next_due"].get<Nanoseconds>();
  t.commanded = j.at("commanded").get<std::vector<std::string>>();
  return t;
}

Json from_state(const program::SavedState& state) {
  Json tasks = Json::array();
  for (const SavedTask& task : state.tasks) tasks.push_back(from_task(task));
  return {{"program", state.program},   {"tasks", tasks},
          {"meetings", state.meetings}, {"globals", from_slots(state.globals)},
          {"locks", state.locks},       {"last_id", state.last_id},
          {"groups", state.groups},     {"random", state.random},
          {"clock", state.clock}};
}

program::SavedState to_state(const Json& j) {
  program::SavedState out;
  out.program = j.at("program");
  for (const Json& task : j.at("tasks")) out.tasks.push_back(to_task(task));
  out.globals = to_slots(j.at("globals"));
  out.meetings = j.at("meetings").get<std::map<std::string, std::vector<std::uint64_t>>>();
  out.locks = j.at("locks").get<std::map<std::string, std::uint64_t>>();
  out.last_id = j.at("last_id"), out.groups = j.at("groups");
  out.random = j.at("random"), out.clock = j.at("clock");
  return out;
}

using Named = std::vector<std::pair<std::string, Value>>;
Json from_named(const Named& values) {
  Json out = Json::array();
  for (const auto& [name, value] : values) out.push_back({name, from_value(value)});
  return out;
}
Named to_named(const Json& j) {
  Named out;
  for (const Json& pair : j) out.emplace_back(pair.at(0).get<std::string>(), to_value(pair.at(1)));
  return out;
}

}  // namespace

std::string to_json(const SafePoint& point) {
  Json out{{"polyarm", "safe-point/3"},    {"file", point.program},
           {"line", point.line},           {"state", from_state(point.state)},
           {"plc_ended", point.plc_ended}, {"tags", from_named(point.tags)},
           {"held", point.held},           {"values", from_named(point.values)}};
  if (point.plc) out["plc"] = from_state(*point.plc);
  return out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

SafePoint safe_point_from_json(const std::string& text, const std::string& file) {
  try {
    const Json j = Json::parse(text);
    if (j.at("polyarm") != "safe-point/3") throw Error("bad-state", "another version");
    SafePoint out;
    out.program = j.at("file"), out.line = j.at("line");
    out.state = to_state(j.at("state"));
    if (j.contains("plc")) out.plc = to_state(j["plc"]);
    out.plc_ended = j.at("plc_ended");
    out.tags = to_named(j.at("tags"));
    out.values = to_named(j.at("values"));
    out.held = j.value("held", std::vector<std::string>{});
    return out;
  } catch (const std::exception& e) {
    throw Error(Problem{"bad-state",
                        {file},
                        std::string("the stored state of the program is damaged: ") + e.what(),
                        "begin at a line: --from LINE"});
  }
}

namespace {
SafePoint taken(const Task& task, const Task* plc, const data::DataStore& store) {
  SafePoint out;
  out.program = task.interpreter().program().file;
  out.line = task.status().where.text() + ": " + task.status().source;
  out.state = task.interpreter().save();
  if (plc) out.plc_ended = plc->ended();
  if (plc && plc->interpreter().safe()) out.plc = plc->interpreter().save();
  for (const std::string& name : store.names()) {
    const auto role = store.tag_role(name);
    if (role && *role != data::TagRole::state) out.tags.emplace_back(name, *store.find(name));
    if (!role && !store.set_of(name).empty()) out.values.emplace_back(name, *store.find(name));
  }
  return out;
}
}  // namespace

void SafePoints::tick(Nanoseconds now, const Task& task, const Task* plc, const data::DataStore& store,
                      bool may_take) {
  const program::Interpreter& interpreter = task.interpreter();
  if (may_take && !task.ended() && interpreter.safe()) {
    const program::Place at = interpreter.position(),
                         plc_at = plc ? plc->interpreter().position() : program::Place{};
    const auto differ = [](const program::Place& a, const program::Place& b) {
      return a.line != b.line || a.file != b.file;
    };
    const bool data = store.version() != seen_version_;
    const bool moved_on = differ(at, seen_at_) || differ(plc_at, plc_seen_at_);
    if (data || (moved_on && now - taken_ >= kBetween) || taken_ < 0) {
      seen_version_ = store.version(), seen_at_ = at, plc_seen_at_ = plc_at, taken_ = now;
      auto point = std::make_shared<SafePoint>(taken(task, plc, store));
      point->held = held_;
      last_ = std::move(point);
      pending_ = true;
    }
  }
  post_when_free();
}

void SafePoints::set_held(std::vector<std::string> held) {
  held_ = std::move(held);
  if (!last_) return;
  auto point = std::make_shared<SafePoint>(*last_);
  point->held = held_;
  last_ = std::move(point);
  pending_ = true;
  post_when_free();
}

void SafePoints::post() {
  busy_->store(true);
  pending_ = false;
  worker_.post([point = last_, file = file_, busy = busy_] {
    try {
      std::filesystem::create_directories(file.parent_path());
      write_file_atomically(file, to_json(*point));
    } catch (const std::exception&) {  // the data files report disk errors
    }
    busy->store(false);
  });
}

void SafePoints::finish(const Task& task) {
  if (task.status().state == program::TaskState::finished) {
    worker_.drain();
    std::error_code error;
    std::filesystem::remove(file_, error);
  } else if (pending_) {
    post();
  }
  worker_.drain();
}

SafePoint SafePoints::read(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    throw Error("no-state", "no program was interrupted here: there is no " + file.string(),
                "run it from its beginning, or --from LINE");
  return safe_point_from_json(read_file(file), file.string());
}

}  // namespace polyarm::cell
