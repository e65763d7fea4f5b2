#include "apps/run_output.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "apps/journal.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/printer.hpp"
#include "polyarm/base/secrets.hpp"
#include "polyarm/protocol/type.hpp"
#include "polyarm/setup/tag_rate.hpp"

namespace polyarm::apps {

namespace {

using nlohmann::json;

Printer::Full when_full(bool whole) {
  return whole ? Printer::Full::waits : Printer::Full::leaves_out;
}

Priority priority_of(const Problem& problem) {
  return problem.severity == Severity::error ? Priority::error : Priority::warning;
}
Priority priority_of_state(const std::string& state) {
  return state == "fault" ? Priority::error : Priority::notice;
}

/// Lines of standard output; they carry priorities if it leads to the journal.
class Lines {
 public:
  Lines(bool whole, const Printer::Gap& gap)
      : journal_(leads_to_journal(STDOUT_FILENO)),
        printer_(STDOUT_FILENO, when_full(whole), [gap, journal = journal_](std::size_t count) {
          return journal ? for_journal(gap(count), Priority::warning) : gap(count);
        }) {
    printer_.when_gone(cell::request_stop_once);
  }
  void put(const std::string& text, Priority priority) {
    printer_.put(journal_ ? for_journal(text, priority) : text);
  }
  /// Text that is not a line, for a terminal.
  void draw(const std::string& text) { printer_.put(text); }
  bool settle() { return printer_.settle() && !printer_.gone(); }

 private:
  const bool journal_;
  Printer printer_;
};

/// Lines scroll; on a terminal one status line (time, pose) stays at the bottom.
class TextOutput : public Output {
 public:
  TextOutput(bool quiet, bool whole, bool typed)
      : quiet_(quiet), typed_(typed), terminal_(::isatty(STDOUT_FILENO) != 0), lines_(whole, gap) {}
  ~TextOutput() override { lines_.draw(cleared()); }
  bool settle() override {
    lines_.draw(cleared());
    return lines_.settle();
  }

  void on_note(const std::string& text) override { line("         " + text); }
  void on_line(Nanoseconds time, const std::string& task, const Location& where,
               const std::string& source) override {
    if (quiet_ || task != "program") return;
    line(fmt::format("{:8.3f} {:>4} │ {}", seconds(time), where.line, shortened(source)), Priority::debug);
  }
  void on_tag(Nanoseconds time, const std::string& name, const std::string& value,
              const std::string& who) override {
    if (quiet_) return;
    const cell::TagRate::Verdict verdict = tags_.look(time, name);
    if (verdict.left_out > 0)
      line(fmt::format("{:8.3f}      │      {}: {} more changes", seconds(time), name, verdict.left_out),
           Priority::debug);
    if (verdict.shown)
      line(fmt::format("{:8.3f}      │      {} = {}  ({})", seconds(time), name, shortened(value), who),
           Priority::debug);
  }
  void on_log(Nanoseconds time, const std::string& task, const std::string& text) override {
    line(fmt::format("{:8.3f}      │ {}: {}", seconds(time), task, text));
  }
  void on_state(Nanoseconds time, const std::string& state, const Problem& cause) override {
    line(fmt::format("{:8.3f}  {}{}{}", seconds(time), state, state == "running" ? "" : ": " + cause.what,
                     typed_ && state == "held" && cause.code != "run-failed"
                         ? "  (type resume, back, discard or stop)"
                         : ""),
         priority_of_state(state));
  }
  void on_stop(Nanoseconds time, const cell::StopReport& stop) override {
    line(fmt::format("{:8.3f}  {}", seconds(time), stop.sentence()), Priority::notice);
  }
  void on_question(const std::string& text) override { line("?        " + text, Priority::notice); }
  void on_problem(Nanoseconds, const Problem& problem) override {
    line(problem.text(), priority_of(problem));
  }
  void on_pose(Nanoseconds time, const std::string& robot, const Pose& tcp) override {
    if (!terminal_ || quiet_) return;
    const Vec3 rpy = to_rpy(tcp.rotation);
    lines_.draw(fmt::format("\r\033[K{:8.3f} {}  TCP {:+.3f} {:+.3f} {:+.3f} m  rpy {:+.2f} {:+.2f} {:+.2f}",
                            seconds(time), printable(robot), tcp.position.x, tcp.position.y, tcp.position.z,
                            rpy.x, rpy.y, rpy.z));
    status_ = true;
  }

 private:
  static std::string gap(std::size_t count) {
    return fmt::format("         {} lines are omitted: this output was not read\n", count);
  }
  const char* cleared() { return std::exchange(status_, false) ? "\r\033[K" : ""; }
  void line(const std::string& text, Priority priority = Priority::info) {
    lines_.put(cleared() + printable(text) + "\n", priority);
  }
  bool quiet_, typed_, terminal_, status_ = false;
  cell::TagRate tags_;
  Lines lines_;
};

class JsonOutput : public Output {
 public:
  explicit JsonOutput(bool whole) : lines_(whole, gap) {}
  bool settle() override { return lines_.settle(); }
  /// Removes the pendant's token, because logs of programs are kept and shared.
  void on_note(const std::string& text) override {
    put({{"event", "note"}, {"text", without_secrets(text)}});
  }
  void on_line(Nanoseconds t, const std::string& task, const Location& where,
               const std::string& source) override {
    line_event_["time_s"] = seconds(t);
    line_event_["line"] = where.line;
    line_task_ = task;
    line_file_ = where.file;
    line_source_ = source;
    put(line_event_, Priority::debug);
  }
  void on_tag(Nanoseconds t, const std::string& name, const std::string& value,
              const std::string& who) override {
    const cell::TagRate::Verdict verdict = tags_.look(t, name);
    if (verdict.left_out > 0)
      put({{"event", "tag_left_out"}, {"time_s", seconds(t)}, {"name", name}, {"count", verdict.left_out}},
          Priority::debug);
    if (verdict.shown)
      put({{"event", "tag"}, {"time_s", seconds(t)}, {"name", name}, {"value", value}, {"by", who}},
          Priority::debug);
  }
  void on_log(Nanoseconds t, const std::string& task, const std::string& text) override {
    put({{"event", "log"}, {"time_s", seconds(t)}, {"task", task}, {"text", text}});
  }
  void on_state(Nanoseconds t, const std::string& state, const Problem& cause) override {
    put({{"event", "state"},
         {"time_s", seconds(t)},
         {"state", state},
         {"cause", cause.what},
         {"cause_code", cause.code}},
        priority_of_state(state));
  }
  void on_stop(Nanoseconds t, const cell::StopReport& stop) override {
    json event = protocol::any_of(cell::facts_of(stop)).json();
    event["event"] = "stop";
    put(event, Priority::notice);
  }
  void on_question(const std::string& text) override {
    put({{"event", "question"}, {"text", text}}, Priority::notice);
  }
  void on_problem(Nanoseconds t, const Problem& p) override {
    put({{"event", "problem"},
         {"time_s", seconds(t)},
         {"code", p.code},
         {"where", p.where.text()},
         {"text", p.what},
         {"severity", p.severity == Severity::error ? "error" : "warning"}},
        priority_of(p));
  }
  void on_pose(Nanoseconds t, const std::string& robot, const Pose& tcp) override {
    if (t - last_ < 1'000'000'000) return;
    last_ = t;
    put({{"event", "pose"},
         {"time_s", seconds(t)},
         {"robot", robot},
         {"xyz", {tcp.position.x, tcp.position.y, tcp.position.z}},
         {"quaternion", {tcp.rotation.x, tcp.rotation.y, tcp.rotation.z, tcp.rotation.w}}},
        Priority::debug);
  }

 private:
  /// ASCII only on a terminal.
  static std::string line(const json& object) {
    static const bool terminal = ::isatty(STDOUT_FILENO) != 0;
    return object.dump(-1, ' ', terminal, json::error_handler_t::replace) + "\n";
  }
  static std::string gap(std::size_t count) {
    return line(
        {{"event", "note"}, {"text", fmt::format("{} lines are omitted: they were not read", count)}});
  }
  void put(const json& object, Priority priority = Priority::info) { lines_.put(line(object), priority); }
  Lines lines_;
  cell::TagRate tags_;
  Nanoseconds last_ = -1'000'000'000;
  // The commonest event is made once and filled in place.
  json line_event_ = {{"event", "line"}, {"time_s", 0.0}, {"task", ""},
                      {"file", ""},      {"line", 0},     {"source", ""}};
  std::string& line_task_ = line_event_["task"].get_ref<std::string&>();
  std::string& line_file_ = line_event_["file"].get_ref<std::string&>();
  std::string& line_source_ = line_event_["source"].get_ref<std::string&>();
};

json vector(const Vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

std::unique_ptr<Output> make_text_output(bool quiet, bool whole, bool typed) {
  return std::make_unique<TextOutput>(quiet, whole, typed);
}
std::unique_ptr<Output> make_json_output(bool whole) {
  return std::make_unique<JsonOutput>(whole);
}

std::string result_json(const cell::RunResult& r, const std::string& failure_folder) {
  json parts = json::array();
  for (const cell::PartReport& part : r.parts)
    parts.push_back({{"name", part.name},
                     {"kind", part.kind},
                     {"at", vector(part.at)},
                     {"goal", part.goal ? vector(part.goal->at) : json()},
                     {"error_m", part.error_m ? json(*part.error_m) : json()},
                     {"bin", part.bin},
                     {"state", cell::name(part.fate)},
                     {"taken", part.taken}});
  json problems = json::array();
  for (const Problem& problem : r.problems)
    problems.push_back({{"code", problem.code},
                        {"where", problem.where.text()},
                        {"text", problem.what},
                        {"advice", problem.advice}});
  json stops = json::array();
  for (const cell::StopReport& stop : r.stops) stops.push_back(protocol::any_of(cell::facts_of(stop)).json());
  const json out = {
      {"result", cell::name(r.outcome)},
      {"error", r.problems.empty() ? json() : json(r.problems.front().text())},
      {"problems", problems},
      {"sim_time_s", r.sim_time_s},
      {"wall_time_s", r.wall_time_s},
      {"physics_step_s", r.physics_step_s ? json(*r.physics_step_s) : json()},
      {"program_cycles", r.program_cycles},
      {"control_cycles", r.health.cycles},
      {"late_cycles", r.health.late},
      {"late_cycles_empty_loop", r.health.late_empty},
      {"cycle_ns", {{"p50", r.health.cost_p50}, {"p99", r.health.cost_p99}, {"max", r.health.cost_max}}},
      {"wake_up_ns", {{"p50", r.health.wake_p50}, {"p99", r.health.wake_p99}, {"max", r.health.wake_max}}},
      {"first_motion_s", r.first_motion_s ? json(*r.first_motion_s) : json()},
      {"contacts_max", r.contacts_max},
      {"tracking_error_max", r.tracking_error_max},
      {"clamps", r.clamps},
      {"parts", parts},
      {"stops", stops},
      {"repeatable", r.repeatable},
      {"trace_hash", r.trace_hash},
      {"failure_folder", failure_folder.empty() ? json() : json(failure_folder)},
  };
  return out.dump(-1, ' ', false, json::error_handler_t::replace);
}

void print_result(const cell::RunResult& r, const std::string& failure_folder) {
  fmt::print("\n{} after {:.2f} s of cell time ({:.2f} s of wall time, {:.1f} x), {} program cycles\n",
             cell::name(r.outcome), r.sim_time_s, r.wall_time_s,
             r.wall_time_s > 0 ? r.sim_time_s / r.wall_time_s : 0, r.program_cycles);
  if (r.program_cycles > 0)
    fmt::print("cycle time      {:.2f} s a pass\n", r.sim_time_s / static_cast<double>(r.program_cycles));
  for (const cell::PartReport& part : r.parts)
    fmt::print("part            {}{}{}\n", part.sentence(),
               part.error_m ? fmt::format(", {:.2f} mm from its goal", 1e3 * *part.error_m) : "",
               part.bin.empty() ? "" : ", in " + part.bin);
  for (const cell::StopReport& stop : r.stops)
    fmt::print("stop            at {:.3f} s {}\n", seconds(stop.begun), stop.sentence());
  const cell::LoopHealth& h = r.health;
  fmt::print("control loop    {} cycles, {} late (an empty loop beside it: {})\n", h.cycles, h.late,
             h.late_empty);
  fmt::print("cycle cost      p50 {:.1f} us, p99 {:.1f} us, max {:.1f} us\n", h.cost_p50 / 1e3,
             h.cost_p99 / 1e3, h.cost_max / 1e3);
  if (h.wake_max > 0)
    fmt::print("wake-up         p50 {:.1f} us, p99 {:.1f} us, max {:.1f} us late\n", h.wake_p50 / 1e3,
               h.wake_p99 / 1e3, h.wake_max / 1e3);
  if (r.first_motion_s) fmt::print("first motion    {:.2f} s after the command\n", *r.first_motion_s);
  fmt::print("tracking        at most {:.3f} mrad (or mm) behind the set point\n",
             1e3 * r.tracking_error_max);
  if (r.repeatable) fmt::print("trace           {}\n", r.trace_hash);
  for (const Problem& problem : r.problems) fmt::print("{}\n", problem.text());
  if (!failure_folder.empty()) fmt::print("to run it again: {}\n", failure_folder);
}

}  // namespace polyarm::apps
