#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <string_view>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/messages/json.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

namespace {
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kWindow = kSecond / 4;
constexpr int kRecent = 5;
}  // namespace

std::int64_t nanoseconds_of(const Json& stamp) {
  return stamp.value("sec", std::int64_t{0}) * kSecond + stamp.value("nanosec", std::int64_t{0});
}
Json stamp_of(std::int64_t nanoseconds) {
  std::int64_t whole = nanoseconds / kSecond, part = nanoseconds % kSecond;
  if (part < 0) --whole, part += kSecond;
  return {{"sec", whole}, {"nanosec", part}};
}

Bridge::Bridge(cell::CellView& cell, const ParticipantOptions& options, messages::Distribution distribution,
               std::string space, std::vector<std::string> twists)
    : cell_{cell}, wire_{options, distribution}, space_{std::move(space)}, twists_{std::move(twists)} {
  while (space_.ends_with('/')) space_.pop_back();
  if (!space_.empty() && space_[0] != '/') space_ = std::string("/").append(space_);
}

std::string Bridge::name(const std::string& relative) const {
  return relative.starts_with('/') ? relative : space_ + "/" + relative;
}

const messages::TypeInfo& Bridge::type(const std::string& name) const {
  const messages::TypeInfo* found = wire_.find_type(name);
  if (!found) throw Error("unknown-type", "there is no message type " + name);
  return *found;
}

std::string Bridge::interface_name(const std::string& name) const {
  if (cell_.robots().size() != 1) return name;
  const std::string prefix = cell_.robots().front()->entry.name + "/";
  return name.starts_with(prefix) ? name.substr(prefix.size()) : name;
}

std::string refusal_of(const protocol::Reply& reply) {
  return reply.refusal ? reply.refusal->problems().front().what : "refused";
}

namespace {
std::size_t weight_of(const Json& value) {
  std::size_t out = sizeof(Json);
  if (value.is_string()) out += value.get_ref<const std::string&>().size();
  if (value.is_structured())
    for (const Json& item : value) out += weight_of(item);
  return out;
}

/// Approximate memory of a request: a message from a peer may be long.
std::size_t weight_of(const protocol::Request& request) {
  if (&request.facts() != &protocol::SendMessage::kFacts) return 0;
  return weight_of(request.as<protocol::SendMessage>().message.json());
}
}  // namespace

void Bridge::ask(protocol::Request request, OnReply on_reply, const void* from) {
  const bool changes = std::string_view(request.facts().name).starts_with("control.");
  const std::size_t bytes = weight_of(request);
  cell_.requests().ask(
      std::move(request),
      [this, changes, on_reply = std::move(on_reply)](const protocol::Reply& reply) {
        changed_ = changed_ || changes;
        guarded([&] { on_reply(reply); });
        return true;
      },
      from, bytes);
}

void Bridge::guarded(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& e) {
    if (announced_.insert(e.what()).second)
      cell_.tell(std::string("ROS 2: a message could not be made: ") + e.what());
  }
}

void Bridge::service(const std::string& node, const std::string& service, const std::string& type,
                     OnCall call) {
  const messages::TypeInfo& asked = this->type(type + "_Request");
  const messages::TypeInfo& answered = this->type(type + "_Response");
  wire_.service(
      node, service, type, [this, &asked, &answered, call = std::move(call)](Wire::Request request) {
        Json fields;
        if (messages::to_json(asked, request.payload, fields) != messages::CdrError::none) return false;
        const auto once =
            std::make_shared<std::function<void(std::vector<std::byte>)>>(std::move(request.answer));
        guarded([&] {
          call(std::move(fields), [once, &answered](const Json& response) {
            if (*once) (*once)(messages::from_json(answered, response));
            *once = nullptr;
          });
        });
        return true;
      });
}

void Bridge::subscribe(const std::string& node, const std::string& topic, const std::string& type,
                       std::function<void(Json)> on_message, Qos qos) {
  const messages::TypeInfo& info = this->type(type);
  wire_.subscription(node, topic, info, qos,
                     [this, &info, on_message = std::move(on_message)](std::span<const std::byte> payload) {
                       Json message;
                       if (messages::to_json(info, payload, message) != messages::CdrError::none)
                         return false;
                       guarded([&] { on_message(std::move(message)); });
                       return true;
                     });
}

std::vector<std::string> Bridge::at_once(const std::vector<std::string>& types) const {
  std::vector<std::string> out;
  for (const std::string& type : types)
    if (std::find(twists_.begin(), twists_.end(), type) != twists_.end()) out.push_back(type);
  return out.empty() ? std::vector{types.front()} : out;
}

void offer_standard_services(Bridge& bridge, const std::string& node, ParameterSource source) {
  offer_parameters(bridge, node, std::move(source));
  offer_type_descriptions(bridge, node);
}

/// The newest cycle is seen up to one period after it began, so the smallest of many differences is the true
/// offset. A skipped cycle adds a whole period, in which the cell's clock stands still.
void Bridge::check_clock() {
  reports_ = is_due(told_streams_);
  if (cell_.lock_step()) return;
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  const std::int64_t now = std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
  const std::int64_t period = cell_.period(), seen = now - cell_.snapshot().cycle.time;
  if (std::abs(seen - offset_) > kSecond) {  // first call, or the system clock was set
    least_ = least_before_ = recent_ = seen;
    looks_ = 0;
    window_ends_ = now + kWindow;
  }
  if (now > window_ends_ || window_ends_ - now > kWindow) {
    least_before_ = std::exchange(least_, seen);
    window_ends_ = now + kWindow;
  }
  least_ = std::min(least_, seen);
  recent_ = std::min(recent_, seen);
  offset_ = std::min(least_, least_before_);
  if (++looks_ < kRecent) return;
  const std::int64_t skipped = (std::exchange(recent_, INT64_MAX) - offset_ + period / 20) / period * period;
  least_ += skipped;
  least_before_ += skipped;
  offset_ += skipped;
  looks_ = 0;
}

bool Bridge::is_due(std::chrono::steady_clock::time_point& last) const {
  if (!cell_.lock_step()) return true;
  const auto now = std::chrono::steady_clock::now();
  if (now - last < std::chrono::milliseconds(1)) return false;
  last = now;
  return true;
}

std::int64_t Bridge::ros_time(Nanoseconds cell_time) const {
  return cell_time + offset_;
}
Json Bridge::ros_stamp(Nanoseconds cell_time) const {
  return stamp_of(ros_time(cell_time));
}

void Bridge::to_ros(Json& message) const {
  if (message.contains("header") && message["header"].contains("stamp"))
    message["header"]["stamp"] = ros_stamp(nanoseconds_of(message["header"]["stamp"]));
}

namespace {
/// Removes empty lists from a trajectory: the cell expects missing keys instead.
void leave_out_empty(Json& trajectory) {
  for (Json& point : trajectory["points"]) {
    for (const char* list : {"positions", "velocities", "accelerations", "effort"})
      if (point.contains(list) && point[list].empty()) point.erase(list);
    point["time_from_start"] = 1e-9 * static_cast<double>(nanoseconds_of(point["time_from_start"]));
  }
}
}  // namespace

void Bridge::to_cell(Json& message) const {
  if (message.contains("points") && message.contains("joint_names")) leave_out_empty(message);
  if (!message.contains("header") || !message["header"].contains("stamp")) return;
  Json& stamp = message["header"]["stamp"];
  const std::int64_t given = nanoseconds_of(stamp);
  // A stamp before the start of the cell is old and does not mean "now": it becomes the smallest stamp.
  if (given != 0)
    stamp = stamp_of(std::max<std::int64_t>(given - offset_, 1));
  else
    message.erase("header");  // 0 means "now"; the cell uses nothing else of the header
}

}  // namespace polyarm::ros2
