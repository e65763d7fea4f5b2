#include "polyarm/inside/inside.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/inside/test_task.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/setup/controllers_plan.hpp"
#include "polyarm/setup/controllers_start.hpp"

namespace polyarm::cell {

namespace {

Observers with(Observer& observer) {
  Observers out;
  out.add(observer);
  return out;
}

}  // namespace

CellInside::CellInside(const CellFile& file, const description::Catalogue& catalogue, CellOptions options,
                       Observer& observer, const std::vector<Handler>& handlers)
    : setup{file, std::move(options), catalogue, {}, {}, {}, {}, {}},
      observers(with(observer)),
      machine(setup, events),
      worker(setup.options.lock_step),
      planner(setup.options.lock_step),
      long_worker(setup.options.lock_step),
      data(setup, events),
      requests(*this, handlers) {
  Problems problems;
  const ros_files::ControllersFile described = read_setup(setup, events, problems);
  machine.make_loop(described);
  machine.add_hardware(problems);
  machine.start_hardware();
  make_owners();
  data.build(machine.table(), worker, problems);
  collect(problems, [&] { make_controllers(described, problems); });
  force_faults(problems);
  machine.prepare();
  data.offer_named_states();
  collect(problems, [&] { make_programs(problems); });
  teleoperation->build(problems);
  profile_choice->build(problems);
  problems.throw_if_errors();
  for (const Problem& problem : problems.list()) events.on_problem(0, problem);
  data.end_building();
}

CellInside::~CellInside() {
  recorder.reset();
  machine.shut_hardware_down(setup.options.hardware_timeout);
}

void CellInside::make_owners() {
  arming.emplace(machine.loop(), setup.robots, setup.options.full_speed, events);
  motions.emplace(setup, machine, *arming, contacts, events);
  programs.emplace(setup, machine, data, *motions, worker, events);
  parts.emplace(setup.scene);
  jogging.emplace(setup, machine, *arming, *motions, *programs, events);
  held_motions.emplace(JogOwners{setup, machine, data, contacts, *motions, *programs, *jogging}, worker);
  teleoperation.emplace(Teleoperation::Owners{setup, machine, data, *jogging, events});
  profile_choice.emplace(ProfileChoice::Owners{setup, machine, data, *motions, events});
  life.emplace(machine, *motions, events);
  watches.emplace(Watches::Owners{setup, machine, data, *motions, *programs, *jogging, *arming, *life,
                                  contacts, *parts, worker, events});
  guards.emplace(Guards::Owners{setup, machine, *motions, *programs, *jogging, *life, planner, events});
  motions->set_profile(setup.file.profiles.name);
}

void CellInside::make_controllers(const ros_files::ControllersFile& described, Problems& problems) {
  std::vector<PlannedController> plan = plan_controllers(
      described, setup.robots, machine.loop(),
      {data.tags().command_names(), setup.options.lock_step, setup.file.budget}, events, problems);
  machine.chosen_controllers = start_controllers(std::move(plan), setup.file, described, setup.robots,
                                                 machine.loop(), events, problems);
  if (auto* io = machine.controllers().find(kIoController))
    data.tags().connect(dynamic_cast<controllers::ForwardCommandController*>(io));
  motions->build(planner);
}

void CellInside::force_faults(Problems& problems) {
  for (const auto& [name, value] : setup.options.faults)
    collect(problems, [&, n = name, v = value] { machine.hardware().force(n, v); });
}

void CellInside::make_programs(Problems& problems) {
  programs->load(problems);
  if (const auto& entry = setup.options.test)
    test = std::make_unique<TestTask>(*this, program::load_program(entry->file.string()), entry->index,
                                      programs->context("test"), problems);
  programs->start_loaded(problems);
}

void CellInside::set_armed() {
  arming->set_armed(machine.now());
  motions->begin_where_robots_are();
}

void CellInside::unload_controller(const std::string& name) {
  const controllers::Controller* const leaving = machine.controllers().find(name);
  const auto in_use = [&](const std::string& by) {
    throw Error("in-use", "the controller '" + name + "' cannot be unloaded: " + by + " works through it");
  };
  if (leaving && name == kIoController) in_use("the cell's tags");
  if (leaving && programs->under_way() && motions->use(*leaving)) in_use("the program");
  machine.controllers().unload(name);
  machine.forget_goals(name);
  if (leaving)
    motions->release(
        *leaving, [this](moves::RobotMotion& motion) { programs->forget(motion); },
        [this](moves::BaseMotion& base) { programs->forget(base); });
}

/// Sends the messages that the cell file lists for the start.
void CellInside::send_start_messages() {
  started_ = true;
  watches->note_start_messages();
  for (const auto& [to, path] : setup.file.send) {
    try {
      const std::filesystem::path file = setup.file.folder / path;
      protocol::SendMessage request;
      request.to = to;
      request.message = protocol::Message(read_file(file));
      requests.ask(request, [this, file](const protocol::Reply& reply) {
        if (!reply.refusal) return true;
        const Problem& why = reply.refusal->problems().front();
        life->fail({"not-sent", {file.string()}, why.what, why.advice});
        return false;
      });
    } catch (const Error& e) {
      life->fail(e.problems().front());
    }
  }
}

OwnStates CellInside::own_states() const {
  const Task* const program = programs->program();
  const control::RunState state = machine.snapshot().state;
  OwnStates out;
  out.running = programs->under_way();
  out.passes = program ? static_cast<double>(program->status().passes + (out.running ? 1 : 0)) : 0;
  out.line = out.running ? program->status().where.line : 0;
  out.held = state == control::RunState::held;
  out.fault = state == control::RunState::fault;
  out.tcps = motions->tcps();
  return out;
}

bool CellInside::programs_over() const {
  if (life->failure()) return true;
  if (const Task* const program = programs->program()) return program->ended();
  return programs->plc() && programs->plc()->ended();
}

void CellInside::tick_motions() {
  if (life->failure()) return;
  motions->tick([this](const moves::RobotMotion& motion, std::uint64_t move) {
    return programs->place_of(motion, move);
  });
}

/// Reads tags and cameras, and checks that everything they need is present.
void CellInside::read_outside(Nanoseconds now) {
  const control::Snapshot& snapshot = machine.snapshot();
  data.read(now, snapshot, own_states());
  data.look(snapshot, [this](const Camera& camera) {
    for (std::size_t i = 0; i < setup.robots.size(); ++i)
      if (setup.robots[i]->entry.name == camera.setup().robot)
        return motions->tcp(i) * inverse(setup.robots[i]->tool.tcp);
    return Pose{};
  });
  jogging->tick();
  held_motions->tick();
  teleoperation->tick();
  if (arming->needed() || arming->reduced()) {
    const Task* const program = programs->program();
    arming->govern(now, motions->tcps(), snapshot.commands,
                   program && (program->ended() || program->status().passes > 0), motions->planned_as_now());
  }
  watches->hold_if_missing(data.watch_links(now));
}

/// Runs PLC, test and program, as far as they may run.
void CellInside::run_programs() {
  const bool may_run = !life->failure() && arming->armed() && data.links_ready();
  programs->end_pulses();
  if (may_run) programs->tick_plc();
  if (test) test->tick();
  const bool stop_requested = machine.supervisor().latch().requested() != realtime::StopKind::none;
  if (may_run && programs->under_way() && machine.snapshot().state == control::RunState::running &&
      !stop_requested && !jogging->engaged())
    programs->tick_program();
}

void CellInside::tick(Nanoseconds now) {
  machine.begin_tick(now);
  data.store.set_now(now);
  motions->update_bases();
  machine.report_events();
  if (!started_ && arming->armed()) send_start_messages();
  watches->watch_contacts();  // must run before moves that a contact ended are removed
  watches->watch_torques();
  watches->watch_stops();
  requests.tick();
  motions->follow_others();
  read_outside(now);
  programs->tick_belts_and_streams();
  profile_choice->tick();
  tick_motions();
  guards->prepare();
  run_programs();
  machine.supervisor().set_contacts_meant(programs->touches() && !jogging->engaged());
  tick_motions();
  guards->tick();
  data.write(now, machine.snapshot(), programs_over());
  data.exchange_files(now);
  parts->update(now, machine.snapshot().world);
  data.report_changes(now);
  watches->watch_faults_and_end();
  if (recorder) recorder->tick(now);
}

}  // namespace polyarm::cell
