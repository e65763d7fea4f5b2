#pragma once
/// A running cell: built from its files, stepped by whoever runs it. The front door of the library.
#include <array>
#include <atomic>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/cell/arming.hpp"
#include "polyarm/cell/breakpoints.hpp"
#include "polyarm/cell/camera.hpp"
#include "polyarm/cell/cell_file.hpp"
#include "polyarm/cell/contact_watch.hpp"
#include "polyarm/cell/data_files.hpp"
#include "polyarm/cell/event_log.hpp"
#include "polyarm/cell/fault_record.hpp"
#include "polyarm/cell/hardware_calls.hpp"
#include "polyarm/cell/heartbeats.hpp"
#include "polyarm/cell/jogging.hpp"
#include "polyarm/cell/links.hpp"
#include "polyarm/cell/moving_base.hpp"
#include "polyarm/cell/observer.hpp"
#include "polyarm/cell/parts.hpp"
#include "polyarm/cell/recorder.hpp"
#include "polyarm/cell/requests.hpp"
#include "polyarm/cell/robots.hpp"
#include "polyarm/cell/safe_points.hpp"
#include "polyarm/cell/stops.hpp"
#include "polyarm/cell/tag_binding.hpp"
#include "polyarm/cell/task.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/program/parser.hpp"
#include "polyarm/ros_files/controllers_file.hpp"

namespace polyarm::cell {

class TestTask;

/// What somebody wants a cell to be built anew with; empty: as it is.
struct RestartWish {
  std::string robot, hardware, program, cell;
  std::optional<bool> real{};  ///< on its real hardware, or simulated
};

/// A test of a file of tests, by its place among them.
struct TestEntry {
  std::filesystem::path file;
  std::size_t index = 0;
};

struct CellOptions {
  bool lock_step = false;   ///< one thread, files inline, the cell cannot fall silent
  bool links = false;       ///< lock-step: links to the outside are connected all the same
  bool keep = false;        ///< go on from what the last run left in .state/
  bool real = false;        ///< real hardware is driven, after somebody has armed it
  bool full_speed = false;  ///< real hardware moves as fast as it may from the first pass on
  /// Callbacks of hardware that have not come back so long after the end are left behind, ns.
  Nanoseconds hardware_patience = 5'000'000'000;
  /// While hardware starts: whether a person has asked to end it. Then what has not come back is left behind.
  std::function<bool()> start_given_up;
  bool allow_contact = false;   ///< contacts are reported and do not end the run
  bool contact_errors = false;  ///< with that: they are reported as errors, not as warnings
  /// The program begins when somebody asks for it, and the cell goes on when it has ended.
  bool waits = false;
  bool no_code = false;                  ///< plugins that the cell brings are not loaded, approved or not
  std::uint64_t cycles = 0;              ///< passes of the program's outermost while; 0: as many as it likes
  std::map<std::string, double> faults;  ///< interface name → value forced upon it
  std::vector<std::string> answers;      ///< to `wait user`, in order
  std::optional<TestEntry> test;         ///< stands beside the program, which begins when it says so
  std::vector<FileBreakpoints>
      breakpoints;                     ///< as those of a cell before it were, files by their whole paths
  std::filesystem::path state_folder;  ///< where data files are kept; empty: .state/data of the cell
  program::ReadPrograms read;          ///< scripts that have been read already
};

/// A component on its way from the files. Read it when it is done.
struct Remaking {
  std::atomic<bool> done{false};
  std::string name;
  mutable Remade made;  ///< its parts are taken by who begins the reload
  std::exception_ptr failed;
};

/// Why a cell cannot go on by itself.
struct Failure {
  Problem problem;
  Nanoseconds time = 0;
};

/// Everything a cell owns. Building: any one thread. tick(): the cell thread; the loop's step: the control
/// thread (the same one in lock-step). Addresses are stable: it is neither copied nor moved.
class Cell {
 public:
  /// Nanoseconds of cell time between ticks.
  static constexpr Nanoseconds kTick = 2'000'000;

  /// Throws Error with everything that is wrong in any file.
  Cell(const CellFile& file, const description::Catalogue& catalogue, CellOptions options,
       Observer& observer);
  ~Cell();
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;

  control::ControlLoop& loop() { return *loop_; }
  /// One tick at cell time `now` on the newest snapshot.
  void tick(Nanoseconds now);

  /// The program's task; null when the cell has no program.
  Task* program() { return program_.get(); }
  const Task* program() const { return program_.get(); }
  Task* plc() { return plc_.get(); }
  /// The moves of the program; null without one.
  ProgramMoves* program_moves() { return moves_.get(); }
  TestTask* test() { return test_.get(); }
  /// Begins the program `name` (a script or a script-information file; empty: the cell's own), read anew from
  /// its files. Throws Error while another one runs or robots move, and with what is wrong with it.
  void begin_program(const std::string& name, const Location& where);
  /// The same, and it stands paused in front of `line` of its file (0: of its first statement), whatever ran
  /// before.
  program::StartReport prepare_program(const std::string& name, int line);
  /// Puts this program in the place of the one there is, which has not begun or has ended; the cell goes on
  /// when it ends. It begins when let_begin() says so. Throws Error where nothing can be moved.
  void put_program(program::Program program);
  void let_begin() { begun_ = true; }
  bool program_begun() const { return begun_; }
  /// Is the program under way, so that nobody else may move? While it is paused and all stands, it is not.
  bool program_runs() const;
  /// Of what the program waits for a name that nobody in the cell sets and that comes from a file of which
  /// the run has a copy: how others come to set it. Empty where there is none.
  std::string hint_of_live() const;
  /// The line under way, for whoever blames or tells something: of the program's move that `robot` (its
  /// index; none: any) is in, else of the statement that the program is in. Empty where no program is under
  /// way, or a person jogs.
  Location line_under_way(std::optional<std::size_t> robot = {}) const;
  /// Ends the program where it is: its moves end on their paths. What it does on stop is still done.
  void end_program();
  /// Where programs pause: in the one there is, and in others of the cell's folder once they are begun.
  std::vector<Location> breakpoints() const;
  /// The same with the texts that they are lines of, for the cell after this one.
  std::vector<FileBreakpoints> kept_breakpoints() const;
  /// At a line of `text`, or where none is told of what the program has read. It moves down to the next
  /// statement, in a program with an older text to that line in there, if it has it. Throws Error where there
  /// is no such program, or no statement.
  void add_breakpoint(const Location& place, const std::optional<TextLines>& text = {});
  void drop_breakpoint(const Location& place, const std::optional<TextLines>& text = {});
  void clear_breakpoints();
  /// The file reads `text` now, saved or not: its breakpoints go with their lines, or stand at `lines` of it.
  void edit_breakpoints(const std::string& file, TextLines text,
                        const std::optional<std::vector<int>>& lines);
  /// Before the first tick: the program goes on from where an earlier run was cut off. Throws Error where
  /// there is nothing to go on from, or the program has changed.
  program::StartReport continue_program();
  /// What grippers hold now; and, after continue_program(), what they held when the run before was cut off.
  std::vector<std::string> held_parts() const { return held_parts_->names(snapshot()); }
  const std::vector<std::string>& held_before() const { return held_before_; }
  bool all_idle() const;
  /// Is anything left of a motion that a resume goes on with: a program's, or one that somebody sent?
  bool motion_left() const;
  /// At the end of a run: what lets the program go on later is on the disk.
  void keep_safe_point();
  const std::optional<Failure>& failure() const { return failure_; }
  /// Why the cell does not run: the cause of the loop's stop; if the cell itself asked for it, what it asked
  /// for (link-lost, link-stale, heartbeat, program-hold, connected, run-failed). `code` is as control::code
  /// or one of these.
  Problem stop_cause() const;
  /// Stops on the path; `why` is the cause until the cell runs again.
  void hold_for(Problem why);
  /// Faults that stopped one robot while the rest went on.
  const std::vector<Problem>& group_faults() const { return group_faults_; }
  /// True when program and PLC have ended, and every part has come to rest or has had 2 s to.
  bool finished() const { return finished_; }
  const PartTracker& parts() const { return parts_; }
  const CellRobots& robots() const { return robots_; }
  const description::Scene& scene() const { return scene_; }
  data::DataStore& store() { return store_; }
  DataFiles& files() { return *files_; }
  Answers& answers() { return answers_; }
  const CellFile& file() const { return file_; }
  /// What the controllers' files say of their manager.
  const ros_files::ManagerParameters& manager() const { return manager_; }
  const description::Catalogue& catalogue() const { return catalogue_; }
  const control::Snapshot& snapshot() const { return loop_->outbox().value(); }
  bool lock_step() const { return options_.lock_step; }
  /// True when the number of passes was limited from outside.
  bool limited() const { return options_.cycles > 0; }
  int contacts_max() const { return contacts_max_; }
  double tracking_error_max() const { return tracking_error_max_; }
  /// Cycle in which the first motion was commanded, if any.
  std::optional<std::uint64_t> first_motion_cycle() const;
  Nanoseconds now() const { return now_; }

  /// Begins to read the descriptions again, on the thread for what touches the disk, and to make the
  /// component of that name from them.
  std::shared_ptr<const Remaking> remake(const std::string& name);
  /// When that is done: puts what was made in the place of the unconfigured component. Kinematics and limits
  /// stay those that the cell started with. Throws Error with what is wrong with the files.
  std::shared_ptr<hardware::Transition> begin_reload(const Remaking& remade);
  /// Callbacks of hardware that may take their time; cell thread.
  HardwareCalls& hardware_calls() { return calls_; }

  /// Real hardware and whether it is armed; cell thread.
  const Arming& arming() const { return *arming_; }
  /// The controllers that begin when the cell is armed, or at once where nothing is real.
  const std::vector<std::string>& chosen_controllers() const { return chosen_controllers_; }
  /// A person has armed it: programs and messages may begin.
  void set_armed();
  /// After a reload, which may have made a component real.
  void look_for_real_hardware() { arming_->look_again(); }

  /// What the stops of this run took, oldest first; at most the newest thousand.
  const std::vector<StopReport>& stops() const { return stops_; }
  /// Motion by hand; cell thread.
  Jogging& jogging() { return *jogging_; }
  /// The limits profile, "reduced" or "full". Throws Error("unknown-profile").
  const std::string& profile() const { return profile_; }
  void set_profile(const std::string& name);
  /// What motion by hand keeps to now: the profile's, and reduced speed where arming says so.
  jog::JogLimits jog_limits() const;
  /// What the profile bounds planned moves by; nothing in the first pass of real hardware, which is governed.
  moves::MovePlanOptions plan_options() const;
  /// Has the robot no move of a program's queued, planned or under way?
  bool idle(std::size_t robot) const { return !motions_[robot] || motions_[robot]->idle(); }
  /// Who holds control: "program", "jog" or "nobody".
  const char* control_holder() const;

  /// Of a robot; null where no trajectory controller moves all its joints.
  moves::RobotMotion* motion(std::size_t robot) { return motions_[robot].get(); }
  const MotionEntry& pace() const { return file_.motion; }
  const EventLog& events() const { return observer_; }

  /// Forgets what bases have left to go, where they stand.
  void drop_bases();

  // For requests; cell thread.
  StopWatch& stop_watch() { return stop_watch_; }
  const HeldPlace& held_place() const { return held_place_; }
  /// Where the robots are now is where the next motion begins: what moved them while held counts no more.
  void forget_pushes() { held_place_.forget(); }
  /// Contacts so far, and what they are not detected for.
  const ContactWatch& contacts() const { return contact_watch_; }
  const std::vector<Problem>& unchecked_bodies() const { return unchecked_bodies_; }
  control::ContactStop contact_stop() const { return loop_->supervisor().contact_stop(); }
  const JointPlaces& joint_places() const { return joint_places_; }
  /// Reports to everybody, and keeps it among the events.
  Observer& observer() { return observer_; }
  /// `observer` is told from now on what happens; the one that the cell was built with is the first.
  void add_observer(Observer& observer) { observers_.add(observer); }
  void remove_observer(Observer& observer) { observers_.remove(observer); }
  /// What records the cell; null where nothing can. It goes before the cell does.
  Recorder* recorder() { return recording_.get(); }
  void set_recorder(std::unique_ptr<Recorder> recorder) { recording_ = std::move(recorder); }
  /// Somebody wants the cell built anew: who runs it ends it and does so.
  void ask_restart(RestartWish wish) { restart_ = std::move(wish); }
  const std::optional<RestartWish>& restart() const { return restart_; }
  /// Tells a person.
  void tell(const std::string& note) { observer_.on_note(note); }
  Requests& requests() { return *requests_; }
  /// What signals.yaml declares, and the links at work.
  const signals::Signals& signals() const { return signals_; }
  const CellLinks& links() const { return *links_; }
  const TagBinding& tags() const { return *tags_; }
  /// Whether what outputs are to have at the end has gone out.
  bool outputs_settled() const;
  /// For what takes longer than a tick may; in lock-step it is done at once.
  Worker& worker() { return *worker_; }
  /// Makes and configures a controller while the cell runs: with the type and parameters given, or with those
  /// that the controllers' files have under its name. Returns the warnings.
  /// `file`: a controllers file that is read instead of the cell's own; empty: those. Where configuring
  /// fails, nothing is loaded.
  Problems load_controller(const std::string& name, const std::string& type,
                           controllers::Parameters parameters, const std::string& file = {});
  /// Takes away a controller that is not active; throws Error where the cell itself works through it.
  void unload_controller(const std::string& name);
  /// Names of the controllers that fell when the component failed, as far as not told yet.
  std::vector<std::string> take_fallen(const std::string& component);
  /// What became of the latest goals of a controller, oldest first.
  const std::vector<controllers::GoalEvent>& goal_events(const std::string& controller);
  /// Tells what the loop did by itself, and lets components that failed decide what they become.
  void tell_loop_events();

  /// Ends the programs where they are (a person stopped the run).
  void stop_programs();
  /// In the world, as if the robot's base stood where the cell's file puts it, as its points are.
  Pose tcp(std::size_t robot) const;
  /// Where the robot's base is.
  const MovingBase& base(std::size_t robot) const { return places_[robot]; }

 private:
  void start_hardware();
  bool shut_hardware_down(Nanoseconds patience);
  void build_controllers(const ros_files::ControllersFile& described, Problems& problems);
  void offer_named_states();
  void build_tags(Problems& problems);
  void build_programs(Problems& problems);
  void place_breakpoints();
  const TextLines* lines_of_program(const std::string& file) const;
  int known_line(FileBreakpoints& file, int line, const std::optional<TextLines>& text) const;
  void start_program(program::Program program);
  void end_moves();
  void send_start_messages();
  void tell_overruns();
  void tell_threads();
  Pose carrier_of(const Camera& camera) const;
  void update_states(const control::Snapshot& snapshot);
  void follow_strangers(const control::Snapshot& snapshot);
  void tick_motions(Nanoseconds now);
  bool moves_as_planned_now() const;
  void tick_program(Nanoseconds now);
  void tell_changes(Nanoseconds now);
  void watch_contacts(Nanoseconds now, const control::Snapshot& snapshot);
  void find_cause(ContactReport& contact) const;
  int robot_in(const ContactReport& contact) const;
  Problem problem_of(const ContactReport& contact) const;
  void watch_faults(Nanoseconds now, const control::Snapshot& snapshot);
  void watch_groups(Nanoseconds now, const control::Snapshot& snapshot);
  /// Is the cell brought back by people and programs outside after a fault?
  bool waits_for_others() const {
    return options_.waits || (!options_.lock_step && !program_ && file_.send.empty());
  }
  void watch_for_deadlock(Nanoseconds now, const control::Snapshot& snapshot);
  void watch_end(Nanoseconds now);
  void watch_links(Nanoseconds now, const control::Snapshot& snapshot);
  void write_outputs(Nanoseconds now, const control::Snapshot& snapshot);
  void watch_stops(Nanoseconds now, const control::Snapshot& snapshot);
  void fail(Nanoseconds now, Problem problem);

  CellFile file_;
  ros_files::ManagerParameters manager_;
  CellOptions options_;
  Observers observers_;
  EventLog observer_{observers_};
  HardwareCalls calls_;
  std::map<std::pair<std::string, std::string>, std::uint64_t> overruns_;  ///< by name and callback
  std::vector<char> told_threads_;  // by component: what the machine refused its thread was told
  description::Catalogue catalogue_;
  CellRobots robots_;
  std::vector<CellRobots> reloaded_;  ///< what components that were reloaded refer to
  description::Scene scene_;
  std::unique_ptr<control::ControlLoop> loop_;
  std::unique_ptr<Worker> worker_, planner_;
  data::DataStore store_;
  std::unique_ptr<DataFiles> files_;
  CellStates states_;
  signals::Signals signals_;
  std::unique_ptr<TagBinding> tags_;
  std::unique_ptr<CellLinks> links_;
  std::unique_ptr<Heartbeats> heartbeats_;
  bool links_ready_ = false, told_waiting_ = false, missed_ = false;
  std::optional<Problem> held_by_;  ///< what the cell itself stopped the loop for; empty once it runs again
  Nanoseconds stopped_at_ = -1;  ///< since when outputs have what they are to have at the end
  std::vector<Camera> cameras_;
  std::vector<std::unique_ptr<moves::RobotMotion>> motions_;
  std::vector<std::unique_ptr<moves::BaseMotion>> bases_;  ///< by robot; null: it has no wheels to drive
  std::vector<MovingBase> places_;                         ///< of bases, by robot
  std::unique_ptr<ProgramMoves> moves_;                    ///< of the program
  std::set<std::string> told_warnings_;                    ///< of moves; a loop says them once
  std::vector<controllers::JointTrajectoryController*> trajectory_controllers_;
  Answers answers_;
  std::unique_ptr<Task> program_, plc_;
  bool begun_ = true;                 ///< the program
  std::set<const Task*> told_ended_;  ///< in a cell that goes on
  std::unique_ptr<TestTask> test_;
  ProgramHost::Context program_context_;
  std::unique_ptr<SafePoints> safe_points_;
  std::unique_ptr<HeldParts> held_parts_;
  std::vector<std::string> held_before_;
  std::optional<program::Program> ready_program_;  ///< it begins when a test says so
  PartTracker parts_{scene_};
  std::map<std::string, std::vector<controllers::GoalEvent>> goal_events_;
  std::map<std::string, std::vector<std::string>> fallen_;  // component → controllers
  std::string falling_;                                     // component whose fall is being told
  std::unique_ptr<Requests> requests_;
  std::unique_ptr<Arming> arming_;
  std::unique_ptr<Jogging> jogging_;
  std::string profile_ = "full";
  std::vector<std::string> chosen_controllers_;
  FaultRecorder recorder_;
  JointPlaces joint_places_;
  StopWatch stop_watch_;
  HeldPlace held_place_;
  std::vector<StopReport> stops_;
  std::vector<control::StopCause> fallen_seen_;  ///< by component
  std::vector<Problem> group_faults_;
  bool started_ = false, in_fault_ = false;
  Nanoseconds now_ = 0;
  std::size_t pass_state_ = 0, running_state_ = 0, line_state_ = 0, held_state_ = 0, fault_state_ = 0;
  std::vector<std::array<std::size_t, 3>> tcp_states_;
  ContactWatch contact_watch_;
  std::vector<Problem> unchecked_bodies_;
  int contacts_max_ = 0;
  double tracking_error_max_ = 0;
  std::uint64_t told_version_ = 0, quiet_version_ = 0;
  Nanoseconds quiet_since_ = 0, ended_at_ = -1;
  std::optional<Failure> failure_;
  bool finished_ = false;
  std::unique_ptr<Recorder> recording_;
  std::optional<RestartWish> restart_;
  Breakpoints breakpoints_;
};

}  // namespace polyarm::cell
