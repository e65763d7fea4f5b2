#pragma once
/// The move menu of the console, as described in the thesis.
#include <optional>
#include <string>
#include <vector>

#include "apps/console_cell.hpp"
#include "apps/console_editor.hpp"
#include "apps/dialogue.hpp"

namespace polyarm::apps {

class ConsoleMove {
 public:
  ConsoleMove(Dialogue& talk, ConsoleCell& cell, ConsoleEditor& editor)
      : talk_(talk), cell_(cell), editor_(editor) {}
  void run();

 private:
  enum class From { joints, pose, file, list };

  void sliders();
  void jog(bool tcp);
  void jog_by_lines(bool tcp);
  void move_one(From from);
  void move_many(From from);
  void move_mixed();
  void change_method();
  void change_scale();
  std::vector<MenuEntry> entries();
  /// Asks for a point, in the form of the request `move`.
  Json ask_point(From from, const std::string& called);
  std::vector<Json> ask_file_points();
  void ask_duration(Json& point);
  void go(const std::vector<Json>& points);
  void follow(int id);
  bool decide_when_held();
  void require_running();

  Dialogue& talk_;
  ConsoleCell& cell_;
  ConsoleEditor& editor_;
  bool manual_ = false;  ///< ask for the duration of each move
  double scale_ = 1;     ///< otherwise: s per rad of joint motion
};

/// Joint sliders in the terminal; returns when the user ends them. Throws Error("no-terminal").
void joint_sliders(ConsoleCell& cell);

}  // namespace polyarm::apps
