#include "polyarm/machine/cell_data.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "polyarm/setup/build.hpp"
#include "polyarm/setup/cell_reach.hpp"

namespace polyarm::cell {

namespace {
/// The pose range given by the workspace's inside boxes; used for poses from outside without a range of their
/// own.
signals::PoseRange range_of(const std::vector<moves::WorkspaceZone>& workspace) {
  signals::PoseRange out;
  for (const moves::WorkspaceZone& zone : workspace) {
    if (zone.kind != moves::ZoneKind::inside) continue;
    const double a[] = {zone.low.x, zone.low.y, zone.low.z}, b[] = {zone.high.x, zone.high.y, zone.high.z};
    for (std::size_t k = 0; k < 3; ++k) {
      out.lower[k] = std::max(out.lower[k], std::min(a[k], b[k]));
      out.upper[k] = std::min(out.upper[k], std::max(a[k], b[k]));
    }
  }
  return out;
}

/// Limits poses from outside, in files and over links, to the range of their point, otherwise to the
/// workspace.
void bound_poses(signals::Signals& signals, const std::vector<moves::WorkspaceZone>& zones,
                 DataFiles& files) {
  const signals::PoseRange workspace = range_of(zones), wide;
  const auto range = [workspace, points = signals.points](const std::string& name) {
    const auto stated = points.find(name);
    return stated == points.end() ? workspace : stated->second;
  };
  files.check_poses([range](const std::string& name, const Pose& pose) { return range(name).refuses(pose); });
  for (signals::LinkEntry& link : signals.links)
    for (signals::LinkTag& tag : link.tags)
      if (tag.within.lower == wide.lower && tag.within.upper == wide.upper) tag.within = range(tag.name);
}
}  // namespace

namespace {
/// Wait for another run in the same folder, ms; batch runs follow each other.
constexpr int kBatchTimeout = 30'000, kLiveTimeout = 500, kNeverWaits = -1;

/// Robots without a cell have no folder of their own, so any number of runs is possible at the same time.
int timeout_of(const CellFile& file, bool lock_step) {
  const std::string kind = file.path.extension().string();
  const bool has_folder = (kind == ".yaml" || kind == ".yml") && !file.launched;
  return !has_folder ? kNeverWaits : lock_step ? kBatchTimeout : kLiveTimeout;
}
}  // namespace

void CellData::add_own_states() {
  pass_state_ = states_.add("program/pass");
  running_state_ = states_.add("program/running");
  line_state_ = states_.add("program/line");
  held_state_ = states_.add("cell/held");
  fault_state_ = states_.add("cell/fault");
  for (const auto& robot : setup_.robots)
    tcp_states_.push_back({states_.add(robot->entry.name + "/tcp/x"),
                           states_.add(robot->entry.name + "/tcp/y"),
                           states_.add(robot->entry.name + "/tcp/z")});
}

void CellData::add_cameras(Problems& problems) {
  for (const signals::CameraLink& link : signals_.cameras) {
    if (!link.on.empty() && std::none_of(setup_.robots.begin(), setup_.robots.end(),
                                         [&](const auto& robot) { return robot->entry.name == link.on; }))
      problems.error("unknown-robot", link.where,
                     "the cell has no robot '" + link.on + "' to carry the camera");
    cameras_.emplace_back(Camera::Setup{link.camera, link.point, link.request, link.done, link.noise,
                                        link.seed, link.on, link.mount, link.view, link.reach},
                          setup_.scene);
  }
}

void CellData::build(const hardware::InterfaceTable& table, Worker& worker, Problems& problems) {
  const CellFile& file = setup_.file;
  const CellOptions& options = setup_.options;
  add_own_states();
  collect(problems, [&] {
    if (!file.signals.empty())
      signals_ = signals::load_signals(file_of_cell(file, file.signals, file.signals_where));
  });
  check_live(file, signals_, problems);
  if (!options.lock_step || options.links) admit_links(file, signals_, problems);
  if (!options.lock_step || options.links) admit_streams(file, problems);
  if (!options.lock_step) admit_doors(file, problems);
  std::set<std::string> live(signals_.live.begin(), signals_.live.end());
  if (options.test) live.clear();  // a test writes to none of the user's files
  files_ = std::make_unique<DataFiles>(
      store,
      StateFolder(file.folder, live, options.keep, options.state_folder, timeout_of(file, options.lock_step),
                  file.path.filename().string()),
      worker, options.lock_step);
  bound_poses(signals_, file.workspace, *files_);
  for (const signals::LinkEntry& link : signals_.links) {  // before the tags that are bound to these states
    states_.add("link/" + link.name + "/up");
    states_.add("link/" + link.name + "/losses");
  }
  tags_ = std::make_unique<TagBinding>(signals_.tags, table, states_, store, problems);
  add_cameras(problems);
}

void CellData::offer_named_states() {
  for (const auto& robot : setup_.robots)
    for (const auto& [state, positions] : robot->model.named_states)
      store.set(setup_.robots.size() == 1 ? state : robot->entry.name + "_" + state,
                joint_state(robot->model, positions), robot->entry.name);
}

void CellData::connect_links(Problems& problems) {
  const CellOptions& options = setup_.options;
  links_ = std::make_unique<CellLinks>(signals_, states_, store, options.lock_step,
                                       options.lock_step && !options.links, problems);
  heartbeats_ = std::make_unique<Heartbeats>(signals_, store, problems);
}

void CellData::set_own(const OwnStates& states) {
  states_.set(pass_state_, states.passes);
  states_.set(running_state_, states.running ? 1 : 0);
  states_.set(line_state_, states.line);
  states_.set(held_state_, states.held ? 1 : 0);
  states_.set(fault_state_, states.fault ? 1 : 0);
  for (std::size_t i = 0; i < states.tcps.size(); ++i) {
    states_.set(tcp_states_[i][0], states.tcps[i].x);
    states_.set(tcp_states_[i][1], states.tcps[i].y);
    states_.set(tcp_states_[i][2], states.tcps[i].z);
  }
}

void CellData::read(Nanoseconds now, const control::Snapshot& snapshot, const OwnStates& states) {
  set_own(states);
  links_->read(now);
  tags_->read(snapshot.states, states_);
  heartbeats_->tick(now, snapshot.cycle.index, store);
}

const std::optional<Problem>& CellData::watch_links(Nanoseconds now) {
  for (const Problem& problem : links_->take_reports()) observer_.on_problem(now, problem);
  if (!links_ready_) {
    links_ready_ = links_->ready();
    if (!links_ready_ && now > 1'000'000'000 && !std::exchange(reported_waiting_, true))
      for (const CellLinks::Status& link : links_->status())
        if (!link.state.was_up && link.entry->on_loss == signals::LinkEntry::OnLoss::hold)
          observer_.on_problem(now, {"link-awaited",
                                     {},
                                     "the programs begin when the link '" + link.entry->name +
                                         "' is connected: " + link.state.reason,
                                     "start the other side; polyarm tags shows every link and tag",
                                     Severity::warning,
                                     {{"link", link.entry->name}, {"reason", link.state.reason}}});
  }
  const std::optional<Problem> lost = links_->lost();
  missing_ = lost ? lost : heartbeats_->stopped();
  return missing_;
}

void CellData::write(Nanoseconds now, const control::Snapshot& snapshot, bool over) {
  signals::Situation situation;
  situation.stopped = over && snapshot.standing;
  situation.held = snapshot.state == control::RunState::held || snapshot.state == control::RunState::fault;
  situation.link_lost = missing_ || links_->any_down();
  tags_->write(situation);
  links_->write(situation);
  if (!situation.stopped) stopped_at_ = -1;
  if (situation.stopped && stopped_at_ < 0) stopped_at_ = now;
}

void CellData::exchange_files(Nanoseconds now) {
  files_->exchange(now);
  for (const Problem& problem : files_->take_warnings()) observer_.on_problem(now, problem);
}

bool CellData::outputs_settled(Nanoseconds now) const {
  constexpr Nanoseconds kHardware = 6'000'000, kFarSide = 500'000'000;  // three ticks; a link's device
  const bool ruled = std::any_of(signals_.tags.begin(), signals_.tags.end(),
                                 [](const signals::Tag& tag) { return tag.rules.on_stop.has_value(); });
  if (stopped_at_ < 0 || (!ruled && !links_->any())) return true;
  return now - stopped_at_ > kHardware && (links_->idle() || now - stopped_at_ > kFarSide);
}

void CellData::report_changes(Nanoseconds now) {
  if (store.version() == reported_version_) return;
  for (const data::Change& change : store.changes_since(reported_version_))
    if (change.now && change.old && change.who != "state")
      observer_.on_tag(now, change.name, change.now->text(), change.who);
  reported_version_ = store.version();
}

}  // namespace polyarm::cell
