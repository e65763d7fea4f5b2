#pragma once
/// A cell whose internals are accessible, for tests that step it and inspect it.
#include "polyarm/cell/cell.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/inside/view.hpp"

namespace polyarm::test {

class OpenCell : public cell::Cell {
 public:
  using cell::Cell::Cell;
  cell::CellInside& in() { return cell::inside_of(*this); }

  control::ControlLoop& loop() { return in().machine.loop(); }
  const control::Snapshot& snapshot() { return in().machine.snapshot(); }
  Nanoseconds now() { return in().machine.now(); }
  data::DataStore& store() { return in().data.store; }
  cell::DataFiles& files() { return in().data.files(); }
  const cell::CellRobots& robots() { return in().setup.robots; }
  const cell::CellFile& file() { return in().setup.file; }
  const ros_files::ManagerParameters& manager() { return in().setup.manager; }
  cell::Worker& worker() { return in().worker; }
  cell::Arming& arming() { return *in().arming; }
  cell::Jogging& jogging() { return *in().jogging; }
  cell::Programs& programs() { return *in().programs; }
  cell::Task* program() { return in().programs->program(); }
  cell::Task* plc() { return in().programs->plc(); }
  cell::Answers& answers() { return in().programs->answers(); }
  const std::optional<cell::Failure>& failure() { return in().life->failure(); }
  const std::optional<cell::RestartRequest>& restart() { return in().life->restart(); }
  bool finished() { return in().life->finished(); }
  const std::vector<cell::StopReport>& stops() { return in().watches->stops(); }
  const std::vector<Problem>& group_faults() { return in().watches->group_faults(); }
  const cell::JointPlaces& joint_places() { return in().machine.joint_places(); }
  const cell::EventLog& events() { return in().events; }
  const cell::MovingBase& base(std::size_t robot) { return in().motions->base(robot); }
  Pose tcp(std::size_t robot) { return in().motions->tcp(robot); }
  bool motion_left() { return in().motions->motion_left(); }
  Problem stop_cause() { return in().life->stop_cause(); }
  std::vector<Location> breakpoints() { return programs().breakpoints(); }
  std::vector<cell::FileBreakpoints> kept_breakpoints() { return programs().kept_breakpoints(); }
  program::StartReport continue_program() { return programs().continue_from_safe_point(); }
  void keep_safe_point() { programs().keep_safe_point(); }
  void unload_controller(const std::string& name) { in().unload_controller(name); }
  void set_profile(const std::string& name) { in().motions->set_profile(name); }
};

}  // namespace polyarm::test
