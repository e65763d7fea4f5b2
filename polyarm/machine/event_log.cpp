#include "polyarm/machine/event_log.hpp"

#include <string_view>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/machine/stops.hpp"

namespace polyarm::cell {

using protocol::Event;

static_assert(EventLog::kKept == bounds::kEventsKept);

namespace {
/// Shortens a text for the log, because a list of thousands of values must not be stored a thousand times.
std::string clipped(const std::string& text) {
  constexpr std::size_t kMost = bounds::kEventBytes;
  if (text.size() <= kMost) return text;
  const std::string_view cut = std::string_view(text).substr(0, kMost);
  return std::string(cut.substr(0, whole_characters(cut))) + "…";
}
}  // namespace

void EventLog::keep(Event event) {
  event.number = ++last_;
  events_.push_back(std::move(event));
  if (events_.size() > kKept) events_.pop_front();
}

namespace {
Event event_of(const char* kind) {
  Event out;
  out.event = kind;
  return out;
}
Event event_of(const char* kind, Nanoseconds time) {
  Event out = event_of(kind);
  out.time_s = seconds(time);
  return out;
}
}  // namespace

void EventLog::on_note(const std::string& text) {
  Event event = event_of("note");
  event.text = clipped(text);
  keep(std::move(event));
  next_.on_note(text);
}

void EventLog::on_line(Nanoseconds time, const std::string& task, const Location& where,
                       const std::string& source) {
  Event event = event_of("line", time);
  event.task = task;
  event.file = where.file;
  event.line = where.line;
  event.source = clipped(source);
  keep(std::move(event));
  next_.on_line(time, task, where, source);
}

void EventLog::on_tag(Nanoseconds time, const std::string& name, const std::string& value,
                      const std::string& who) {
  Event event = event_of("tag", time);
  event.name = name;
  event.value = clipped(value);
  event.by = who;
  keep(std::move(event));
  next_.on_tag(time, name, value, who);
}

void EventLog::on_pose(Nanoseconds time, const std::string& robot, const Pose& tcp) {
  next_.on_pose(time, robot, tcp);
}

void EventLog::on_log(Nanoseconds time, const std::string& task, const std::string& text) {
  Event event = event_of("log", time);
  event.task = task;
  event.text = clipped(text);
  keep(std::move(event));
  next_.on_log(time, task, text);
}

void EventLog::on_state(Nanoseconds time, const std::string& state, const Problem& cause) {
  Event event = event_of("state", time);
  event.state = state;
  event.cause = cause.what;
  event.cause_code = cause.code;
  keep(std::move(event));
  next_.on_state(time, state, cause);
}

void EventLog::on_stop(Nanoseconds time, const StopReport& stop) {
  const protocol::StopFacts facts = facts_of(stop);
  Event event = event_of("stop");
  event.time_s = facts.time_s;
  event.at_s = facts.at_s;
  event.category = facts.category;
  event.cause = facts.cause;
  event.cause_code = facts.cause_code;
  event.tcp_m = facts.tcp_m;
  event.joints = facts.joints;
  event.text = stop.sentence();
  keep(std::move(event));
  next_.on_stop(time, stop);
}

void EventLog::on_question(const std::string& text) {
  Event event = event_of("question");
  event.text = clipped(text);
  keep(std::move(event));
  next_.on_question(text);
}

void EventLog::on_problem(Nanoseconds time, const Problem& problem) {
  Event event = event_of("problem", time);
  event.code = problem.code;
  event.where = problem.where.text();
  event.what = problem.what;
  event.advice = problem.advice;
  event.severity = static_cast<protocol::FindingSeverity>(problem.severity);
  keep(std::move(event));
  next_.on_problem(time, problem);
}

}  // namespace polyarm::cell
