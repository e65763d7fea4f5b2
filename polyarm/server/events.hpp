#pragma once
/// Changes in a cell as JSON events. Cell thread.
#include <functional>
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

/// States, modes, program and alarms; not which client has control.
protocol::CellStatus status_of(cell::CellView& cell, const Journal& journal);

/// Tags and variables, except those that are places.
class TagEvents {
 public:
  explicit TagEvents(cell::CellView& cell) : cell_(cell) {}
  /// The values that changed since the last call; null: none. `look`: compare all of them, because forcing a
  /// tag or a link's quality does not change the version of the values.
  Text changes(bool look);
  /// All values.
  Text full();
  /// True if a point or a group was added, removed or changed; changes() detects it.
  bool places_changed() const { return places_; }
  void take_places_changed() { places_ = false; }

 private:
  nlohmann::json value_of(const std::string& name) const;

  cell::CellView& cell_;
  std::map<std::string, nlohmann::json> announced_;
  std::uint64_t version_ = ~0ull, groups_version_ = 0;
  bool places_ = false;
};

/// Poses of parts: {"event": "parts", "parts": [{name, p, q, in_world, taken, held_by}], "full"}.
class PartEvents {
 public:
  explicit PartEvents(cell::CellView& cell) : cell_(cell) {}
  Text changes();
  Text full();

 private:
  Text tell(bool full);
  cell::CellView& cell_;
  std::vector<hardware::PartState> announced_;
};

/// Planned paths of robots: {"event": "plan", "plans": {ROBOT: {path: [[x, y, z]], clear: [m], target:
/// {joints}}}}. `clear`: for each place of the path, how far the robot is from everything else; missing until
/// it is known. The path is the TCP in world coordinates (m). The target is the end of the current move,
/// which may be one of several along the path. Robots without a planned move are left out.
class PlanEvents {
 public:
  explicit PlanEvents(cell::CellView& cell) : cell_(cell) {}
  /// Null: no change since the last call.
  Text changes();
  /// All paths; null: no robot moves.
  Text full();

 private:
  struct Way {
    std::uint64_t goal = 0;
    std::size_t move = 0;  ///< index of the current move in the path
    nlohmann::json told;
    /// The distances along the path are measured bit by bit: those of places that are not known yet are
    /// missing.
    std::vector<double> clear;
    std::size_t places = 0;
  };
  /// True if there are new distances.
  bool measure(std::size_t robot, Way& way) const;
  void look(std::size_t robot, Way& way) const;
  Text tell() const;

  cell::CellView& cell_;
  std::vector<Way> ways_;  ///< by robot
};

/// What is nearest to robots that move: {"event": "near", "robots": {ROBOT: {a, b, distance, kept, on_a,
/// on_b, pace}}} (m, world). Robots with nothing near them, or without a guard, are left out.
class NearEvents {
 public:
  explicit NearEvents(cell::CellView& cell) : cell_(cell) {}
  /// Null: no change since the last call.
  Text changes();
  /// The last event; null: none yet.
  Text full() const { return told_.empty() ? nullptr : std::make_shared<const std::string>(told_); }

 private:
  cell::CellView& cell_;
  std::string told_;
};

/// State of the program: {"event": "program", …} with what the request `program.watch` answers.
class ProgramEvents {
 public:
  explicit ProgramEvents(cell::CellView& cell) : cell_(cell) {}
  /// The latest state at `now` (s); null: unchanged. Subscribes to `program.watch` when there is a program;
  /// if the request is refused, tries again after one second.
  Text changes(double now);
  /// The last state that was sent; null: none yet.
  Text full() const { return announced_->text; }

 private:
  void watch();

  /// The last answer. The subscription ends when this is destroyed.
  struct Told {
    Text text;
    bool fresh = false, on = false;
  };
  cell::CellView& cell_;
  double asked_ = 0;
  std::shared_ptr<Told> announced_ = std::make_shared<Told>();
};

/// Log lines after number `after`, as {"event": "log"}; null if there are none.
Text log_event(const Journal& journal, std::uint64_t after);
/// {"event": "alarm", number, time, code, what, where: {file, line, column}, advice, facts, severity}
Text alarm_event(const Journal::Alarm& alarm);

/// All events of one running cell, each at its own rate. It lives as long as the cell is attached.
class CellEvents {
 public:
  explicit CellEvents(cell::CellView& cell);
  /// Gets an event for all clients, and what makes the full event for clients that missed one; empty: nothing
  /// does.
  using Broadcast = std::function<void(Kind, const Text&, const std::function<Text()>& whole)>;
  /// Sends the changes that are due at `now`, s.
  void report(double now, const Broadcast& broadcast);
  /// Sends the full state to a new client.
  void greet(const std::function<void(Kind, const Text&)>& put);

 private:
  TagEvents tags_;
  PartEvents parts_;
  PlanEvents plans_;
  NearEvents near_;
  ProgramEvents program_;
  double sent_tags_ = 0, looked_ = 0, sent_points_ = 0, sent_parts_ = 0, sent_plans_ = 0, sent_near_ = 0;
};

/// Whether `every` (s) have passed since `last`, which becomes `now` then.
bool is_due(double& last, double every, double now);

}  // namespace polyarm::server
