#pragma once
/// The script menu of the console: load, run, pause, step, end.
#include <optional>
#include <string>
#include <vector>

#include "apps/console_cell.hpp"
#include "apps/console_editor.hpp"
#include "apps/dialogue.hpp"

namespace polyarm::apps {

class ConsoleScript {
 public:
  ConsoleScript(Dialogue& talk, ConsoleCell& cell, ConsoleEditor& editor)
      : talk_(talk), cell_(cell), editor_(editor) {}
  void run();

 private:
  void load();
  void import();
  void load_file(const std::string& file);
  void report_assumed(const Json& assumed);
  void start_or_resume();
  void pause();
  void step(const char* kind);
  void stop();
  void run_from_line();
  void show_state();
  Json state() { return cell_.ask({{"request", "program"}}); }
  /// Shows events until the script ends or pauses. While it runs, Enter pauses it and Ctrl-C stops the robot
  /// on its path.
  void follow();
  bool decide_when_held();
  void answer(const Json& question);
  void report_events_of_cell();
  void report_end(const Json& state);
  std::string heading();
  std::vector<std::string> files() const;

  Dialogue& talk_;
  ConsoleCell& cell_;
  ConsoleEditor& editor_;
  std::string file_;
};

}  // namespace polyarm::apps
