#include "polyarm/inside/view.hpp"

#include "polyarm/inside/inside.hpp"
#include "polyarm/inside/ways.hpp"
#include "polyarm/operation/jog_commands.hpp"
#include "polyarm/operation/program_status.hpp"

namespace polyarm::cell {

Requests& CellView::requests() {
  return inside_.requests;
}
HeldMotions& CellView::held_motions() {
  return *inside_.held_motions;
}
Observer& CellView::observer() {
  return inside_.events;
}
void CellView::add_observer(Observer& observer) {
  inside_.observers.add(observer);
}
void CellView::remove_observer(Observer& observer) {
  inside_.observers.remove(observer);
}
void CellView::request_restart(RestartRequest wish) {
  inside_.life->request_restart(std::move(wish));
}

const CellFile& CellView::file() const {
  return inside_.setup.file;
}
const CellRobots& CellView::robots() const {
  return inside_.setup.robots;
}
const description::Scene& CellView::scene() const {
  return inside_.setup.scene;
}
const ros_files::ManagerParameters& CellView::manager() const {
  return inside_.setup.manager;
}
const signals::Signals& CellView::signals() const {
  return inside_.data.signals();
}
bool CellView::lock_step() const {
  return inside_.setup.options.lock_step;
}
Nanoseconds CellView::period() const {
  return inside_.machine.period();
}

Nanoseconds CellView::now() const {
  return inside_.machine.now();
}
const control::Snapshot& CellView::snapshot() const {
  return inside_.machine.snapshot();
}
const hardware::InterfaceTable& CellView::table() const {
  return inside_.machine.table();
}
const control::ControllerManager& CellView::controllers() const {
  return inside_.machine.controllers();
}
const hardware::Hardware& CellView::hardware() const {
  return inside_.machine.hardware();
}
const control::Supervisor& CellView::supervisor() const {
  return inside_.machine.supervisor();
}
const control::Health& CellView::health() const {
  return inside_.machine.loop().health();
}
std::uint64_t CellView::clamps() const {
  return inside_.machine.loop().limits().clamps();
}
std::unique_ptr<control::CycleTap> CellView::make_tap(std::size_t rows, unsigned every) const {
  return inside_.machine.loop().make_tap(rows, every);
}
std::shared_ptr<realtime::Job> CellView::tap(control::CycleTap* tap) const {
  return inside_.machine.loop().tap(tap);
}
const data::DataStore& CellView::store() const {
  return inside_.data.store;
}
const CellLinks& CellView::links() const {
  return inside_.data.links();
}
const EventLog& CellView::events() const {
  return inside_.events;
}
const Arming& CellView::arming() const {
  return *inside_.arming;
}
const std::optional<Failure>& CellView::failure() const {
  return inside_.life->failure();
}
Problem CellView::stop_cause() const {
  return inside_.life->stop_cause();
}
const Task* CellView::program() const {
  return inside_.programs->program();
}
const Task* CellView::plc() const {
  return inside_.programs->plc();
}
bool CellView::program_begun() const {
  return inside_.programs->begun();
}
protocol::ProgramStatus CellView::program_status() const {
  return cell::program_status(
      {inside_.setup, inside_.machine, *inside_.programs, *inside_.jogging, inside_.events, inside_.data});
}
protocol::OrNull<protocol::ProgramOverview> CellView::program_overview() const {
  protocol::OrNull<protocol::ProgramOverview> out;
  if (const Task* task = program())
    out.emplace(cell::program_overview(inside_.setup, *task, program_begun(), inside_.data));
  return out;
}
protocol::OrNull<protocol::ProgramOverview> CellView::plc_overview() const {
  protocol::OrNull<protocol::ProgramOverview> out;
  if (const Task* task = plc()) out.emplace(cell::program_overview(inside_.setup, *task, true, inside_.data));
  return out;
}
protocol::ContactState CellView::contacts() const {
  return contact_state(inside_.setup, inside_.machine, inside_.contacts);
}
protocol::PossibleNow CellView::possible_now() const {
  return cell::possible_now(inside_);
}

std::optional<Guards::Near> CellView::near(std::size_t robot) const {
  return inside_.guards->near(robot);
}

void CellView::set_more_obstacles(std::vector<description::Fixture> more,
                                  std::vector<surroundings::AttachedThing> attached) {
  inside_.guards->set_more(std::move(more), std::move(attached));
}

double CellView::pace(std::size_t robot) const {
  return inside_.guards->pace(robot);
}

std::optional<double> CellView::clearance_at(std::size_t robot, std::span<const double> q) const {
  return inside_.guards->clearance_at(robot, q);
}

const moves::RobotMotion* CellView::motion(std::size_t robot) const {
  return inside_.motions->motion(robot);
}
const MovingBase& CellView::base(std::size_t robot) const {
  return inside_.motions->base(robot);
}
surroundings::Moment CellView::moment() const {
  return inside_.motions->moment();
}
std::shared_ptr<SharedBodies> CellView::bodies() const {
  return inside_.motions->bodies();
}
moves::MovePlanOptions CellView::plan_options() const {
  return inside_.motions->plan_options();
}
Pose CellView::tcp(std::size_t robot) const {
  return inside_.motions->tcp(robot);
}
bool CellView::motion_left() const {
  return inside_.motions->motion_left();
}
bool CellView::jogged(std::size_t robot) const {
  return inside_.jogging->engaged(robot);
}
const char* CellView::control_holder() const {
  return cell::control_holder(*inside_.programs, *inside_.jogging);
}
const std::string& CellView::profile() const {
  return inside_.motions->profile();
}

}  // namespace polyarm::cell
