#include "apps/console_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <initializer_list>
#include <thread>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {
namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr milliseconds kLookAgain{50};

bool is_one_of(const Json& value, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* word) { return value == word; });
}
/// True if the program is paused before a statement.
bool is_paused(const Json& state) {
  return state["paused"].get<bool>() && is_one_of(state["state"], {"running", "waiting"});
}
std::string state_word(const Json& state) {
  return is_paused(state) ? "paused" : shown(state["state"]);
}
bool has_ended(const Json& state) {
  return is_one_of(state["state"], {"finished", "failed", "stopped", "none"});
}
std::string file_name(const Json& state) {
  return fs::path(state["file"].get<std::string>()).filename().string();
}
}  // namespace

std::vector<std::string> ConsoleScript::files() const {
  std::vector<std::string> out = editor_.files();
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(cell_.folder(), error))
    if (entry.path().extension() == ".script") out.push_back(entry.path().filename());
  std::sort(out.begin(), out.end());
  return out;
}

void ConsoleScript::load_file(const std::string& file) {
  if (editor_.has_unsaved()) talk_.say("note: " + editor_.summary() + "; the script uses the saved values");
  const Json loaded = cell_.ask({{"request", "program.load"}, {"file", file}});
  file_ = file;
  for (const Json& warning : loaded["warnings"]) talk_.say(shown(warning));
  talk_.say("loaded " + file_name(loaded));
}

/// Prints what a program that starts in the middle assumes.
void ConsoleScript::report_assumed(const Json& assumed) {
  talk_.say(
      fmt::format("it will begin at line {}: {}", shown(assumed["where"]["line"]), shown(assumed["source"])));
  const std::pair<const char*, const char*> kTexts[] = {{"last_point", "the robot is as after the move to"},
                                                        {"robot", "robot"},
                                                        {"tool", "tool"},
                                                        {"frame", "frame"}};
  for (const auto& [key, text] : kTexts)
    if (assumed[key] != "") talk_.say(fmt::format("  {}: {}", text, shown(assumed[key])));
  const std::pair<const char*, const char*> kValues[] = {
      {"sets", "set before"}, {"reads", "read from there on"}, {"variables", "variables"}};
  for (const auto& [key, text] : kValues) {
    std::string values;
    for (const Json& each : assumed[key])
      values += (values.empty() ? "" : ", ") + shown(each["name"]) + " = " + shown(each["value"]);
    if (!values.empty()) talk_.say(fmt::format("  {}: {}", text, values));
  }
  if (!assumed["held"].empty()) talk_.say("  held: " + shown(assumed["held"]));
}

void ConsoleScript::load() {
  fmt::print("{}", in_columns(files()));
  load_file(talk_.name("Script, or data file that names one: "));
}

/// Reads a text file from any folder that names script and points.
void ConsoleScript::import() {
  const std::string path = talk_.name("Path of the text file: ");
  const fs::path given = path;
  std::error_code error;
  if (!fs::exists(given, error) && !fs::exists(cell_.folder() / given, error))
    throw Error("no-file", "there is no file '" + path + "'");
  load_file(fs::exists(given, error) ? fs::absolute(given).string() : path);
}

// --- running ----------------------------------------------------------------------------------------------

void ConsoleScript::start_or_resume() {
  cell_.catch_up();
  Json now = state();
  if (now["state"] == "none") throw Error("no-script", "no script is loaded", "load one: 1");
  if (is_paused(now)) {
    cell_.ask({{"request", "program.go"}});
    return follow();
  }
  if (has_ended(now)) load_file(!file_.empty() ? file_ : now["file"].get<std::string>());
  if (is_one_of(now["state"], {"running", "waiting"})) return follow();
  const int passes =
      talk_.number("How many passes of its outermost while (Enter: no limit): ", 0, 1'000'000'000, 0);
  cell_.ask({{"request", "program.start"}, {"passes", passes}});
  follow();
}

void ConsoleScript::pause() {
  cell_.ask({{"request", "program.pause"}, {"at_once", true}});
  follow();
}

void ConsoleScript::step(const char* kind) {
  cell_.catch_up();
  const Json now = state();
  if (now["state"] == "none") throw Error("no-script", "no script is loaded", "load one: 1");
  if (has_ended(now)) load_file(!file_.empty() ? file_ : now["file"].get<std::string>());
  if (has_ended(now) || now["state"] == "ready") {
    cell_.ask({{"request", "program.start"}, {"paused", true}});
    return follow();
  }
  if (!is_paused(now)) return pause();
  cell_.ask({{"request", "program.step"}, {"how", kind}, {"at_once", true}});
  follow();
}

void ConsoleScript::stop() {
  Json now = cell_.ask({{"request", "program.stop"}});
  if (now["control"] == "held") {  // the rest of its motion is discarded too
    cell_.ask({{"request", "control.discard"}});
    cell_.ask({{"request", "control.resume"}});
  }
  for (int tries = 0; tries < 400 && !has_ended(now); ++tries, now = state())
    std::this_thread::sleep_for(milliseconds(5));
  report_end(now);
}

void ConsoleScript::run_from_line() {
  const Json now = state();
  const std::string file = !file_.empty() ? file_ : now["file"].get<std::string>();
  if (file.empty()) throw Error("no-script", "no script is loaded", "load one: 1");
  const int line = talk_.number("Line to begin at: ", 1, 1'000'000'000);
  if (has_ended(now) || now["state"] == "ready") load_file(file);  // with the present data
  report_assumed(cell_.ask({{"request", "program.from"}, {"program", file}, {"line", line}}));
  if (!talk_.yes("Is all of this true, and may the program start there?")) {
    stop();
    throw GivenUp{};
  }
  cell_.catch_up();
  cell_.ask({{"request", "program.go"}});
  follow();
}

void ConsoleScript::report_events_of_cell() {
  for (const Json& event : cell_.take_events()) {
    const std::string kind = event["event"];
    if (kind == "line" && event["task"] == "program")
      talk_.say(fmt::format("{:9.3f} {:>4} | {}", event["time_s"].get<double>(), shown(event["line"]),
                            shown(event["source"])));
    else if (kind == "log")
      talk_.say(fmt::format("{:9.3f}      | {}: {}", event["time_s"].get<double>(), shown(event["task"]),
                            shown(event["text"])));
    else if (kind == "tag")
      talk_.say(talk_.dim(fmt::format("{:9.3f}      |      {} = {}  ({})", event["time_s"].get<double>(),
                                      shown(event["name"]), shown(event["value"]), shown(event["by"]))));
    else if (kind == "problem")
      talk_.complain((shown(event["where"]).empty() ? "" : shown(event["where"]) + ": ") +
                     shown(event["what"]));
    else if (kind == "stop" || kind == "note")
      talk_.say(shown(event["text"]));
  }
}

void ConsoleScript::follow() {
  if (talk_.at_terminal())
    talk_.say(talk_.dim("Enter pauses before the next line; Ctrl-C stops on the path"));
  for (int asked = 0;;) {
    if (talk_.ended()) throw EndOfAnswers{};
    if (talk_.take_interrupt()) cell_.ask({{"request", ++asked > 1 ? "control.stop" : "control.hold"}});
    const Json now = state();
    report_events_of_cell();
    if (has_ended(now)) return report_end(now);
    if (now["control"] == "fault")
      throw Error("fault", "the cell is in a fault: " + shown(now["cause"]),
                  "polyarm control recover, polyarm health");
    if (now["control"] == "held") {
      if (const std::string why = cell_.catch_up(); !why.empty()) {
        talk_.say(talk_.dim("the simulation continued after " + why));
        continue;
      }
      talk_.say("the robot was stopped on its path: " + shown(now["cause"]));
      if (!decide_when_held()) return;
      asked = 0;
      continue;
    }
    if (is_paused(now)) {
      talk_.say(fmt::format("paused before line {}: {}", shown(now["where"]["line"]), shown(now["source"])));
      return;
    }
    if (!now["question"].is_null()) {
      answer(now["question"]);
      continue;
    }
    if (!talk_.at_terminal())
      std::this_thread::sleep_for(kLookAgain);
    else if (talk_.line_within(kLookAgain))
      cell_.ask({{"request", "program.pause"}, {"at_once", true}});
  }
}

void ConsoleScript::answer(const Json& question) {
  const std::string asks = shown(question);
  try {
    const std::string text =
        talk_.line((asks.empty() ? "The script waits for you; press Enter to continue" : asks) + ": ");
    cell_.ask({{"request", "program.answer"}, {"text", text}});
    while (!state()["question"].is_null()) std::this_thread::sleep_for(milliseconds(5));
  } catch (const GivenUp&) {
    cell_.ask({{"request", "control.hold"}});
  }
}

/// False: the script stays in its present state.
bool ConsoleScript::decide_when_held() {
  for (;;) {
    std::string answer;
    try {
      answer = talk_.line("1->Go On  2->Back Along The Path  3->Stay Held  0->End The Script\n> ");
    } catch (const GivenUp&) {
      continue;
    }
    try {
      if (answer == "1") {
        cell_.ask({{"request", "control.resume"}});
        for (int tries = 0; tries < 200 && state()["control"] == "held"; ++tries)
          std::this_thread::sleep_for(milliseconds(5));
        return true;
      }
      if (answer == "2") {
        cell_.ask({{"request", "control.back"}});
        continue;
      }
      if (answer == "3") return false;
      if (answer == "0") {
        stop();
        return false;
      }
      talk_.complain("'" + answer + "' is not an answer; 0 to 3");
    } catch (const Error& e) {
      if (!cell_.runs()) throw;
      talk_.complain(e);
    }
  }
}

void ConsoleScript::report_end(const Json& state) {
  report_events_of_cell();
  const std::string outcome = state["state"];
  if (outcome == "finished")
    talk_.say("the script has ended");
  else if (outcome == "stopped")
    talk_.say("the script was ended");
  else if (const Json& why = state["problem"]; why.is_object())
    talk_.complain(Error(
        Problem{shown(why["code"]), {shown(why["where"]), 0, 0}, shown(why["what"]), shown(why["advice"])}));
}

void ConsoleScript::show_state() {
  const Json now = cell_.ask({{"request", "program"}, {"data", true}});
  report_events_of_cell();
  talk_.say(fmt::format("{}: {}{}", now["state"] == "none" ? "no script" : file_name(now), state_word(now),
                        now["control"] == "running" ? "" : ", the cell is " + shown(now["control"])));
  if (now["state"] == "none") return;
  talk_.say(fmt::format("line {}: {}", shown(now["where"]["line"]), shown(now["sentence"])));
  for (const Json& task : now["tasks"])
    for (const Json& each : task["variables"])
      talk_.say(fmt::format("  {} = {}", shown(each["name"]), shown(each["value"])));
  for (const auto& [name, value] : now["data"].items())
    talk_.say(fmt::format("  {} = {}", name, shown(value)));
}

// --- the menu ---------------------------------------------------------------------------------------------

std::string ConsoleScript::heading() {
  const Json now = state();
  const std::string what =
      now["state"] == "none" ? "no script is loaded" : file_name(now) + ", " + state_word(now);
  return "Script Menu   " + what +
         (now["control"] == "running" ? "" : "; the cell is " + shown(now["control"]));
}

void ConsoleScript::run() {
  const auto entries = [this]() -> std::vector<MenuEntry> {
    return {
        {1, "Load Script Information From File", [this] { load(); }},
        {2, "Import Script Information From Text File", [this] { import(); }},
        {3, "Run Script", [this] { start_or_resume(); }},
        {4, "Pause Script", [this] { pause(); }},
        {5, "Step Script", [this] { step("into"); }},
        {6, "Step Over", [this] { step("over"); }},
        {7, "Run Script From Line", [this] { run_from_line(); }},
        {8, "End Script", [this] { stop(); }},
        {9, "Show State And Variables", [this] { show_state(); }},
    };
  };
  talk_.menu([this] { return heading(); }, entries, [this] { return !cell_.runs(); });
}

}  // namespace polyarm::apps
