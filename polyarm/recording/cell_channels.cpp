#include "polyarm/recording/cell_channels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/data/data_store.hpp"
#include "polyarm/description/plain_urdf.hpp"
#include "polyarm/messages/json.hpp"

namespace polyarm::recording {

namespace {

using Json = nlohmann::json;
namespace ros = messages;
constexpr Nanoseconds kStep = 1000;  // the old value is sent again this long before a step, ns
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

constexpr const char* kLoopSchema = R"({"type":"object","title":"polyarm.Loop","properties":{
"state":{"type":"string","description":"running, stopping, held, fault or backing"},
"cause":{"type":"string","description":"of a stop; empty: none"},
"standing":{"type":"boolean"},
"cycle":{"type":"integer"},
"late":{"type":"integer","description":"cycles that were late so far"},
"latency_us":{"type":"number","description":"how late this cycle woke up; not in lock-step"},
"cost_us":{"type":"number","description":"of the cycle before; live: median so far; not in lock-step"}}})";
constexpr const char* kLineSchema = R"({"type":"object","title":"polyarm.ProgramLine","properties":{
"task":{"type":"string"},"file":{"type":"string"},"line":{"type":"integer"},"source":{"type":"string"}}})";

/// A name that is valid in a ROS topic: letters, digits and underscores, not beginning with a digit.
std::string topic_part(const std::string& name) {
  std::string out;
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) ? c : c == '/' ? '/' : '_';
  if (out.empty() || std::isdigit(static_cast<unsigned char>(out[0]))) out.insert(0, 1, '_');
  return out;
}

double value(std::span<const double> values, int index) {
  const auto at = static_cast<std::size_t>(index);
  return index >= 0 && at < values.size() ? values[at] : kNoNumber;
}

std::string robot_topic(const cell::CellRobots& robots, const cell::CellRobot& robot, const char* topic) {
  return robots.size() == 1 ? std::string("/") + topic : "/" + topic_part(robot.entry.name) + "/" + topic;
}

std::vector<bool> drives(const cell::CellView& cell) {
  std::vector<bool> out;
  for (std::size_t i = 0; i < cell.robots().size(); ++i) out.push_back(cell.base(i).moves());
  return out;
}

}  // namespace

template <class Message>
std::size_t CellChannels::add(std::string topic, const char* about, bool latched) {
  const ros::TypeInfo& type = ros::type_info<Message>();
  list_.push_back({std::move(topic), "cdr", type.name, "ros2msg", type.schema, about, latched});
  return list_.size() - 1;
}

std::size_t CellChannels::add_json(std::string topic, const char* name, const char* schema,
                                   const char* about) {
  list_.push_back({std::move(topic), "json", name, "jsonschema", schema, about, false});
  return list_.size() - 1;
}

CellChannels::CellChannels(cell::CellView& cell, std::int64_t offset)
    : cell_(cell), offset_(offset), state_(cell.robots(), cell.table(), drives(cell)) {
  joints_ = add<ros::sensor_msgs::msg::JointState>("/joint_states", "every joint that is measured");
  add_commands();
  moving_ = add<ros::tf2_msgs::msg::TFMessage>(
      "/tf", "the frames that move, those of parts (`part/NAME`) among them");
  fixed_ = add<ros::tf2_msgs::msg::TFMessage>("/tf_static", "the frames that never move", true);
  add_descriptions();
  add_interfaces();
  loop_ = add_json("/loop", "polyarm.Loop", kLoopSchema, "the control loop: state, lateness and cost");
  line_ = add_json("/program", "polyarm.ProgramLine", kLineSchema, "the line that a task has reached");
  log_ = add<ros::rcl_interfaces::msg::Log>("/rosout", "log of the cell and its programs");
  health_ =
      add<ros::diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", "the control loop, once a second");
  add_tags();
}

void CellChannels::add_descriptions() {
  const cell::CellRobots& robots = cell_.robots();
  for (const auto& robot : robots) {
    descriptions_.push_back(add<ros::std_msgs::msg::String>(robot_topic(robots, *robot, "robot_description"),
                                                            "the robot as URDF", true));
    tcps_.push_back(add<ros::geometry_msgs::msg::PoseStamped>(
        robot_topic(robots, *robot, "tcp"),
        "the tool centre point in the world (of a base that drives: in its root link), measured"));
    const std::size_t i = tcp_frames_.size();
    tcp_frames_.emplace_back();
    if (cell_.base(i).moves())
      tcp_frames_.back() = {frame_of(*robot, robot->model.root, robots.size() > 1), robot->entry.base};
    auto& states = tcp_states_.emplace_back();
    for (const controllers::JointFacts& joint : robot->joints) {
      const auto index = cell_.table().find_state(joint.name + "/position");
      states.push_back(index ? static_cast<int>(*index) : -1);
    }
  }
}

void CellChannels::add_commands() {
  commanded_ = add<ros::sensor_msgs::msg::JointState>("/joint_commands", "the commands of those joints");
  const cell::CellRobots& robots = cell_.robots();
  bool velocity = false, effort = false;
  for (const auto& robot : robots)
    for (const controllers::JointFacts& joint : robot->joints) {
      const auto find = [&](const char* what) {
        const auto index = cell_.table().find_command(joint.name + "/" + what);
        return index ? static_cast<int>(*index) : -1;
      };
      commands_of_.push_back({find("position"), find("velocity"), find("effort")});
      velocity = velocity || commands_of_.back().velocity >= 0;
      effort = effort || commands_of_.back().effort >= 0;
      const std::size_t own = robots.size() == 1 ? robot->entry.name.size() + 1 : 0;
      commands_.name.push_back(joint.name.substr(own));
    }
  commands_.position.resize(commands_of_.size());
  if (velocity) commands_.velocity.resize(commands_of_.size());
  if (effort) commands_.effort.resize(commands_of_.size());
}

/// Groups interfaces by owner: "arm/elbow_joint" has "position" and "velocity".
void CellChannels::add_interfaces() {
  interfaces_ = add<ros::control_msgs::msg::DynamicJointState>("/dynamic_joint_states",
                                                               "every state interface, tools and boards too");
  const hardware::InterfaceTable& table = cell_.table();
  const std::string own = cell_.robots().size() == 1 ? cell_.robots()[0]->entry.name + "/" : "";
  std::map<std::string, std::size_t> owners;
  for (std::size_t i = 0; i < table.built_states(); ++i) {
    std::string name = table.state_names()[i];
    if (!own.empty() && name.starts_with(own)) name.erase(0, own.size());
    const std::size_t slash = name.rfind('/');
    const std::string owner = slash == std::string::npos ? "" : name.substr(0, slash);
    const auto [at, is_new] = owners.emplace(owner, dynamic_.joint_names.size());
    if (is_new) {
      dynamic_.joint_names.push_back(owner);
      dynamic_.interface_values.emplace_back();
      dynamic_states_.emplace_back();
    }
    dynamic_.interface_values[at->second].interface_names.push_back(name.substr(slash + 1));
    dynamic_.interface_values[at->second].values.push_back(0);
    dynamic_states_[at->second].push_back(i);
  }
}

/// One channel per tag: every tool can plot the `data` of a std_msgs value, whatever the tag's name.
void CellChannels::add_tags() {
  std::set<std::string> topics;
  for (const signals::Tag& tag : cell_.signals().tags) {
    const data::Value* value = cell_.store().find(tag.name);
    if (!value) continue;
    std::string topic = "/tags/" + topic_part(tag.name);
    while (!topics.insert(topic).second) topic += "_";
    const char* about = "a tag, when it changes and once a second";
    std::size_t channel;
    if (value->as_boolean())
      channel = add<ros::std_msgs::msg::Bool>(topic, about);
    else if (value->as_number())
      channel = add<ros::std_msgs::msg::Float64>(topic, about);
    else
      channel = add<ros::std_msgs::msg::String>(topic, about);
    tags_.push_back({tag.name, channel, std::nullopt});
  }
}

template <class Message>
void CellChannels::say(std::size_t channel, std::int64_t time, const Message& message,
                       std::vector<std::byte>& room, const WriteMessage& tell) const {
  ros::CdrWriter counter({});
  write(counter, message);
  room.resize(std::max(room.size(), counter.size()));
  tell(channel, time, std::span(room).first(ros::to_cdr(message, room)));
}

void CellChannels::record_latched(Nanoseconds time, const WriteMessage& tell) const {
  std::vector<std::byte> room;
  const std::int64_t at = time + offset_;
  ros::tf2_msgs::msg::TFMessage fixed = state_.fixed_frames();
  for (auto& one : fixed.transforms) one.header.stamp = stamp_of(at);
  say(fixed_, at, fixed, room, tell);
  for (std::size_t i = 0; i < descriptions_.size(); ++i)
    say(descriptions_[i], at,
        ros::std_msgs::msg::String{description::write_plain_urdf(cell_.robots()[i]->model)}, room, tell);
}

void CellChannels::record_sample(const control::TappedCycle& cycle, std::span<const double> states,
                               std::span<const double> commands, const WriteMessage& tell) {
  const std::int64_t time = cycle.time + offset_;
  say(joints_, time, state_.joint_states(states, time), sample_room_, tell);
  commands_.header.stamp = stamp_of(time);
  for (std::size_t i = 0; i < commands_of_.size(); ++i) {
    commands_.position[i] = value(commands, commands_of_[i].position);
    if (!commands_.velocity.empty()) commands_.velocity[i] = value(commands, commands_of_[i].velocity);
    if (!commands_.effort.empty()) commands_.effort[i] = value(commands, commands_of_[i].effort);
  }
  say(commanded_, time, commands_, sample_room_, tell);
  say(moving_, time, state_.moving_frames(states, time), sample_room_, tell);
  tcp_.header.stamp = stamp_of(time);
  for (std::size_t i = 0; i < tcps_.size(); ++i) {
    std::array<double, 64> q{};
    const std::size_t count = std::min(tcp_states_[i].size(), q.size());
    if (count == 0) continue;
    for (std::size_t j = 0; j < count; ++j) {
      const double at = value(states, tcp_states_[i][j]);
      q[j] = std::isfinite(at) ? at : 0;
    }
    const Pose pose =
        inverse(tcp_frames_[i].pose) * cell_.robots()[i]->facts->chain.forward({q.data(), count});
    tcp_.header.frame_id = tcp_frames_[i].name;
    tcp_.pose = {{pose.position.x, pose.position.y, pose.position.z},
                 {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}};
    say(tcps_[i], time, tcp_, sample_room_, tell);
  }
  report_loop(cycle, time, tell);
}

void CellChannels::report_loop(const control::TappedCycle& cycle, std::int64_t time, const WriteMessage& tell) {
  std::array<char, 400> text;
  const bool none = cycle.cause == control::StopCause::none;
  auto end = fmt::format_to_n(text.data(), text.size(),
                              R"({{"state":"{}","cause":"{}","standing":{},"cycle":{},"late":{})",
                              control::name(cycle.state), none ? "" : control::name(cycle.cause),
                              cycle.standing, cycle.index, cycle.late);
  const auto left = [&] { return text.size() - static_cast<std::size_t>(end.out - text.data()); };
  if (!cell_.lock_step())  // left out in lock-step, where they would differ from run to run
    end = fmt::format_to_n(end.out, left(), R"(,"latency_us":{:.1f},"cost_us":{:.1f})",
                           1e-3 * static_cast<double>(cycle.woke), 1e-3 * static_cast<double>(cycle.cost));
  end = fmt::format_to_n(end.out, left(), "}}");
  tell(loop_, time, std::as_bytes(std::span(text.data(), static_cast<std::size_t>(end.out - text.data()))));
}

void CellChannels::record_interfaces(Nanoseconds time, std::span<const double> states, const WriteMessage& tell) {
  dynamic_.header.stamp = stamp_of(time + offset_);
  for (std::size_t i = 0; i < dynamic_states_.size(); ++i)
    for (std::size_t k = 0; k < dynamic_states_[i].size(); ++k)
      dynamic_.interface_values[i].values[k] = value(states, static_cast<int>(dynamic_states_[i][k]));
  say(interfaces_, time + offset_, dynamic_, sample_room_, tell);
}

void CellChannels::print_tag(const Tag& tag, const data::Value& value, std::int64_t time, const WriteMessage& tell) {
  const std::string& schema = list_[tag.channel].schema_name;
  if (schema.ends_with("Bool"))
    say(tag.channel, time, ros::std_msgs::msg::Bool{value.as_boolean() && *value.as_boolean()}, event_room_,
        tell);
  else if (schema.ends_with("Float64"))
    say(tag.channel, time,
        ros::std_msgs::msg::Float64{value.as_number() ? value.as_number()->value : kNoNumber}, event_room_,
        tell);
  else
    say(tag.channel, time, ros::std_msgs::msg::String{value.as_text() ? *value.as_text() : value.text()},
        event_room_, tell);
}

void CellChannels::report_tags(Nanoseconds time, bool all, const WriteMessage& tell) {
  const std::int64_t at = time + offset_;
  for (Tag& tag : tags_) {
    const data::Value* value = cell_.store().find(tag.name);
    if (!value) continue;
    const bool changed = !tag.told || *tag.told != *value;
    if (!changed && !all) continue;
    if (changed && tag.told) print_tag(tag, *tag.told, at - kStep, tell);
    print_tag(tag, *value, at, tell);
    if (changed) tag.told = *value;
  }
}

namespace {
/// Smaller changes are noise of the physics engine.
bool same_place(const Pose& a, const Pose& b) {
  constexpr double kLength = 1e-5, kAngle = 1e-4;
  return norm(a.position - b.position) < kLength && angle_between(a.rotation, b.rotation) < kAngle;
}
}  // namespace

void CellChannels::record_parts(Nanoseconds time, bool all, const WriteMessage& tell) {
  constexpr Nanoseconds kEvery = 20'000'000;
  if (!all && parts_at_ >= 0 && time - parts_at_ < kEvery) return;
  const auto& parts = cell_.snapshot().world.parts;
  parts_reported_.resize(parts.size());
  parts_.transforms.clear();
  for (std::size_t i = 0; i < parts.size() && i < cell_.scene().parts.size(); ++i) {
    std::optional<Pose>& told = parts_reported_[i];
    if (!parts[i].in_world) {
      told.reset();
      continue;
    }
    if (!all && told && same_place(*told, parts[i].pose)) continue;
    told = parts[i].pose;
    auto& frame = parts_.transforms.emplace_back();
    frame.header.stamp = stamp_of(time + offset_);
    frame.header.frame_id = "world";
    frame.child_frame_id = "part/" + cell_.scene().parts[i].name;
    const auto& [p, q] = parts[i].pose;
    frame.transform = {{p.x, p.y, p.z}, {q.x, q.y, q.z, q.w}};
  }
  if (parts_.transforms.empty()) return;
  parts_at_ = time;
  say(moving_, time + offset_, parts_, event_room_, tell);
}

void CellChannels::record_bases(Nanoseconds time, const WriteMessage& tell) {
  constexpr Nanoseconds kEvery = 20'000'000;
  if (bases_at_ >= 0 && time - bases_at_ < kEvery) return;
  const bool several = cell_.robots().size() > 1;
  bases_.transforms.clear();
  for (std::size_t i = 0; i < cell_.robots().size(); ++i) {
    const cell::MovingBase& base = cell_.base(i);
    const cell::CellRobot& robot = *cell_.robots()[i];
    const std::string root = frame_of(robot, robot.model.root, several);
    if (base.on_wheels()) {
      const std::string odometry = (several ? robot.entry.name + "/" : "") + base.odometry_name();
      bases_.transforms.push_back(transform("world", odometry, base.odometry_frame(cell_.snapshot())));
      bases_.transforms.push_back(transform(odometry, root, base.odometry()));
    } else if (base.moves() && !base.carried()) {
      bases_.transforms.push_back(transform("world", root, base.pose(cell_.snapshot())));
    }
  }
  if (bases_.transforms.empty()) return;
  for (auto& each : bases_.transforms) each.header.stamp = stamp_of(time + offset_);
  bases_at_ = time;
  say(moving_, time + offset_, bases_, event_room_, tell);
}

void CellChannels::record_log(Nanoseconds time, LogLevel level, const std::string& who, const std::string& text,
                            const Location& where, const WriteMessage& tell) {
  ros::rcl_interfaces::msg::Log log;
  log.stamp = stamp_of(time + offset_);
  log.level = static_cast<std::uint8_t>(level);
  log.name = who;
  log.msg = text;
  log.file = where.file;
  log.line = static_cast<std::uint32_t>(std::max(where.line, 0));
  say(log_, time + offset_, log, event_room_, tell);
}

void CellChannels::record_line(Nanoseconds time, const std::string& task, const Location& where,
                             const std::string& source, const WriteMessage& tell) {
  const std::string text =
      Json{{"task", task}, {"file", where.file}, {"line", where.line}, {"source", source}}.dump(
          -1, ' ', false, Json::error_handler_t::replace);
  tell(line_, time + offset_, std::as_bytes(std::span(text.data(), text.size())));
}

void CellChannels::record_health(Nanoseconds time, const WriteMessage& tell) {
  using Status = ros::diagnostic_msgs::msg::DiagnosticStatus;
  const control::Snapshot& seen = cell_.snapshot();
  const control::Health& health = cell_.health();
  Status status;
  status.level = seen.state == control::RunState::fault     ? Status::ERROR
                 : seen.state == control::RunState::running ? Status::OK
                                                            : Status::WARN;
  status.name = cell_.file().name + ": control loop";
  status.message = control::name(seen.state);
  if (seen.cause != control::StopCause::none) status.message += std::string(": ") + control::name(seen.cause);
  status.hardware_id = cell_.file().name;
  const auto add = [&](const char* key, std::string text) {
    status.values.push_back({key, std::move(text)});
  };
  const auto microseconds = [](Nanoseconds t) {
    return fmt::format("{:.1f}", 1e-3 * static_cast<double>(t));
  };
  add("cycles", std::to_string(seen.cycle.index));
  add("clamps", std::to_string(cell_.clamps()));
  if (!cell_.lock_step()) {
    add("late", std::to_string(std::uint64_t{health.late}));
    add("cost p50 us", microseconds(health.cost.percentile(0.5)));
    add("cost p99 us", microseconds(health.cost.percentile(0.99)));
    add("cost max us", microseconds(health.cost.max()));
    add("wake-up p99 us", microseconds(health.wake_up.percentile(0.99)));
  }
  ros::diagnostic_msgs::msg::DiagnosticArray all;
  all.header.stamp = stamp_of(time + offset_);
  all.status.push_back(std::move(status));
  say(health_, time + offset_, all, event_room_, tell);
}

std::string channel_reference(const std::vector<Channel>& channels) {
  std::string out = "| channel | messages | content |\n|---|---|---|\n";
  std::set<std::string> told;
  for (const Channel& channel : channels) {
    const bool tag = channel.topic.starts_with("/tags/");
    if (tag && !told.insert(channel.schema_name).second) continue;
    out += "| `" + (tag ? std::string("/tags/<name>") : channel.topic) + "` | `" + channel.schema_name +
           "` (" + channel.encoding + ") | " + channel.about + " |\n";
  }
  return out;
}

}  // namespace polyarm::recording
