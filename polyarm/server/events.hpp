#pragma once
/// What changes in a cell, told as JSON events. Cell thread.
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/inside/view.hpp"
#include "polyarm/protocol/status.hpp"
#include "polyarm/server/client.hpp"
#include "polyarm/server/journal.hpp"

namespace polyarm::server {

/// State in words, modes, program, alarms; without who has control.
protocol::CellStatus status_of(cell::CellView& cell, const Journal& journal);

/// Tags and variables that are no places.
class TagEvents {
 public:
  explicit TagEvents(cell::CellView& cell) : cell_(cell) {}
  /// What has changed since the last call; null: nothing. `look`: at all of them, since forces and links
  /// change without a value that does.
  Text changes(bool look);
  /// All of them.
  Text full();
  /// Has a point come, gone or changed, or a group? changes() sees it.
  bool places_changed() const { return places_; }
  void take_places_changed() { places_ = false; }

 private:
  nlohmann::json value_of(const std::string& name) const;

  cell::CellView& cell_;
  std::map<std::string, nlohmann::json> told_;
  std::uint64_t version_ = ~0ull, groups_version_ = 0;
  bool places_ = false;
};

/// Where parts are: {"event": "parts", "parts": [{name, p, q, in_world, held_by}], "full"}.
class PartEvents {
 public:
  explicit PartEvents(cell::CellView& cell) : cell_(cell) {}
  Text changes();
  Text full();

 private:
  Text tell(bool full);
  cell::CellView& cell_;
  std::vector<hardware::PartState> told_;
};

/// The ways that robots are on: {"event": "plan", "plans": {ROBOT: {path: [[x, y, z]], target: {joints}}}},
/// places of the TCP in the world; a robot that no planned move moves is not among them. The target is where
/// the move under way ends, of all that the path is made of.
class PlanEvents {
 public:
  explicit PlanEvents(cell::CellView& cell) : cell_(cell) {}
  /// Null: nothing has changed since the last call.
  Text changes();
  /// All there is; null: nobody moves.
  Text full();

 private:
  struct Way {
    std::uint64_t goal = 0;
    std::size_t move = 0;  ///< that is under way, of the path's
    nlohmann::json told;
  };
  void look(std::size_t robot, Way& way) const;
  Text tell() const;

  cell::CellView& cell_;
  std::vector<Way> ways_;  ///< by robot
};

/// Where the program stands: {"event": "program", …} with what the request `program.watch` answers.
class ProgramEvents {
 public:
  explicit ProgramEvents(cell::CellView& cell) : cell_(cell) {}
  /// What is new at `now`, s; null: nothing. Has the cell tell it once there is a program; where that is
  /// refused, again a second later.
  Text changes(double now);
  /// What was told last; null: nothing yet.
  Text full() const { return told_->text; }

 private:
  void watch();

  /// What the answers come to, as long as it lives.
  struct Told {
    Text text;
    bool fresh = false, on = false;
  };
  cell::CellView& cell_;
  double asked_ = 0;
  std::shared_ptr<Told> told_ = std::make_shared<Told>();
};

/// Lines after number `after`, {"event": "log"}; null: none.
Text log_event(const Journal& journal, std::uint64_t after);
/// {"event": "alarm", number, time, code, what, where: {file, line, column}, why, advice, severity}
Text alarm_event(const Journal::Alarm& alarm);

}  // namespace polyarm::server
