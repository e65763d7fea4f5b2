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

constexpr milliseconds kLook{50};

bool is_one_of(const Json& value, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* word) { return value == word; });
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

void ConsoleScript::load_file(const std::string& file, int line) {
  if (editor_.has_unsaved()) talk_.say("note: " + editor_.summary() + "; the script gets what is saved");
  Json request{{"request", "program.load"}, {"file", file}};
  if (line > 0) request["line"] = line;
  const Json loaded = cell_.ask(std::move(request));
  file_ = file;
  for (const Json& warning : loaded["warnings"]) talk_.say(shown(warning));
  talk_.say("loaded " + file_name(loaded));
  if (!loaded.contains("assumes")) return;
  const Json& assumes = loaded["assumes"];
  talk_.say(fmt::format("it will begin at line {}: {}", shown(loaded["line"]), shown(loaded["source"])));
  const std::pair<const char*, const char*> kTexts[] = {{"last_point", "the robot is as after the move to"},
                                                        {"robot", "robot"},
                                                        {"tool", "tool"},
                                                        {"frame", "frame"},
                                                        {"sets", "these were set before"},
                                                        {"reads", "these are read from there on"}};
  for (const auto& [key, text] : kTexts)
    if (!assumes[key].empty() && assumes[key] != "")
      talk_.say(fmt::format("  {}: {}", text, shown(assumes[key])));
}

void ConsoleScript::load() {
  fmt::print("{}", in_columns(files()));
  load_file(talk_.name("Script, or data file that names one: "));
}

/// A text file from anywhere, which names script and points.
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
  if (now["state"] == "paused") {
    cell_.ask({{"request", "program.resume"}});
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
  cell_.ask({{"request", "program.pause"}});
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
  if (now["state"] != "paused") return pause();
  cell_.ask({{"request", "program.step"}, {"kind", kind}});
  follow();
}

void ConsoleScript::stop() {
  Json now = cell_.ask({{"request", "program.stop"}});
  if (now["cell"] == "held") {  // the rest of its motion goes with it
    cell_.ask({{"request", "control.discard"}});
    cell_.ask({{"request", "control.resume"}});
  }
  for (int tries = 0; tries < 400 && !has_ended(now); ++tries, now = state())
    std::this_thread::sleep_for(milliseconds(5));
  tell_end(now);
}

void ConsoleScript::run_from_line() {
  const Json now = state();
  const std::string file = !file_.empty() ? file_ : now["file"].get<std::string>();
  if (file.empty()) throw Error("no-script", "no script is loaded", "load one: 1");
  load_file(file, talk_.number("Line to begin at: ", 1, 1'000'000'000));
  if (!talk_.yes("Is all of that so, and may it begin there?")) {
    load_file(file);
    throw GivenUp{};
  }
  cell_.catch_up();
  cell_.ask({{"request", "program.start"}});
  follow();
}

void ConsoleScript::tell_events() {
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
    talk_.say(talk_.dim("Enter pauses in front of the next line; Ctrl-C stops on the path"));
  for (int asked = 0;;) {
    if (talk_.ended()) throw EndOfAnswers{};
    if (talk_.take_interrupt()) cell_.ask({{"request", ++asked > 1 ? "control.stop" : "control.hold"}});
    const Json now = state();
    tell_events();
    if (has_ended(now)) return tell_end(now);
    if (now["cell"] == "fault")
      throw Error("fault", "the cell is in a fault: " + shown(now["cause"]),
                  "polyarm control recover, polyarm health");
    if (now["cell"] == "held") {
      if (const std::string why = cell_.catch_up(); !why.empty()) {
        talk_.say(talk_.dim("the simulation went on after " + why));
        continue;
      }
      talk_.say("the robot was stopped on its path: " + shown(now["cause"]));
      if (!decide_when_held()) return;
      asked = 0;
      continue;
    }
    if (now["state"] == "paused") {
      talk_.say(fmt::format("paused in front of line {}: {}", shown(now["line"]), shown(now["source"])));
      return;
    }
    if (!now["question"].is_null()) {
      answer(now["question"]);
      continue;
    }
    if (!talk_.at_terminal())
      std::this_thread::sleep_for(kLook);
    else if (talk_.line_within(kLook))
      cell_.ask({{"request", "program.pause"}});
  }
}

void ConsoleScript::answer(const Json& question) {
  const std::string asks = shown(question);
  try {
    const std::string text =
        talk_.line((asks.empty() ? "The script waits for you; Enter goes on" : asks) + ": ");
    cell_.ask({{"request", "program.answer"}, {"text", text}});
    while (!state()["question"].is_null()) std::this_thread::sleep_for(milliseconds(5));
  } catch (const GivenUp&) {
    cell_.ask({{"request", "control.hold"}});
  }
}

/// False: the script is left as it stands.
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
        for (int tries = 0; tries < 200 && state()["cell"] == "held"; ++tries)
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
      talk_.complain("'" + answer + "' is no answer; 0 to 3");
    } catch (const Error& e) {
      if (!cell_.runs()) throw;
      talk_.complain(e);
    }
  }
}

void ConsoleScript::tell_end(const Json& state) {
  tell_events();
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
  const Json now = cell_.ask({{"request", "program.state"}, {"variables", true}});
  tell_events();
  talk_.say(fmt::format("{}: {}{}", now["state"] == "none" ? "no script" : file_name(now),
                        shown(now["state"]),
                        now["cell"] == "running" ? "" : ", the cell is " + shown(now["cell"])));
  if (!now.contains("sentence")) return;
  talk_.say(fmt::format("line {}: {}", shown(now["line"]), shown(now["sentence"])));
  for (const char* which : {"variables", "data"})
    for (const auto& [name, value] : now[which].items())
      talk_.say(fmt::format("  {} = {}", name, shown(value)));
}

// --- the menu ---------------------------------------------------------------------------------------------

std::string ConsoleScript::heading() {
  const Json now = state();
  const std::string what =
      now["state"] == "none" ? "no script is loaded" : file_name(now) + ", " + shown(now["state"]);
  return "Script Menu   " + what + (now["cell"] == "running" ? "" : "; the cell is " + shown(now["cell"]));
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
