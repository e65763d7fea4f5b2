#include "drivers/ur/far_side.hpp"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::ur {

namespace {

constexpr Nanoseconds kStateEvery = 100'000'000;

constexpr wire::OrderKind kKinds[] = {
    {"protective_stop", "the robot stops and waits to be unlocked"},
    {"safeguard_stop", "somebody opened the guard"},
    {"emergency_stop", "somebody pressed the button"},
    {"violation", "the safety system found a violation"},
    {"normal", "ends any of these; the robot stays off after an emergency stop"},
    {"power_off", "the robot is switched off"},
    {"power_on", "it is switched on and its brakes are released"},
    {"program_stop", "somebody stops the program at the pendant"},
    {"program_pause", "somebody pauses it"},
    {"program_play", "somebody starts it again"},
    {"local", "local control"},
    {"remote", "remote control"},
    {"silent", "RTDE sends nothing any more"},
    {"late", "so many RTDE packages come late and together (10)"},
    {"duplicate", "so many RTDE packages come twice (10)"},
    {"reorder", "so many RTDE packages come after the next one (10)"},
    {"garbage", "one RTDE package is broken"},
    {"speaking", "ends silent"},
    {"wrong_version", "RTDE refuses its protocol versions"},
    {"second_client", "another program writes the RTDE inputs"},
    {"unreachable", "programs cannot connect to the driver: a firewall"},
    {"deaf", "the program does not read its commands"},
    {"close_stream", "the program closes its connection"},
    {"close_rtde", "the controller closes RTDE"},
    {"dead", "the controller closes all connections"},
    {"script_error", "the next program ends with an error"},
    {"healthy", "ends every fault of the wires, also those that are still to come"},
};

}  // namespace

FarSide::FarSide(FarSideOptions options)
    : options_(std::move(options)),
      machine_(options_.machine),
      rtde_(machine_, faults_, options_.rate),
      program_(machine_, faults_),
      primary_(machine_, program_),
      dashboard_(machine_, program_, primary_),
      wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  rtde_.service().listen(options_.address, options_.rtde);
  dashboard_.service().listen(options_.address, options_.dashboard);
  primary_.primary().listen(options_.address, options_.primary);
  primary_.secondary().listen(options_.address, options_.secondary);
  thread_ = std::thread([this] { run(); });
}

FarSide::~FarSide() {
  quit_ = true;
  ::eventfd_write(wake_.number(), 1);
  thread_.join();
}

std::string FarSide::kinds() {
  return wire::order_list(kKinds);
}

std::vector<wire::TimedOrder> FarSide::timed_orders(const std::string& text) {
  return wire::parse_timed_orders(text, "protective_stop@3 normal@again", kKinds);
}

void FarSide::report(const std::string& text) const {
  if (options_.report) options_.report(text);
}

void FarSide::end_program(const std::string& why) {
  if (!program_.runs()) return;
  program_.stop();
  primary_.program_ended();
  report(why);
}

void FarSide::order(const std::string& fault) {
  const auto [kind, given] = wire::parse_order(fault, kKinds);
  const int number = given >= 0 ? given : 10;
  const std::lock_guard lock(mutex_);
  const auto is = [&kind = kind](const char* name) { return kind == name; };
  if (is("protective_stop")) machine_.safety(protective_stop);
  if (is("safeguard_stop")) machine_.safety(safeguard_stop);
  if (is("emergency_stop")) machine_.safety(robot_emergency);
  if (is("violation")) machine_.safety(violation);
  if (is("normal")) machine_.safety(safety_normal);
  if (is("power_off")) machine_.switch_off();
  if (is("power_on") && machine_.switch_on()) machine_.release_brakes();
  if (is("program_stop")) end_program("the program was stopped by hand");
  if (is("program_pause")) program_.pause(true);
  if (is("program_play")) program_.play();
  if (is("local") || is("remote")) machine_.set_remote(is("remote"));
  if (is("silent") || is("speaking")) faults_.silent = is("silent");
  if (is("late")) faults_.late = number;
  if (is("duplicate")) faults_.duplicate = number;
  if (is("reorder")) faults_.reorder = number;
  if (is("garbage")) faults_.garbage = true;
  if (is("wrong_version")) faults_.wrong_version = true;
  if (is("second_client")) faults_.second_client = true;
  if (is("unreachable")) faults_.unreachable = true;
  if (is("deaf")) faults_.deaf = true;
  if (is("script_error")) faults_.exception = "compile_error_name_not_found:servoj";
  if (is("close_stream")) program_.close_stream();
  if (is("close_rtde") || is("dead")) rtde_.service().drop_all();
  if (is("dead")) {
    program_.stop();
    primary_.primary().drop_all();
    primary_.secondary().drop_all();
    dashboard_.service().drop_all();
  }
  if (is("healthy")) faults_ = {};
  report("ordered: " + fault);
}

void FarSide::hold_clock(bool on) {
  const std::lock_guard lock(mutex_);
  held_ = on;
}

bool FarSide::step(std::int32_t sequence, Nanoseconds patience) {
  std::unique_lock lock(mutex_);
  bool came = true;
  if (sequence > 0)
    came = served_.wait_for(lock, std::chrono::nanoseconds(patience), [&] {
      return !program_.runs() || faults_.deaf || machine_.program() != Machine::Program::playing ||
             program_.last_sequence() >= sequence;
    });
  rtde_.serve();  // the outputs that were sent before the command
  cycle();
  return came;
}

double FarSide::sent_time() {
  const std::lock_guard lock(mutex_);
  return rtde_.sent_time();
}

std::uint64_t FarSide::messages() {
  const std::lock_guard lock(mutex_);
  return program_.messages();
}

bool FarSide::program_runs() {
  const std::lock_guard lock(mutex_);
  return program_.runs();
}

void FarSide::serve() {
  rtde_.serve();
  dashboard_.serve();
  primary_.serve();
  if (program_.serve()) {
    primary_.program_ended();
    report("the program ended");
  }
  if (const bool runs = program_.runs(); runs != ran_) {
    ran_ = runs;
    if (runs) report("a program started: " + program_.name());
  }
  served_.notify_all();
}

void FarSide::cycle() {
  const double dt = 1 / options_.rate;
  if (!machine_.may_move() && program_.runs() && machine_.safety_mode() != protective_stop &&
      machine_.safety_mode() != safeguard_stop)
    end_program("the program ended: the robot is not in operation");
  if (program_.runs() && !machine_.may_move()) program_.pause(true);
  program_.step(dt);
  machine_.step(dt);
  rtde_.send(++cycles_);
  const auto every = static_cast<std::uint64_t>(std::max(1.0, options_.rate * seconds(kStateEvery)));
  if (cycles_ % every == 0) primary_.send_state();
}

std::vector<int> FarSide::descriptors() {
  std::vector<int> out{wake_.number()};
  const auto add = [&out](auto& service) {
    out.push_back(service.listener());
    for (const auto& client : service.clients()) out.push_back(client->socket.number());
  };
  add(rtde_.service());
  add(dashboard_.service());
  add(primary_.primary());
  add(primary_.secondary());
  program_.descriptors(out);
  return out;
}

void FarSide::run() {
  const auto period = nanoseconds(1 / options_.rate);
  Nanoseconds due = realtime::monotonic_now() + period;
  std::vector<pollfd> polled;
  while (!quit_) {
    {
      const std::lock_guard lock(mutex_);
      polled.clear();
      for (const int descriptor : descriptors()) polled.push_back({descriptor, POLLIN, 0});
    }
    const Nanoseconds left = std::clamp<Nanoseconds>(due - realtime::monotonic_now(), 0, period);
    const timespec time{0, static_cast<long>(left)};
    ::ppoll(polled.data(), polled.size(), &time, nullptr);
    const std::lock_guard lock(mutex_);
    serve();
    const Nanoseconds now = realtime::monotonic_now();
    if (now < due) continue;
    due = std::max(due + period, now - 10 * period);
    if (!held_) cycle();
  }
}

}  // namespace polyarm::ur
