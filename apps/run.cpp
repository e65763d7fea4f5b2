#include "polyarm/cell/run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "apps/asked_cell.hpp"
#include "apps/ending.hpp"
#include "apps/options.hpp"
#include "apps/reach.hpp"
#include "apps/run_audit.hpp"
#include "apps/run_output.hpp"
#include "apps/run_pendant.hpp"
#include "polyarm/base/printer.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/check.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/machine/fault_record.hpp"
#include "polyarm/recording/cell_recorder.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

struct RunArguments : CellOption {
  std::vector<std::string> plugins;
  cell::CellOptions cell_options;
  cell::RunOptions run;
  PendantArguments pendant;
  cell::RecordOptions record;
  std::vector<std::string> faults;
  bool json = false, quiet = false, ros2 = false, keeps_going = false, yes = false;
  bool connects = false;  ///< the user has just chosen the real hardware: the cell starts held
  bool audits = true;
  bool asks = true;       ///< ask at the terminal; false if the cell was chosen at the pendant
  int line = 0;
};

void add_options(CommandLine& app, RunArguments& a) {
  a.add_to(app);
  app.add_option("--activate", a.activate, "start only these controllers of the file; may be repeated");
  app.add_option("--robot", a.overrides.robot, "another robot: MODEL, or NAME=MODEL in a cell of several");
  app.add_option("--program", a.overrides.program, "another program: a script, beside the cell or anywhere");
  app.add_option("--hardware", a.overrides.hardware,
                 "declared, mock, mujoco or a plugin's VENDOR/TYPE, for every robot")
      ->check(wrong_hardware, "NAME");
  app.add_flag("--real", a.cell_options.real,
               "drive the hardware that the cell declares as real; it moves after you type 'arm'");
  app.add_flag(
      "--full-speed", a.cell_options.full_speed,
      "real hardware moves at full speed from the first pass on (else at most 250 mm/s and a tenth of "
      "the joints' speed)");
  add_plugin_option(app, a.plugins);
  app.add_flag("--fast", a.run.fast, "in lock-step, as fast as the machine allows; repeatable");
  app.add_option("--cycles", a.cell_options.cycles,
                 "end after this many passes of the program's outermost while");
  app.add_option("--seconds", a.run.seconds, "end after this much cell time")->not_negative();
  app.add_flag("--json", a.json, "one JSON object per line on stdout, the result last");
  app.add_flag("--quiet,-q", a.quiet, "only the result");
  app.add_option("--fault", a.faults,
                 "force an interface: NAME=VALUE (a number, on or off); may be repeated");
  app.add_flag("--allow-contact", a.cell_options.allow_contact,
               "contacts are only reported, the run continues");
  app.add_flag(
      "--wait", a.cell_options.waits,
      "start the program on request (polyarm console, program.start), and keep running when it has ended");
  app.add_flag("--keep", a.cell_options.keep, "start with the data that the last run left in .state/");
  app.add_flag("--continue", a.keeps_going,
               "continue an interrupted run, for example after a loss of power, with its data; prints where, "
               "and asks");
  app.add_option("--from", a.line, "start at this line of the program; prints what it assumes, and asks")
      ->positive();
  app.add_flag("--yes", a.yes, "do not ask");
  app.add_flag("--stay", a.run.stay,
               "keep the cell running when its program has ended: polyarm control from LINE");
  app.add_option("--answer", a.cell_options.answers, "answer to `wait user`, in order; may be repeated");
  bool* socket = &a.run.socket;
  add_pendant_options(app, a.pendant);
  app.add_option("--record", a.record.file, "record the run into this MCAP file, for Foxglove and others");
  app.add_option("--record-rate", a.record.rate, "cycles a second in the recording (100)")
      ->range(0.1, 10'000.0);
  app.add_flag("--ros2", a.ros2,
               "join the ROS 2 graph as a robot; only on this machine unless cell.yaml says more");
  app.add_flag("--socket", a.run.fast_socket, "other programs may reach this cell in lock-step, too");
  app.add_flag("--links", a.cell_options.links, "links to the outside are connected in lock-step, too");
  app.add_flag_callback(
      "--no-socket", [socket] { *socket = false; }, "no other program may reach this cell while it runs");
  app.add_flag_callback(
      "--no-audit", [&a] { a.audits = false; }, "write no audit log (polyarm audit)");
  app.add_option_function(
         "--budget", [&a](double ms) { a.overrides.budget = nanoseconds(ms * 1e-3); },
         "ms that a callback in the control loop may take; longer ones are reported")
      ->range(0.001, 1000.0);
  app.add_option("--priority", a.run.priority, "SCHED_FIFO priority of the control thread")->range(0, 99);
  app.add_option("--cpu", a.run.cpu, "processor of the control thread");
  app.footer(
      examples({"polyarm run examples/pick_and_place",
                "polyarm run examples/sorting --robot abb/irb_120 --fast",
                "polyarm run examples/bin_picking --fast --cycles 4 --json",
                "polyarm run examples/pick_and_place --fault arm/tool/vacuum=off --fast",
                "polyarm run examples/pick_and_place --record run.mcap",
                "polyarm run universal_robots/ur5e --pendant",
                "polyarm run --description my_robot.urdf --controllers controllers.yaml --seconds 5"}) +
      "\nWhile it runs: Ctrl-C stops on the path, a second one at once; type hold, resume, discard or stop.\n"
      "Exit codes: 0 completed, 1 failed, 2 wrong command line, 3 stopped by a person\n");
}

void read_faults(RunArguments& a) {
  for (const std::string& fault : a.faults) {
    const auto equals = fault.find('=');
    const std::string value = equals == std::string::npos ? "" : lower(fault.substr(equals + 1));
    std::optional<double> number = parse_number(value);
    if (value == "on" || value == "true") number = 1;
    if (value == "off" || value == "false") number = 0;
    if (!number)
      throw Error("bad-value", "--fault " + fault + " is not NAME=VALUE",
                  "for example --fault arm/tool/vacuum=off");
    a.cell_options.faults[fault.substr(0, equals)] = *number;
  }
}

/// Ends the process if a cell does not end, because threads of plugins may hang.
class EndsInTime {
 public:
  explicit EndsInTime(int code) {
    std::thread([code, over = over_] {
      std::unique_lock lock(over->mutex);
      if (over->wake.wait_for(lock, std::chrono::seconds(20), [&] { return over->yes; })) return;
      std::fputs("polyarm run: a thread of a plugin does not return; the process ends without it\n", stderr);
      std::fflush(nullptr);
      std::_Exit(code);
    }).detach();
  }
  ~EndsInTime() {
    const std::lock_guard lock(over_->mutex);
    over_->yes = true;
    over_->wake.notify_all();
  }

 private:
  struct Over {
    std::mutex mutex;
    std::condition_variable wake;
    bool yes = false;
  };
  std::shared_ptr<Over> over_ = std::make_shared<Over>();
};

/// Writes everything that is needed to inspect and repeat a failed run into one folder.
std::string keep_failure(cell::CellInside& cell, const cell::RunResult& result, const std::string& command) {
  const Problem problem =
      result.problems.empty() ? Problem{"failed", {}, "the run failed", {}} : result.problems.front();
  cell::FaultRecord record = cell.watches->begin_record(problem);
  record.stopped = &cell.machine.loop().black_box();
  record.files["command.txt"] = command + "\n";
  record.files["result.json"] = result_json(result, "") + "\n";
  return cell::write_record(record, "failures").string();
}

cell::CellFile open_cell(const RunArguments& a) {
  cell::CellFile file = a.open();
  if (a.description.empty() && a.asks && !description::is_launch_file(a.cell)) ask_for_access(file);
  return file;
}

/// If a cell cannot be built, checks it completely, so the user sees every error at once.
std::vector<Problem> all_problems(const RunArguments& a, const Error& first) {
  const cell::CheckResult checked = cell::check([&] { return a.open(); }, open_catalogue(), {});
  if (!checked.has_errors()) return first.problems();
  std::vector<Problem> out = checked.problems;  // and errors that only a run reports
  for (const Problem& problem : first.problems())
    if (std::none_of(out.begin(), out.end(), [&](const Problem& p) { return p.text() == problem.text(); }))
      out.push_back(problem);
  return out;
}

int code_of(const cell::RunResult& result) {
  return result.outcome == cell::Outcome::completed ? kOk
         : result.outcome == cell::Outcome::stopped ? kStopped
                                                    : kFailed;
}

void report(const cell::RunResult& result, const std::string& folder, bool json) {
  if (json)
    fmt::print("{}\n", result_json(result, folder));
  else
    print_result(result, folder);
  std::fflush(stdout);
}

/// Writes to standard error, which may be the same closed pipe.
void report_unread(const std::string& text) {
  Printer(STDERR_FILENO, Printer::Full::leaves_out, [](std::size_t) { return ""; }).put(text);
}

/// Prints what a program that starts in the middle assumes.
void print_assumptions(cell::CellInside& cell, const program::StartReport& report) {
  const auto line = [](const char* what, const std::string& text) {
    if (!text.empty()) fmt::print("  {:<22}{}\n", what, text);
  };
  const auto values = [&](const std::vector<std::string>& names) {
    std::vector<std::string> out;
    for (const std::string& name : names) {
      const data::Value* value = cell.data.store.find(name);
      if (value && !value->is_place()) out.push_back(name + " = " + value->text());
    }
    return join(out, ", ");
  };
  const cell::Task& task = *cell.programs->program();
  std::vector<std::string> variables, held = cell.programs->held_parts();
  for (const auto& each : task.interpreter().variables(task.status().name))
    variables.push_back(each.name + " = " + each.value.text());
  if (const auto& before = cell.programs->held_before(); !before.empty() && before != held)
    held.push_back(join(before, ", ") + " when it was cut off");
  fmt::print("The program continues at {}: {}\n", report.where.text(), task.status().source);
  line("robot", report.robot);
  line("tool", report.tool.empty() ? "the robot's own" : report.tool);
  line("frame", report.frame.empty() ? "world" : report.frame);
  line("held part", held.empty() ? "none known" : join(held, ", "));
  line("last point before it", report.last_point);
  line("it would have set", values(report.sets));
  line("it reads", values(report.reads));
  line("variables", join(variables, ", "));
  std::fflush(stdout);
}

/// False if the user does not want to start in the middle.
bool begins_where_asked(cell::CellInside& cell, const RunArguments& a) {
  if (!a.keeps_going && a.line == 0) return true;
  if (a.keeps_going && a.line > 0) throw Error("bad-value", "--continue and --from name two places to start at");
  const program::StartReport report =
      a.keeps_going ? cell.programs->continue_from_safe_point() : cell.programs->prepare("", a.line);
  if (!a.json) print_assumptions(cell, report);
  if (!a.yes) {
    if (::isatty(STDIN_FILENO) == 0)
      throw Error("nobody-there", "nobody can confirm that the program may start there", "use --yes");
    fmt::print("Is all of this true? Type yes to continue: ");
    std::fflush(stdout);
    std::string answer;
    std::getline(std::cin, answer);
    if (answer != "yes") return false;
  }
  if (a.line > 0) cell.programs->program()->interpreter().resume();
  return true;
}

/// Makes the cell able to record, and starts recording if requested.
void begin_recording(cell::Cell& cell, const RunArguments& a) {
  cell.set_recorder(recording::make_recorder(cell.view(), POLYARM_VERSION));
  if (!a.record.file.empty())
    cell.recorder()->start(a.record);
  else if (cell.view().file().record)
    cell.recorder()->start(*cell.view().file().record);
}

constexpr const char* kNothingReal = "nothing-real";

/// With --real the user expects a robot to move; refuses a cell that only simulates.
void require_something_real(const cell::CellView& cell, bool asked) {
  if (!asked || cell.arming().needed()) return;
  std::vector<std::string> robots;
  for (const auto& robot : cell.robots()) robots.push_back(robot->entry.name + " (" + robot->driver + ")");
  const std::string simulated = join(robots, ", ");
  throw Error(Problem{kNothingReal,
                      {cell.file().path.string()},
                      "--real, but nothing of this cell is real: " + simulated,
                      "name the driver of the real robot as its 'hardware', or run without --real",
                      Severity::error,
                      {{"robots", simulated}}});
}

/// Root is not needed, and a fault of a root process can affect the whole machine.
void warn_of_root(cell::CellView& cell) {
  if (::geteuid() == 0 && cell.arming().needed())
    cell.tell(
        "this runs as root, with real hardware: run it as a user of the groups that the device needs "
        "(dialout, i2c), and give priority by rtprio in /etc/security/limits.conf");
}

/// The result of running one cell.
struct Ended {
  int code = kFailed;
  bool by_person = false;
  std::optional<cell::RestartRequest> wish;  ///< set if the cell is to be rebuilt
  bool armed = false;                     ///< real hardware was armed by a person
};

/// Runs one cell from reading its files to its end.
class OneRun {
 public:
  OneRun(RunArguments& a, const std::string& command, const description::Catalogue& catalogue, Output& shown,
         server::Pendant* pendant, users::AuditLog* audit_log)
      : a_(a),
        command_(command),
        catalogue_(catalogue),
        shown_(shown),
        observer_(pendant ? pendant->observer() : shown),
        pendant_(pendant),
        audit_(audit_log) {
    if (pendant_) waits_ = std::exchange(a_.cell_options.waits, true);  // a fault does not end the run
  }
  ~OneRun() {
    if (pendant_) a_.cell_options.waits = waits_;
  }

  Ended run() {
    std::optional<cell::Cell> cell;
    set_simulated(!a_.cell_options.real);
    try {
      cell::CellFile file = open_cell(a_);
      if (a_.ros2) file.doors["ros2"];
      cell.emplace(file, catalogue_, a_.cell_options, observer_);
      require_something_real(cell->view(), a_.cell_options.real);
      warn_of_root(cell->view());
      begin_recording(*cell, a_);
      shown_.settle();
      if (!begins_where_asked(cell::inside_of(*cell), a_)) {
        fmt::print("nothing was begun\n");
        return {kStopped, true, {}, false};
      }
    } catch (const std::exception&) {  // nothing has moved
      const Error e = error_thrown();
      const bool nothing_real = e.problems().front().code == kNothingReal;
      Ended out = not_built(cell ? e.problems() : all_problems(a_, e));
      if (nothing_real) out.code = kUsage;
      return out;
    }
    cell::CellInside& inside = cell::inside_of(*cell);
    if (audit_) audit(cell->view(), *audit_, pendant_);
    if (pendant_ && !waits_) inside.programs->let_begin();
    if (pendant_) {
      pendant_->attach(cell->view());
      cell->view().tell("pendant: " +
                        pendant_->link());  // through the cell, so its event log shows it to other clients
    }
    if (a_.connects)
      inside.machine.hold_for({"connected", {}, "the real hardware has just been connected", {}});
    const cell::RunResult result = cell::run(*cell, a_.run, observer_);
    const bool armed = inside.arming->needed() && inside.arming->armed();
    if (pendant_) pendant_->detach();
    a_.cell_options.breakpoints = inside.programs->kept_breakpoints();
    std::string folder;
    if (result.outcome == cell::Outcome::failed) folder = keep_failure(inside, result, command_);
    const int code = code_of(result);
    if (shown_.settle())
      report(result, folder, a_.json);
    else
      report_unread(fmt::format("polyarm run: {}; the output is not read, so the result is omitted\n",
                              cell::name(result.outcome)));
    std::fflush(nullptr);
    if (result.stuck) std::_Exit(code);
    const EndsInTime guard(code);
    cell.reset();
    return {code, result.outcome != cell::Outcome::failed && !result.restart, result.restart, armed};
  }

 private:
  Ended not_built(const std::vector<Problem>& problems) {
    cell::RunResult result;
    result.outcome = cell::Outcome::failed;
    result.problems = problems;
    shown_.settle();
    if (a_.json) report(result, "", true);
    if (pendant_) observer_.on_note("pendant: " + pendant_->link());
    if (pendant_)
      for (const Problem& problem : problems) observer_.on_problem(0, problem);
    else if (!a_.json)
      for (const Problem& problem : problems) fmt::print(stderr, "{}\n", problem.text());
    return {};
  }

  RunArguments& a_;
  const std::string& command_;
  const description::Catalogue& catalogue_;
  Output& shown_;
  cell::Observer& observer_;  ///< the pendant's observer, which forwards to the output
  server::Pendant* pendant_;
  users::AuditLog* audit_;  ///< null: none
  bool waits_ = false;  ///< the program waits until somebody starts it
};

/// With the pendant the command continues after a cell has failed, until the user chooses another one.
std::optional<cell::RestartRequest> wait_for_wish(server::Pendant& pendant, cell::Observer& shown) {
  shown.on_note("the pendant waits: choose what to run, or end with Ctrl-C");
  while (cell::stops_requested() == 0) {
    pendant.serve();
    if (auto wish = pendant.take_restart_request()) return wish;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return std::nullopt;
}

/// A newly chosen cell moves nothing before it is started, and uses real hardware only if that was requested.
void take_over(const cell::RestartRequest& wish, RunArguments& a) {
  if (!wish.cell.empty() || !wish.robot.empty() || !wish.hardware.empty()) a.cell_options.real = false;
  if (wish.real) a.cell_options.real = *wish.real;
  a.connects = wish.real.value_or(false);
  if (!wish.cell.empty()) a.cell = wish.cell, a.description.clear(), a.overrides = {};
  if (!wish.robot.empty()) a.overrides.robot = wish.robot;
  if (!wish.hardware.empty()) a.overrides.hardware = wish.hardware;
  if (!wish.program.empty()) a.overrides.program = wish.program;
  a.keeps_going = a.asks = false;
  a.line = 0;
  a.cell_options.waits = true;
}

int run_until_done(RunArguments& a, const std::string& command, const description::Catalogue& catalogue,
                   Output& shown, server::Pendant* pendant, users::AuditLog* audit_log) {
  for (;;) {
    Ended ended = OneRun(a, command, catalogue, shown, pendant, audit_log).run();
    if (std::exchange(a.connects, false) && !ended.wish && !ended.by_person && !ended.armed) {
      pendant->observer().on_note("the real hardware was not connected: the cell is simulated again");
      ended.wish.emplace();
      ended.wish->real = false;
    }
    if (pendant && !ended.wish && !ended.by_person) ended.wish = wait_for_wish(*pendant, shown);
    if (!ended.wish) return ended.code;
    take_over(*ended.wish, a);
  }
}

int execute(RunArguments& a, const std::string& command) {
  load_plugins(a.plugins);
  read_faults(a);
  a.cell_options.lock_step = a.run.fast;
  a.cell_options.keep = a.cell_options.keep || a.keeps_going;
  if (const char* started = std::getenv("POLYARM_STARTED_NS"))
    if (const auto ns = parse_number(started)) a.run.started = static_cast<Nanoseconds>(*ns);
  const bool whole = a.run.fast;  // a cell in lock-step can wait for a slow reader
  const std::unique_ptr<Output> shown =
      a.json ? make_json_output(whole) : make_text_output(a.quiet, whole, !a.run.fast);
  const description::Catalogue catalogue = open_catalogue();
  stop_on_signals(!a.run.fast);
  a.cell_options.start_given_up = [] { return cell::stops_requested() > 0; };
  std::unique_ptr<users::AuditLog> audit_log;
  if (a.audits && (a.pendant.on || (a.run.fast ? a.run.fast_socket : a.run.socket)))
    audit_log = open_audit(*shown);
  std::unique_ptr<server::Pendant> pendant;
  if (a.pendant.on) {
    try {
      pendant = open_pendant(a.pendant, catalogue, *shown, audit_log.get());
    } catch (const Error& e) {
      fmt::print(stderr, "polyarm run: {}\n", e.what());
      return kFailed;
    }
    a.run.doors.push_back(pendant.get());
    a.run.stay = true;
    if (a.pendant.listens && ::geteuid() == 0)
      shown->on_note("this runs as root and other machines may reach it: run it as an ordinary user");
    announce(*pendant, a.pendant, *shown);
  }
  return run_until_done(a, command, catalogue, *shown, pendant.get(), audit_log.get());
}

}  // namespace

int run_run(int argc, char** argv) {
  CommandLine app("Runs a cell: simulates, executes its program, reports", "polyarm run");
  RunArguments arguments;
  add_options(app, arguments);
  if (const auto code = app.parse(argc, argv)) return *code;
  if (const auto code = arguments.settle("run")) return *code;
  std::string command = "polyarm";
  for (int i = 0; i < argc; ++i) command += std::string(" ") + argv[i];
  return execute(arguments, command);
}

}  // namespace polyarm::apps
