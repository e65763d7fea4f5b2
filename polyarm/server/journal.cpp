#include "polyarm/server/journal.hpp"

#include <utility>

#include "polyarm/access/token.hpp"
#include "polyarm/machine/stops.hpp"

namespace polyarm::server {

void Journal::keep(double time, const char* level, std::string text, std::string code, Facts facts) {
  lines_.push_back({++last_line_, time, level, std::move(text), std::move(code), std::move(facts)});
  if (lines_.size() > kKept) lines_.pop_front();
}

void Journal::on_note(const std::string& text) {
  keep(now_, "info", without_tokens(text));  // the page's link would give its role to all who read the log
  next_.on_note(text);
}

void Journal::on_line(Nanoseconds time, const std::string& task, const Location& where,
                      const std::string& source) {
  next_.on_line(time, task, where, source);
}

void Journal::on_tag(Nanoseconds time, const std::string& name, const std::string& value,
                     const std::string& who) {
  next_.on_tag(time, name, value, who);
}

void Journal::on_pose(Nanoseconds time, const std::string& robot, const Pose& tcp) {
  next_.on_pose(time, robot, tcp);
}

void Journal::on_log(Nanoseconds time, const std::string& task, const std::string& text) {
  keep(seconds(time), "log", task + ": " + text);
  next_.on_log(time, task, text);
}

void Journal::on_state(Nanoseconds time, const std::string& state, const Problem& cause) {
  const bool running = state == "running";
  keep(seconds(time), "info", running ? state : state + ": " + cause.what, "state",
       running ? Facts{{"state", state}} : Facts{{"state", state}, {"cause", cause.code}});
  next_.on_state(time, state, cause);
}

void Journal::on_stop(Nanoseconds time, const cell::StopReport& stop) {
  keep(seconds(time), "info", stop.sentence(), "stop", stop.facts());
  next_.on_stop(time, stop);
}

void Journal::on_question(const std::string& text) {
  keep(now_, "question", text);
  next_.on_question(text);
}

void Journal::on_problem(Nanoseconds time, const Problem& problem) {
  keep(seconds(time), problem.severity == Severity::error ? "error" : "warning", problem.text(), problem.code,
       problem.facts);
  alarms_.push_back({++last_alarm_, seconds(time), problem});
  if (alarms_.size() > kKept) alarms_.pop_front();
  next_.on_problem(time, problem);
}

}  // namespace polyarm::server
