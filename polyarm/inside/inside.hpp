#pragma once
/// The internal state of a cell: its owner objects, each with its own state, in construction order. The
/// runner and the request handlers work on these objects; all others have const access through the cell.
#include <memory>
#include <optional>

#include "polyarm/inside/requests.hpp"
#include "polyarm/io/parts.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/machine/arming.hpp"
#include "polyarm/machine/cell_data.hpp"
#include "polyarm/machine/contact_watch.hpp"
#include "polyarm/machine/event_log.hpp"
#include "polyarm/machine/machine.hpp"
#include "polyarm/machine/motions.hpp"
#include "polyarm/operation/guards.hpp"
#include "polyarm/operation/held_motions.hpp"
#include "polyarm/operation/jogging.hpp"
#include "polyarm/operation/profile_choice.hpp"
#include "polyarm/operation/teleoperation.hpp"
#include "polyarm/operation/watches.hpp"
#include "polyarm/setup/cell_setup.hpp"
#include "polyarm/setup/recorder.hpp"
#include "polyarm/tasks/programs.hpp"

namespace polyarm::cell {

class TestTask;

/// Threads: construct on any one thread; call tick() on the cell thread.
struct CellInside {
  /// `handlers`: all requests that the cell answers. Throws Error that lists all problems found in the files.
  CellInside(const CellFile& file, const description::Catalogue& catalogue, CellOptions options,
             Observer& observer, const std::vector<Handler>& handlers);
  ~CellInside();
  CellInside(const CellInside&) = delete;
  CellInside& operator=(const CellInside&) = delete;

  void tick(Nanoseconds now);
  /// Call when a person has armed the cell: programs and messages may start.
  void set_armed();
  /// Removes an inactive controller. Throws Error if the cell itself uses it.
  void unload_controller(const std::string& name);
  bool outputs_settled() const { return data.outputs_settled(machine.now()); }

  /// The owner object of this type, for request handlers.
  template <class Owner>
  Owner& owner();

  CellSetup setup;
  Observers observers;
  EventLog events{observers};
  Machine machine;
  Worker worker, planner;  ///< for jobs longer than a tick; in lock-step they run immediately
  LongWorker long_worker;
  CellData data;
  ContactWatch contacts;
  std::optional<Arming> arming;
  std::optional<Motions> motions;
  std::optional<Programs> programs;
  std::unique_ptr<TestTask> test;  ///< null if no test runs
  std::optional<PartTracker> parts;
  std::optional<Jogging> jogging;
  std::optional<HeldMotions> held_motions;
  std::optional<Teleoperation> teleoperation;
  std::optional<ProfileChoice> profile_choice;
  std::optional<LifeCycle> life;
  std::optional<Watches> watches;
  std::optional<Guards> guards;
  Requests requests;
  std::unique_ptr<Recorder> recorder;  ///< null if the cell cannot record

 private:
  void make_owners();
  void make_controllers(const ros_files::ControllersFile& described, Problems& problems);
  void force_faults(Problems& problems);
  void make_programs(Problems& problems);
  void send_start_messages();
  void read_outside(Nanoseconds now);
  void run_programs();
  void tick_motions();
  OwnStates own_states() const;
  bool programs_over() const;

  bool started_ = false;
};

template <class Owner>
Owner& CellInside::owner() {
  using O = std::remove_const_t<Owner>;
  if constexpr (std::is_same_v<O, CellInside>)
    return *this;
  else if constexpr (std::is_same_v<O, CellSetup>)
    return setup;
  else if constexpr (std::is_same_v<O, EventLog> || std::is_same_v<O, Observer>)
    return events;
  else if constexpr (std::is_same_v<O, Machine>)
    return machine;
  else if constexpr (std::is_same_v<O, Worker>)
    return worker;
  else if constexpr (std::is_same_v<O, LongWorker>)
    return long_worker;
  else if constexpr (std::is_same_v<O, CellData>)
    return data;
  else if constexpr (std::is_same_v<O, ContactWatch>)
    return contacts;
  else if constexpr (std::is_same_v<O, Arming>)
    return *arming;
  else if constexpr (std::is_same_v<O, Motions>)
    return *motions;
  else if constexpr (std::is_same_v<O, Programs>)
    return *programs;
  else if constexpr (std::is_same_v<O, Jogging>)
    return *jogging;
  else if constexpr (std::is_same_v<O, HeldMotions>)
    return *held_motions;
  else if constexpr (std::is_same_v<O, Teleoperation>)
    return *teleoperation;
  else if constexpr (std::is_same_v<O, LifeCycle>)
    return *life;
  else if constexpr (std::is_same_v<O, Watches>)
    return *watches;
  else if constexpr (std::is_same_v<O, Guards>)
    return *guards;
  else
    return recorder;
}

}  // namespace polyarm::cell
