#include "polyarm/cell/event_log.hpp"

#include <string_view>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/cell/stops.hpp"

namespace polyarm::cell {

using nlohmann::json;

static_assert(EventLog::kKept == bounds::kEventsKept);

namespace {
/// What is kept of a text: a list of thousands of values is not kept a thousand times.
std::string clipped(const std::string& text) {
  constexpr std::size_t kMost = bounds::kEventBytes;
  if (text.size() <= kMost) return text;
  const std::string_view cut = std::string_view(text).substr(0, kMost);
  return std::string(cut.substr(0, whole_characters(cut))) + "…";
}
}  // namespace

void EventLog::keep(json event) {
  events_.push_back({++last_, std::move(event)});
  if (events_.size() > kKept) events_.pop_front();
}

void EventLog::on_note(const std::string& text) {
  keep({{"event", "note"}, {"text", clipped(text)}});
  next_.on_note(text);
}

void EventLog::on_line(Nanoseconds time, const std::string& task, const Location& where,
                       const std::string& source) {
  keep({{"event", "line"},
        {"time_s", seconds(time)},
        {"task", task},
        {"file", where.file},
        {"line", where.line},
        {"source", clipped(source)}});
  next_.on_line(time, task, where, source);
}

void EventLog::on_tag(Nanoseconds time, const std::string& name, const std::string& value,
                      const std::string& who) {
  keep({{"event", "tag"}, {"time_s", seconds(time)}, {"name", name}, {"value", clipped(value)}, {"by", who}});
  next_.on_tag(time, name, value, who);
}

void EventLog::on_pose(Nanoseconds time, const std::string& robot, const Pose& tcp) {
  next_.on_pose(time, robot, tcp);
}

void EventLog::on_log(Nanoseconds time, const std::string& task, const std::string& text) {
  keep({{"event", "log"}, {"time_s", seconds(time)}, {"task", task}, {"text", clipped(text)}});
  next_.on_log(time, task, text);
}

void EventLog::on_state(Nanoseconds time, const std::string& state, const Problem& cause) {
  keep({{"event", "state"},
        {"time_s", seconds(time)},
        {"state", state},
        {"cause", cause.what},
        {"cause_code", cause.code}});
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
  keep({{"event", "question"}, {"text", clipped(text)}});
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
