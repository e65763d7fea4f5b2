/// The node /polyarm: control of the whole cell, its log and its diagnostics.
#include <utility>

#include "polyarm/messages/json.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/protocol/hardware.hpp"
#include "polyarm/protocol/programs.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

namespace {

using Log = messages::rcl_interfaces::msg::Log;
using Status = messages::diagnostic_msgs::msg::DiagnosticStatus;
constexpr Nanoseconds kDiagnostics = 1'000'000'000;

std::string text_of(const Json& value) {
  return value.is_string() ? value.get<std::string>()
                           : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// A reply of the cell as a std_srvs/Trigger response.
Json triggered(const protocol::Reply& reply) {
  return {{"success", reply.answer.has_value()}, {"message", reply.refusal ? refusal_of(reply) : ""}};
}

class CellNode : public Part {
 public:
  explicit CellNode(Bridge& bridge) : bridge_{bridge}, node_{bridge.name("polyarm")} {
    diagnostics_ = bridge.wire().publisher(
        node_, "/diagnostics", messages::type_info<messages::diagnostic_msgs::msg::DiagnosticArray>());
    log_ = bridge.wire().publisher(node_, "/rosout", messages::type_info<Log>(), {true, true, 1000});
    // These do the same as the commands of the same names; nothing moves without such a request.
    offer("stop", protocol::ControlStop{});
    offer("hold", protocol::ControlHold{});
    offer("resume", protocol::ControlResume{});
    offer("discard", protocol::ControlDiscard{});
    offer("recover", protocol::ControlRecover{});
    if (bridge.cell().program()) {
      offer("program/pause", protocol::ProgramPause{});
      offer("program/stop", protocol::ProgramStop{});
      trigger("program/start", [this](const Reply& reply) { start_program(reply); });
    }
    ParameterSource none;
    none.list = [](std::function<void(Json)> got) { got(Json::object()); };
    none.set = [](const Json&, std::function<void(std::string)> done) { done("there is no such parameter"); };
    offer_standard_services(bridge_, node_, std::move(none));
  }

  void serve() override {
    report_events_of_cell();
    const Nanoseconds now = bridge_.cell().now();
    if (announced_ >= 0 && now - announced_ < kDiagnostics) return;
    announced_ = now;
    if (bridge_.wire().wanted(diagnostics_))
      bridge_.ask(protocol::LoopHealth{}, [this](const protocol::Reply& reply) { tell_diagnostics(reply); });
  }

 private:
  /// Publishes the cell's reports on /rosout.
  void report_events_of_cell() {
    for (const protocol::Event& event : bridge_.cell().events().events())
      if (event.number > last_event_) tell_event(event);
    last_event_ = bridge_.cell().events().last();
  }
  void tell_event(const protocol::Event& event) {
    const std::string& kind = event.event;
    const auto text = [](const std::optional<std::string>& member) { return member.value_or(""); };
    std::string message = text(event.text), name = "polyarm";
    if (kind == "problem")
      message = text(event.what) + (text(event.advice).empty() ? "" : " (" + text(event.advice) + ")");
    else if (kind == "state")
      message = "the cell is " + text(event.state) + (text(event.cause).empty() ? "" : ": " + text(event.cause));
    else if (kind == "log")
      name += "." + text(event.task);
    else if (kind != "note" && kind != "stop" && kind != "question")
      return;  // lines and tags are too frequent
    const bool problem = kind == "problem";
    const bool error = problem ? event.severity == protocol::FindingSeverity::error : kind == "state" && event.state == "fault";
    const bool warning = problem || (kind == "state" && event.state != "running");
    const int level = error ? Log::ERROR : warning ? Log::WARN : Log::INFO;
    const Json out{{"stamp", bridge_.ros_stamp(bridge_.cell().now())},
                   {"level", level},
                   {"name", name},
                   {"msg", message},
                   {"file", problem ? text(event.where) : ""}};
    bridge_.wire().publish(log_, messages::from_json(messages::type_info<Log>(), out));
  }

  void trigger(const std::string& service, std::function<void(const Reply&)> work) {
    bridge_.service(node_, node_ + "/" + service, "std_srvs/srv/Trigger",
                    [work = std::move(work)](const Json&, const Reply& reply) { work(reply); });
  }
  void offer(const std::string& service, const protocol::Request& request) {
    trigger(service, [this, request](const Reply& reply) { pass(request, reply); });
  }
  void pass(const protocol::Request& request, const Reply& reply) {
    bridge_.ask(request, [reply](const protocol::Reply& replied) { reply(triggered(replied)); });
  }

  /// Resumes a paused program; starts it again if it has ended.
  void start_program(const Reply& reply) {
    bridge_.ask(protocol::ProgramState{}, [this, reply](const protocol::Reply& replied) {
      if (replied.refusal) return reply(triggered(replied));
      if (replied.answer->as<protocol::ProgramState>().paused) return pass(protocol::ProgramGo{}, reply);
      protocol::ProgramFrom anew;
      anew.confirmed = true;
      pass(anew, reply);
    });
  }

  Json status(const std::string& of, int level, const std::string& text, Json values) const {
    const std::string name = bridge_.cell().file().name;
    return {{"level", level},
            {"name", name + ": " + of},
            {"message", text},
            {"hardware_id", name},
            {"values", std::move(values)}};
  }

  Json of_loop(const Json& health) const {
    const std::string state = health.value("state", std::string());
    Json values = Json::array();
    for (const char* key : {"cause", "rate_hz", "cycles", "late", "clamps", "override_percent", "time_s"})
      if (health.contains(key)) values.push_back({{"key", key}, {"value", text_of(health[key])}});
    return status("control loop",
                  state == "fault"     ? Status::ERROR
                  : state == "running" ? Status::OK
                                       : Status::WARN,
                  state, std::move(values));
  }

  /// Counts of samples since the start. A warning if more were refused, dropped or not sent since the last
  /// call.
  Json of_wire() {
    const WireStatistics now = bridge_.wire().statistics();
    const std::uint64_t bad = now.refused + now.dropped + now.unsent;
    const bool worse = bad > std::exchange(bad_, bad);
    Json values = Json::array();
    const std::pair<const char*, std::uint64_t> counts[] = {{"received", now.received},
                                                            {"refused", now.refused},
                                                            {"dropped", now.dropped},
                                                            {"sent", now.sent},
                                                            {"unsent", now.unsent}};
    for (const auto& [key, count] : counts)
      values.push_back({{"key", key}, {"value", std::to_string(count)}});
    return status("messages", worse ? Status::WARN : Status::OK,
                  worse ? "messages were refused, dropped or not sent" : "ok", std::move(values));
  }

  void tell_diagnostics(const protocol::Reply& reply) {
    const Json health = reply.answer ? reply.answer->any().json() : Json::object();
    const Json message{{"header", {{"stamp", bridge_.ros_stamp(bridge_.cell().now())}}},
                       {"status", {of_loop(health), of_wire()}}};
    const auto& type = messages::type_info<messages::diagnostic_msgs::msg::DiagnosticArray>();
    bridge_.wire().publish(diagnostics_, messages::from_json(type, message));
  }

  Bridge& bridge_;
  std::string node_;
  Wire::Id diagnostics_ = 0, log_ = 0;
  std::uint64_t last_event_ = 0;
  Nanoseconds announced_ = -1;
  std::uint64_t bad_ = 0;
};

}  // namespace

std::unique_ptr<Part> make_cell_node(Bridge& bridge) {
  return std::make_unique<CellNode>(bridge);
}

}  // namespace polyarm::ros2
