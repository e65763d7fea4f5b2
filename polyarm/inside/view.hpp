#pragma once
/// The view of a cell that doors get: read access to its state, and its requests as the only way to change
/// it.
#include <optional>
#include <span>
#include <string>

#include "polyarm/control/control_loop.hpp"
#include "polyarm/inside/requests.hpp"
#include "polyarm/io/links.hpp"
#include "polyarm/jog/jog_controller.hpp"
#include "polyarm/machine/arming.hpp"
#include "polyarm/machine/around.hpp"
#include "polyarm/machine/event_log.hpp"
#include "polyarm/moves/robot_motion.hpp"
#include "polyarm/operation/guards.hpp"
#include "polyarm/protocol/motion.hpp"
#include "polyarm/protocol/programs.hpp"
#include "polyarm/setup/cell_options.hpp"
#include "polyarm/setup/cell_setup.hpp"
#include "polyarm/setup/moving_base.hpp"
#include "polyarm/tasks/task.hpp"

namespace polyarm::cell {

struct CellInside;
class HeldMotions;

/// Cell thread.
class CellView {
 public:
  explicit CellView(CellInside& inside) : inside_(inside) {}

  Requests& requests();
  /// Motion while a key is held down.
  HeldMotions& held_motions();
  /// Reports to all observers and stores the event in the log.
  Observer& observer();
  void tell(const std::string& note) { observer().on_note(note); }
  void add_observer(Observer& observer);
  void remove_observer(Observer& observer);
  void request_restart(RestartRequest wish);

  // Configuration.
  const CellFile& file() const;
  const CellRobots& robots() const;
  const description::Scene& scene() const;
  const ros_files::ManagerParameters& manager() const;
  const signals::Signals& signals() const;
  bool lock_step() const;
  Nanoseconds period() const;

  // Current state.
  Nanoseconds now() const;
  const control::Snapshot& snapshot() const;
  const hardware::InterfaceTable& table() const;
  const control::ControllerManager& controllers() const;
  const hardware::Hardware& hardware() const;
  const control::Supervisor& supervisor() const;
  const control::Health& health() const;
  std::uint64_t clamps() const;
  /// Creates a tap with room for `rows` cycles; it records one of `every` cycles.
  std::unique_ptr<control::CycleTap> make_tap(std::size_t rows, unsigned every) const;
  /// Records into `tap` from the next cycle on; null: stops recording. The previous tap must live until the
  /// returned job is done.
  std::shared_ptr<realtime::Job> tap(control::CycleTap* tap) const;
  const data::DataStore& store() const;
  const CellLinks& links() const;
  const EventLog& events() const;
  const Arming& arming() const;
  const std::optional<Failure>& failure() const;
  /// Why the cell does not run. The code is one of control::code, or the cell's own reason.
  Problem stop_cause() const;
  const Task* program() const;
  const Task* plc() const;
  bool program_begun() const;
  protocol::ProgramStatus program_status() const;
  protocol::OrNull<protocol::ProgramOverview> program_overview() const;
  protocol::OrNull<protocol::ProgramOverview> plc_overview() const;
  protocol::ContactState contacts() const;
  protocol::PossibleNow possible_now() const;

  // Robots, by index.
  const moves::RobotMotion* motion(std::size_t robot) const;
  /// What the guard of a robot sees (Guards): the nearest body, the pace of a planned move, and the distance
  /// from everything else with the joints at `q`.
  std::optional<Guards::Near> near(std::size_t robot) const;
  double pace(std::size_t robot) const;
  /// Things that guards keep robots off in addition to the scene, and things that robots hold
  /// (Guards::set_more).
  void set_more_obstacles(std::vector<description::Fixture> more,
                          std::vector<surroundings::AttachedThing> attached = {});
  std::optional<double> clearance_at(std::size_t robot, std::span<const double> q) const;
  const MovingBase& base(std::size_t robot) const;
  /// Where everything is now, for plans around obstacles: joints as commanded.
  surroundings::Moment moment() const;
  /// Robots and scene as contacts see them. Its get() may read the disk: not on the cell thread.
  std::shared_ptr<SharedBodies> bodies() const;
  /// The speed limits of planned moves.
  moves::MovePlanOptions plan_options() const;
  Pose tcp(std::size_t robot) const;
  bool motion_left() const;
  bool jogged(std::size_t robot) const;
  /// Who moves the robots: "program", "jog" or "nobody".
  const char* control_holder() const;
  const std::string& profile() const;

 private:
  CellInside& inside_;
};

}  // namespace polyarm::cell
