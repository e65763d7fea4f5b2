#include "polyarm/cell/event_log.hpp"

#include <utility>

#include "polyarm/cell/stops.hpp"

namespace polyarm::cell {

using nlohmann::json;

void EventLog::keep(json event) {
  events_.push_back({++last_, std::move(event)});
  if (events_.size() > kKept) events_.pop_front();
}

void EventLog::on_note(const std::string& text) {
  keep({{"event", "note"}, {"text", text}});
  next_.on_note(text);
}

void EventLog::on_line(Nanoseconds time, const std::string& task, const Location& where,
                       const std::string& source) {
  keep({{"event", "line"},
        {"time_s", seconds(time)},
        {"task", task},
        {"file", where.file},
        {"line", where.line},
        {"source", source}});
  next_.on_line(time, task, where, source);
}

void EventLog::on_tag(Nanoseconds time, const std::string& name, const std::string& value,
                      const std::string& who) {
  keep({{"event", "tag"}, {"time_s", seconds(time)}, {"name", name}, {"value", value}, {"by", who}});
  next_.on_tag(time, name, value, who);
}

void EventLog::on_pose(Nanoseconds time, const std::string& robot, const Pose& tcp) {
  next_.on_pose(time, robot, tcp);
}

void EventLog::on_log(Nanoseconds time, const std::string& task, const std::string& text) {
  keep({{"event", "log"}, {"time_s", seconds(time)}, {"task", task}, {"text", text}});
  next_.on_log(time, task, text);
}

void EventLog::on_state(Nanoseconds time, const std::string& state, const std::string& cause) {
  keep({{"event", "state"}, {"time_s", seconds(time)}, {"state", state}, {"cause", cause}});
  next_.on_state(time, state, cause);
}

void EventLog::on_stop(Nanoseconds time, const StopReport& stop) {
  json event = json_of(stop);
  event["event"] = "stop";
  event["text"] = stop.sentence();
  keep(std::move(event));
  next_.on_stop(time, stop);
}

void EventLog::on_question(const std::string& text) {
  keep({{"event", "question"}, {"text", text}});
  next_.on_question(text);
}

void EventLog::on_problem(Nanoseconds time, const Problem& problem) {
  keep({{"event", "problem"},
        {"time_s", seconds(time)},
        {"code", problem.code},
        {"where", problem.where.text()},
        {"what", problem.what},
        {"advice", problem.advice},
        {"severity", problem.severity == Severity::error ? "error" : "warning"}});
  next_.on_problem(time, problem);
}

}  // namespace polyarm::cell
