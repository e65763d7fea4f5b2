#pragma once
/// Monitors a running cell: stops, contacts and faults; decides when the run ends.
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "polyarm/io/parts.hpp"
#include "polyarm/machine/contact_watch.hpp"
#include "polyarm/machine/fault_record.hpp"
#include "polyarm/machine/stops.hpp"
#include "polyarm/operation/jogging.hpp"
#include "polyarm/operation/torque_watch.hpp"
#include "polyarm/tasks/programs.hpp"

namespace polyarm::cell {

/// Life cycle of a run: its failure, its end, and a request to rebuild the cell. Cell thread.
class LifeCycle {
 public:
  LifeCycle(Machine& machine, Motions& motions, Observer& observer)
      : machine_(machine), motions_(motions), observer_(observer) {}
  /// Reports the problem and stops the cell. The first failure counts.
  void fail(Problem problem);
  const std::optional<Failure>& failure() const { return failure_; }
  /// Why the cell does not run: the cause of the loop's stop, or the cell's own reason (link-lost,
  /// link-stale, heartbeat, program-hold, connected, run-failed). `code` is one of control::code or one of
  /// these.
  Problem stop_cause() const;
  /// True when program and PLC have ended, and every part has come to rest or has had 2 s to do so.
  bool finished() const { return finished_; }
  void set_finished(bool finished) { finished_ = finished; }
  /// Requests that the runner ends this run and rebuilds the cell.
  void request_restart(RestartRequest wish) { restart_ = std::move(wish); }
  const std::optional<RestartRequest>& restart() const { return restart_; }

 private:
  Machine& machine_;
  Motions& motions_;
  Observer& observer_;
  std::optional<Failure> failure_;
  bool finished_ = false;
  std::optional<RestartRequest> restart_;
};

/// True if faults and stops of this run are recovered externally, by people or programs.
bool recovered_by_others(const CellSetup& setup, const Programs& programs);

/// Cell thread.
class Watches {
 public:
  struct Owners {
    const CellSetup& setup;
    Machine& machine;
    CellData& data;
    Motions& motions;
    Programs& programs;
    Jogging& jogging;
    const Arming& arming;
    LifeCycle& life;
    ContactWatch& contacts;
    PartTracker& parts;
    Worker& worker;
    Observer& observer;
  };
  explicit Watches(const Owners& cell) : cell_(cell) {}

  // Call each of these once per tick.
  /// Call before moves that a contact ended are removed.
  void watch_contacts();
  bool is_meant(const ContactReport& contact) const;
  /// Stops the robots when a motor exerts more torque than `collision_torque` allows.
  void watch_torques();
  void watch_stops();
  /// `missing`: why the cell may not run now. Holds the cell while it is set; a resume meanwhile is held
  /// again.
  void hold_if_missing(const std::optional<Problem>& missing);
  /// Reports faults; decides whether the run continues and whether it has ended.
  void watch_faults_and_end();
  /// Notes that the start messages of the cell file were sent.
  void note_start_messages() { started_ = true; }

  /// Duration of this run's stops, oldest first; at most the newest thousand.
  const std::vector<StopReport>& stops() const { return stops_; }
  StopWatch& stop_watch() { return stop_watch_; }
  const HeldPlace& held_place() const { return held_place_; }
  /// Takes the present positions as the start of the next motion; displacement while held no longer counts.
  void forget_pushes() { held_place_.forget(); }
  /// Faults that stopped one robot while the others continued.
  const std::vector<Problem>& group_faults() const { return group_faults_; }
  int contacts_max() const { return contacts_max_; }
  double tracking_error_max() const { return tracking_error_max_; }
  /// Begins a fault record for this problem, including the latest stop if the problem caused it.
  FaultRecord begin_record(const Problem& problem) const;

 private:
  void find_cause(ContactReport& contact) const;
  int robot_in(const ContactReport& contact) const;
  Problem problem_of(const ContactReport& contact) const;
  void add_component(std::size_t component, Facts& facts) const;
  std::string blame(Facts& facts) const;
  /// The deepest present contact, if it can explain a fault with this cause; empty without a contact.
  std::string contact_behind(control::StopCause cause) const;
  void watch_fault();
  void watch_groups();
  void report_group_fault(std::size_t component);
  void watch_for_deadlock();
  void watch_end();
  void watch_failed_tasks();
  bool is_stuck(const Task* task) const;
  bool is_quiet() const;
  std::string hint_of_wait() const;
  void warn_of_long_wait();
  void warn_of_busy_tasks();
  void fail_for_deadlock();
  bool recovered_by_others() const { return cell::recovered_by_others(cell_.setup, cell_.programs); }

  Owners cell_;
  std::optional<TorqueWatch> torques_;  ///< made in the first tick
  bool torques_ran_ = true;             // the cell was running in the tick before
  StopWatch stop_watch_;
  HeldPlace held_place_;
  std::vector<StopReport> stops_;
  FaultRecorder recorder_;
  std::vector<control::StopCause> failed_seen_;  // by component
  std::vector<Problem> group_faults_;
  bool in_fault_ = false, started_ = false;
  int contacts_max_ = 0;
  double tracking_error_max_ = 0;
  std::uint64_t quiet_version_ = 0, starts_seen_ = 0;
  Nanoseconds quiet_since_ = 0, ended_at_ = -1;
  std::set<std::string> reported_warnings_, reported_ended_;
};

}  // namespace polyarm::cell
