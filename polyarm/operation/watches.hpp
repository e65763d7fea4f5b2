#pragma once
/// What goes wrong in a cell while it runs: stops, contacts, faults; and when it ends.
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
#include "polyarm/tasks/programs.hpp"

namespace polyarm::cell {

/// Whether the cell goes on: its failure, its end, and the wish to build it anew. Cell thread.
class LifeCycle {
 public:
  LifeCycle(Machine& machine, Motions& motions, Observer& observer)
      : machine_(machine), motions_(motions), observer_(observer) {}
  /// Reports it, and stops the cell; the first failure counts.
  void fail(Problem problem);
  const std::optional<Failure>& failure() const { return failure_; }
  /// Why the cell does not run: the cause of the loop's stop; if the cell itself asked for it, what it asked
  /// for (link-lost, link-stale, heartbeat, program-hold, connected, run-failed). `code` is as control::code
  /// or one of these.
  Problem stop_cause() const;
  /// Program and PLC have ended, and every part has come to rest or has had 2 s to.
  bool finished() const { return finished_; }
  void set_finished(bool finished) { finished_ = finished; }
  /// A wish to build the cell anew: the one who runs it ends it and does so.
  void ask_restart(RestartWish wish) { restart_ = std::move(wish); }
  const std::optional<RestartWish>& restart() const { return restart_; }

 private:
  Machine& machine_;
  Motions& motions_;
  Observer& observer_;
  std::optional<Failure> failure_;
  bool finished_ = false;
  std::optional<RestartWish> restart_;
};

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

  // Once each tick.
  /// Before moves that a contact ended are forgotten.
  void watch_contacts();
  void watch_stops();
  /// `missing`: why the cell may not run now. What works then is held; who resumes it meanwhile is held
  /// again.
  void hold_if_missing(const std::optional<Problem>& missing);
  /// Faults, and whether the cell can go on and has ended.
  void watch_faults_and_end();
  /// Messages that the cell file sends were sent.
  void note_start_messages() { started_ = true; }

  /// What the stops of this run took, oldest first; at most the newest thousand.
  const std::vector<StopReport>& stops() const { return stops_; }
  StopWatch& stop_watch() { return stop_watch_; }
  const HeldPlace& held_place() const { return held_place_; }
  /// Where the robots are now is where the next motion begins: what moved them while held counts no more.
  void forget_pushes() { held_place_.forget(); }
  /// Faults that stopped one robot while the rest went on.
  const std::vector<Problem>& group_faults() const { return group_faults_; }
  int contacts_max() const { return contacts_max_; }
  double tracking_error_max() const { return tracking_error_max_; }
  /// A record of this problem, with what the latest stop took where the problem led to it.
  FaultRecord begin_record(const Problem& problem) const;

 private:
  void find_cause(ContactReport& contact) const;
  int robot_in(const ContactReport& contact) const;
  Problem problem_of(const ContactReport& contact) const;
  void add_component(std::size_t component, Facts& facts) const;
  std::string blame(Facts& facts) const;
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
  /// After a fault the cell is brought back by people and programs outside.
  bool recovered_by_others() const;

  Owners cell_;
  StopWatch stop_watch_;
  HeldPlace held_place_;
  std::vector<StopReport> stops_;
  FaultRecorder recorder_;
  std::vector<control::StopCause> fallen_seen_;  // by component
  std::vector<Problem> group_faults_;
  bool in_fault_ = false, started_ = false;
  int contacts_max_ = 0;
  double tracking_error_max_ = 0;
  std::uint64_t quiet_version_ = 0, starts_seen_ = 0;
  Nanoseconds quiet_since_ = 0, ended_at_ = -1;
  std::set<std::string> reported_warnings_, reported_ended_;
};

}  // namespace polyarm::cell
