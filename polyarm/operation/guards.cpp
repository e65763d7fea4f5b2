#include "polyarm/operation/guards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "polyarm/operation/guard_work.hpp"
#include "polyarm/operation/watches.hpp"

namespace polyarm::cell {

using surroundings::GuardBodies;
using surroundings::GuardPair;
using surroundings::LookAhead;

namespace {
/// From the look to the first cycle that obeys it, s.
constexpr double kLatency = 0.006;
/// Below this pace a robot stops; it goes on above kGoOn.
constexpr double kStop = 0.02, kGoOn = 0.06;
/// How long a robot stands before something that may move away by itself before the cell is held, ns: a part
/// or a mover, robots that wait for each other, and a robot that does nothing.
constexpr Nanoseconds kForThings = 1'000'000'000, kForEachOther = 1'000'000'000, kForRobots = 30'000'000'000;
/// Robots in step that were slowed down come together again at this rate, 1/s.
constexpr double kCatchUp = 4;
/// A trajectory of points does not come to rest faster, s of its own time.
constexpr double kStopOfPoints = 0.06;
constexpr std::size_t kSamples = 8;  // of the velocities ahead
/// More robots have no guards: their bodies alone would take long to make.
constexpr std::size_t kMostRobots = 100;
}  // namespace

Guards::Guards(const Owners& cell) : cell_(cell), work_(std::make_unique<Work>()) {
  const CellOptions& options = cell.setup.options;
  work_->off = !cell.setup.file.guards.on || (options.allow_contact && !options.contact_errors);
  work_->robots.resize(cell.setup.robots.size());
  for (std::size_t r = 0; r < work_->robots.size(); ++r) {
    Of& of = work_->robots[r];
    of.axes = axes_of(*cell.setup.robots[r]);
    for (std::vector<double>* values :
         {&of.velocity, &of.before, &of.q, &of.v, &of.last, &of.step_size, &of.braking_way})
      values->assign(of.axes.size(), 0);
    of.rates.emplace(of.axes.size());
  }
  cell_.jogging.set_barrier_names([this](std::size_t robot, std::int32_t which) {
    return which < 0 ? std::string() : obstacle_of(robot, static_cast<std::size_t>(which));
  });
  cell_.jogging.set_base_guard(
      [this](std::size_t robot, double ahead, double turn) { return share_of_base(robot, ahead, turn); });
}

Guards::~Guards() = default;

double Guards::pace(std::size_t robot) const {
  return work_->robots[robot].pace;
}

std::uint64_t Guards::measured() const {
  return work_->bodies ? work_->bodies->measured() : 0;
}

std::optional<Guards::Near> Guards::near(std::size_t r) const {
  if (work_->off || !work_->bodies || !work_->bodies->has_looked() || work_->models == nullptr)
    return std::nullopt;
  if (!needed()) return std::nullopt;  // the bodies are not where they were seen
  const Of& of = work_->robots[r];
  const bool stands_before = of.goal != 0 && of.pace < 1 && of.ahead_of.pair >= 0;
  GuardBodies::Nearest found = work_->bodies->nearest(static_cast<int>(r), kFarthest);
  if (found.pair < 0) return std::nullopt;
  const GuardPair& pair = work_->bodies->pairs()[static_cast<std::size_t>(found.pair)];
  const bool first = pair.robot_a == static_cast<int>(r);
  Near out{work_->bodies->name(first ? pair.a : pair.b),
           work_->bodies->name(first ? pair.b : pair.a),
           found.gap.distance,
           found.gap.on_a,
           found.gap.on_b,
           stands_before ? of.ahead_of.required : 0};
  if (!first) std::swap(out.on_mine, out.on_other);
  return out;
}

std::optional<double> Guards::clearance_at(std::size_t r, std::span<const double> q) const {
  if (work_->off || !work_->bodies || !work_->bodies->has_looked() || work_->bodies->drives(r))
    return std::nullopt;
  work_->bodies->try_joints(r, q);
  return work_->bodies->nearest(static_cast<int>(r), kFarthest, true).gap.distance;
}

const std::vector<Problem>& Guards::would_stop() const {
  return work_->would_stop;
}

/// True if guards only note where they would stop a robot.
bool Guards::listens() const {
  return cell_.setup.options.allow_contact;
}

/// True if a planned path that stands in the world, or a person who jogs, moves the robot.
bool Guards::is_planned(std::size_t r) const {
  const moves::RobotMotion* motion = cell_.motions.motion(r);
  return (motion && !motion->idle() && !motion->riding()) || cell_.jogging.engaged(r) || points(r);
}

/// True if something else moves the robot, and that is guarded: another program, or a belt.
bool Guards::is_unplanned(std::size_t r) const {
  return cell_.setup.file.guards.others && !is_planned(r) && work_->robots[r].rates->move();
}

bool Guards::needed() const {
  for (std::size_t r = 0; r < work_->robots.size(); ++r) {
    const moves::RobotMotion* motion = cell_.motions.motion(r);
    if ((motion && !motion->idle() && cell_.setup.file.guards.moves) || cell_.jogging.engaged(r) ||
        points(r) || is_unplanned(r) || base_drives(r))
      return true;
  }
  return false;
}

/// Bodies are made on the planning thread, before it plans the first move: that reads the disk. In lock-step
/// they are made when a robot first moves.
void Guards::prepare() {
  if (!work_->off && !work_->bodies && !work_->making && !cell_.setup.options.lock_step) begin_bodies();
}

void Guards::set_more(std::vector<description::Fixture> more,
                      std::vector<surroundings::AttachedThing> attached) {
  if (work_->off) return;
  work_->more = std::move(more);
  work_->attached = std::move(attached);
  work_->has_news = true;
}

void Guards::begin_bodies() {
  work_->making = std::make_shared<Work::Making>();
  work_->making->reduced = is_reduced();
  work_->making->attached = work_->attached;
  work_->has_news = false;
  cell_.planner.post([making = work_->making, shared = cell_.motions.bodies(), robots = work_->robots.size(),
                      zones = zones_of(cell_.setup, is_reduced()), more = work_->more] {
    try {
      if (robots > kMostRobots)
        throw Error("too-many-bodies", fmt::format("{} robots are more than guards can follow", robots));
      making->models = shared->get();
      auto scene = std::make_shared<description::Scene>(making->models->scene);
      scene->fixtures.insert(scene->fixtures.end(), more.begin(), more.end());
      for (const surroundings::AttachedThing& thing : making->attached) {
        scene->parts.emplace_back();
        scene->parts.back().name = thing.name;
        scene->parts.back().shape = thing.shape;
      }
      making->bodies = std::make_unique<GuardBodies>(making->models->robots, *scene, zones);
      making->scene = std::move(scene);
    } catch (const std::exception& why) {
      making->failed = why.what();
    }
    making->done.store(true, std::memory_order_release);
  });
}

bool Guards::take_bodies() {
  Work& work = *work_;
  if (work.bodies) return true;
  if (!work.making) begin_bodies();
  if (!work.making->done.load(std::memory_order_acquire)) return false;
  if (!work.making->failed.empty()) {
    work.off = true;
    cell_.observer.on_problem(cell_.machine.now(),
                              {"no-guards",
                               {},
                               "nothing guards the robots against contacts: " + work.making->failed,
                               "use fewer robots or simpler bodies, or write guards: off",
                               Severity::warning,
                               {}});
    return false;
  }
  begin_guards();
  return true;
}

/// Bodies that were made because of new things replace those that there are.
void Guards::take_more() {
  Work& work = *work_;
  if (!work.bodies) return;
  if (work.reduced != is_reduced() && !work.making && has_zones_of_profiles(cell_.setup))
    work.has_news = true;
  if (work.making) {
    if (!work.making->done.load(std::memory_order_acquire)) return;
    if (work.making->failed.empty()) return begin_guards();
    cell_.observer.on_note("guards do not know the new objects: " + work.making->failed);
    work.making.reset();
  }
  if (work.has_news) begin_bodies();
}

/// Guards begin anew with bodies that have been made.
void Guards::begin_guards() {
  Work& work = *work_;
  for (Of& of : work.robots) of.ahead.reset(), of.jogged.reset();  // they refer to the bodies before
  work.bodies = std::move(work.making->bodies);
  work.scene = std::move(work.making->scene);
  work.models = std::move(work.making->models);
  work.reduced = work.making->reduced;
  work.held = std::move(work.making->attached);
  work.making.reset();
  work.stopping.clear();
  const GuardsEntry& entry = cell_.setup.file.guards;
  for (std::size_t r = 0; r < work.robots.size(); ++r) {
    Of& of = work.robots[r];
    work.stopping.emplace_back(of.axes.size(), 0.0);
    of.anew = true;  // what slowed its motion down may be gone, and then it goes on
    of.ahead_of = {};
    const int robot = static_cast<int>(r);
    surroundings::LookAheadOptions options{.clearance = entry.clearance};
    if (!cell_.setup.options.lock_step) options.at_first = 1;  // spread over some ticks
    if (!work.bodies->drives(r)) {
      of.ahead = std::make_unique<LookAhead>(*work.bodies, robot, options);
      of.jogged = std::make_unique<jog::BodyGuard>(*work.bodies, robot, of.axes,
                                                   jog::BodyGuardOptions{entry.clearance});
    }
  }
}

void Guards::tick() {
  if (work_->off || cell_.life.failure()) return;
  if (cell_.machine.snapshot().states.empty()) return;  // before the first cycle
  see_moment();
  take_more();
  const bool is_needed = needed();
  if ((!is_needed && (work_->bodies || cell_.setup.options.lock_step)) || !take_bodies() || !is_needed)
    return;
  see_attached();
  work_->bodies->look(work_->moment);
  for (std::size_t r = 0; r < work_->robots.size(); ++r) see(r);
  for (std::size_t r = 0; r < work_->robots.size(); ++r) find_stopping(r);
  for (std::size_t r = 0; r < work_->robots.size(); ++r) look_along(r);
  if (listens()) {
    for (std::size_t r = 0; r < work_->robots.size(); ++r) note_stop(r);
    return;
  }
  set_paces();
  for (std::size_t r = 0; r < work_->robots.size(); ++r) fill_barriers(r);
  for (std::size_t r = 0; r < work_->robots.size(); ++r) judge(r);
  for (std::size_t r = 0; r < work_->robots.size(); ++r) look_at_braking(r);
  for (std::size_t r = 0; r < work_->robots.size(); ++r) look_at_base(r);
}

/// True in the reduced profile.
bool Guards::is_reduced() const {
  return cell_.motions.profile() == "reduced";
}

/// Where everything is, and how fast the joints move.
void Guards::see_moment() {
  const Nanoseconds now = cell_.machine.now();
  const double dt = seconds(now - work_->seen);
  const bool follows = work_->seen >= 0 && dt > 0 && dt < 0.05;
  work_->seen = now;
  cell_.motions.moment(work_->moment);
  for (std::size_t r = 0; r < work_->robots.size(); ++r) {
    Of& of = work_->robots[r];
    const std::vector<double>& q = work_->moment.robots[r].joints;
    see_base(r);
    for (std::size_t j = 0; j < of.velocity.size() && j < q.size(); ++j) {
      of.velocity[j] = follows ? (q[j] - of.before[j]) / dt : 0;
      of.before[j] = q[j];
    }
    if (is_planned(r)) of.rates->forget();  // its end is known, and no reason to stop afterwards
    of.rates->add(now, q);
  }
}

/// The motion of a robot.
void Guards::see(std::size_t r) {
  Of& of = work_->robots[r];
  const moves::RobotMotion* motion = cell_.motions.motion(r);
  // A path that is moved with a belt is not where it was planned: its robot is judged by its velocity
  // (is_unplanned).
  const bool planned = motion && !motion->riding() && cell_.setup.file.guards.moves;
  const auto now = planned ? motion->under_way() : std::nullopt;
  if (!now && see_points(r)) return;
  of.by_points = false;
  if (!now) {
    of.goal = 0;
    of.pace = of.wanted = 1;
    of.zones.begin();
    return;
  }
  of.along = &of.way;
  of.way.set(*now->motion, *now->robot);
  const moves::MovePlanOptions* const with = motion->options_under_way();
  of.facts = now->robot;
  of.looks_at_zones = with && with->reduced != is_reduced();
  if (!of.looks_at_zones) of.zones.begin();  // who is outside when the profile changes may return
  of.step = now->step;
  of.time = now->begun ? now->time : 0;
  of.speed = now->begun ? std::abs(now->speed) : 1;
  of.duration = now->motion->path.duration();
  const bool is_new = std::exchange(of.goal, now->goal) != now->goal,
             looks_anew = std::exchange(of.anew, false);
  if (!is_new && !looks_anew) return;
  if (is_new) {
    of.pace = 1;
    of.slowed = of.reported = false;
    of.stands_since = -1;
    of.zones.begin();
  }
  if (!of.ahead) return;
  std::vector<double> ends;
  for (const double end : now->motion->ends) ends.push_back(now->motion->path.profile().time_at(end));
  // The present move is the first one whose end is still ahead.
  const std::uint64_t present = motion->move_under_way();
  const std::size_t past =
      static_cast<std::size_t>(std::count_if(ends.begin(), ends.end(), [&](double end) { return end < of.time; }));
  std::vector<surroundings::TouchTime> touches;
  for (std::size_t k = past; k < ends.size(); ++k)
    if (cell_.programs.touches(*motion, present + (k - past)))
      touches.push_back({k == 0 ? 0 : ends[k - 1], ends[k]});
  if (!touches.empty() && past + touches.size() == ends.size()) touches.back().to = of.duration;
  of.ahead->begin(of.way, ends, touches);
}

/// How far the joints still move if the robot begins to brake now.
void Guards::find_stopping(std::size_t r) {
  Of& of = work_->robots[r];
  std::vector<double>& stopping = work_->stopping[r];
  const std::size_t n = of.axes.size();
  GuardBodies& bodies = *work_->bodies;
  bodies.forget_ahead(r);
  if (of.goal == 0) {
    if (!cell_.jogging.engaged(r) &&
        std::all_of(of.velocity.begin(), of.velocity.end(), [](double v) { return v == 0; }))
      bodies.stands(r);
    for (std::size_t j = 0; j < n; ++j)
      stopping[j] = of.velocity[j] == 0 && !cell_.jogging.engaged(r)
                        ? 0
                        : jog::stopping_reach(of.velocity[j], of.axes[j]);
    return;
  }
  double longest = 0;  // s in which any joint stops from its highest speed
  of.braking = {};
  for (const jog::AxisLimits& axis : of.axes) {
    longest = std::max(longest, axis.velocity / axis.acceleration);
    of.braking.plain = std::max(of.braking.plain, axis.acceleration / axis.jerk + kLatency);
  }
  longest += of.braking.plain;
  for (std::size_t k = 0; k <= kSamples; ++k) {
    of.along->at(of.time + longest * static_cast<double>(k) / kSamples, of.q, of.v);
    for (std::size_t j = 0; j < n; ++j)
      of.braking.square = std::max(of.braking.square, std::abs(of.v[j]) / of.axes[j].acceleration);
  }
  constexpr std::size_t kPlaces = GuardBodies::kAhead;
  if (work_->robots.size() == 1) return;  // nobody asks where it will be
  const double h = of.braking.at(std::max(of.speed, of.pace)) / kPlaces;
  std::fill(stopping.begin(), stopping.end(), 0.0);
  of.along->at(of.time, of.q, of.v);
  std::vector<double>& from = of.q;
  of.last = from;
  for (std::size_t k = 1; k <= kPlaces; ++k) {
    std::vector<double>& to = of.v;
    of.along->at(of.time + h * static_cast<double>(k), to, {});
    for (std::size_t j = 0; j < n; ++j) {
      const double bend = of.axes[j].acceleration * h * h / 8;
      stopping[j] = std::max(stopping[j], std::abs(to[j] - from[j]) + bend);
      of.step_size[j] = std::abs(to[j] - of.last[j]) + bend;
      of.last[j] = to[j];
    }
    bodies.add_ahead(r, to, of.step_size);
  }
}

void Guards::look_along(std::size_t r) {
  Of& of = work_->robots[r];
  of.wanted = 1;
  of.crossing.clear();
  if (of.goal == 0) return;
  const double slow =
      std::max(of.ahead ? of.ahead->speed() : 0, 0.05);  // m per s of the plan, of the last look
  const double longer =
      of.by_points ? kStopOfPoints : std::min(1.0, cell_.setup.file.guards.slow_from / slow);
  const double until = of.time + of.braking.at(1) + longer;
  of.ahead_of = of.ahead ? of.ahead->look(*of.along, of.time, until, work_->stopping)
                         : LookAhead::Answer{std::numeric_limits<double>::infinity()};
  look_at_zones(r, until);
  if (!std::isfinite(of.ahead_of.free_until)) return;
  if (of.by_points) {
    const bool known = of.ahead_of.pair >= 0 || !of.crossing.empty();
    of.wanted = known && of.ahead_of.free_until < until ? 0 : 1;
    return;
  }
  of.wanted = of.braking.pace_for(of.ahead_of.free_until - of.time, longer);
  if (of.wanted < (of.pace > 0 ? kStop : kGoOn)) of.wanted = 0;
}

/// Robots in step slow down together; one that is ahead of the others waits for them.
void Guards::set_paces() {
  std::vector<Of>& robots = work_->robots;
  for (std::size_t r = 0; r < robots.size(); ++r) {
    Of& of = robots[r];
    if (of.goal == 0 || of.by_points) continue;
    double pace = of.wanted, behind = of.time;
    for (const Of& other : robots) {
      if (!of.step || other.goal == 0 || other.step != of.step) continue;
      pace = std::min(pace, other.wanted);
      of.slowed = of.slowed || other.wanted < 1;
      if (std::abs(other.duration - of.duration) < 1e-6 * of.duration) behind = std::min(behind, other.time);
    }
    of.slowed = of.slowed || pace < 1;
    if (of.slowed && of.step) pace *= std::clamp(1 - kCatchUp * (of.time - behind), 0.2, 1.0);
    of.pace = pace;
    if (of.slowed) cell_.motions.motion(r)->set_pace(pace);
  }
}

void Guards::fill_barriers(std::size_t r) {
  Of& of = work_->robots[r];
  if (!of.jogged || !cell_.jogging.engaged(r)) return;
  jog::Barriers* const draft = cell_.jogging.draft_barriers(r);
  if (!draft) return;
  of.jogged->fill(of.velocity, work_->stopping, *draft);
  cell_.jogging.publish_barriers(r);
}

// --- what stands in the way -------------------------------------------------------------------------------

std::string Guards::obstacle_of(std::size_t robot, std::size_t index) const {
  if (!work_->bodies || index >= work_->bodies->pairs().size()) return {};
  const GuardPair& pair = work_->bodies->pairs()[index];
  return work_->bodies->name(pair.robot_a == static_cast<int>(robot) ? pair.b : pair.a);
}

std::string Guards::text_of(std::size_t r) const {
  const Of& of = work_->robots[r];
  const GuardPair& pair = work_->bodies->pairs()[static_cast<std::size_t>(of.ahead_of.pair)];
  const bool first = pair.robot_a == static_cast<int>(r);
  const surroundings::GuardGap& gap = of.ahead_of.gap;
  const Vec3 point = 0.5 * (gap.on_a + gap.on_b);
  const std::string& mine = work_->bodies->name(first ? pair.a : pair.b);
  const std::string& other = work_->bodies->name(first ? pair.b : pair.a);
  const std::string place = fmt::format("({:.3f}, {:.3f}, {:.3f})", point.x, point.y, point.z);
  if (of.ahead_of.required < 5e-5 || gap.distance < 5e-5) return mine + " would touch " + other + " at " + place;
  return fmt::format("{} would come within {:.1f} mm of {} at {}, {:.1f} mm are kept", mine, 1e3 * gap.distance, other,
                     place, 1e3 * of.ahead_of.required);
}

/// True if a robot waits for another one that waits for it, over any number of robots.
bool Guards::deadlocked(std::size_t robot) const {
  std::size_t at = robot;
  for (std::size_t i = 0; i < work_->robots.size(); ++i) {
    const Of& of = work_->robots[at];
    if (of.goal == 0 || of.pace > 0 || of.ahead_of.pair < 0 || !std::isfinite(of.ahead_of.free_until))
      return false;
    const int next =
        work_->bodies->pairs()[static_cast<std::size_t>(of.ahead_of.pair)].other_than(static_cast<int>(at));
    if (next < 0 || next == static_cast<int>(at)) return false;
    const Of& other = work_->robots[static_cast<std::size_t>(next)];
    if (of.step && other.goal != 0 && other.step == of.step) return true;  // in step it stands because this one does
    at = static_cast<std::size_t>(next);
    if (at == robot) return true;
  }
  return false;
}

namespace {
bool is_of_pair(std::string_view code) {
  return code == "guard" || code == "guard-deadlock";
}

const char* advice_for(std::string_view code) {
  if (code == "guard-workspace")
    return "change the profile or 'workspace' in the cell file, or move the points";
  if (code == "guard-crowded")
    return "jog the robot out of there, or go another way; fewer bodies, or larger ones in place of many "
           "small ones, take less time to measure";
  return "clear the way and resume, or move the points or the obstacle";
}
}  // namespace

Problem Guards::problem_of(std::size_t r, const char* code, const std::string& text) const {
  const moves::RobotMotion* const motion = cell_.motions.motion(r);
  const Of& of = work_->robots[r];
  Problem problem{code,
                  motion && of.goal != 0 && !of.by_points
                      ? cell_.programs.place_of(*motion, motion->move_under_way())
                      : Location{},
                  text,
                  advice_for(code),
                  Severity::error,
                  {{"robot", cell_.setup.robots[r]->entry.name}}};
  // The values of the nearest pair belong to "guard" and "guard-deadlock": other stops have no pair.
  if (of.ahead_of.pair >= 0 && is_of_pair(code)) {
    const GuardPair& pair = work_->bodies->pairs()[static_cast<std::size_t>(of.ahead_of.pair)];
    problem.facts.push_back({"a", work_->bodies->name(pair.a)});
    problem.facts.push_back({"b", work_->bodies->name(pair.b)});
    problem.facts.push_back({"distance_m", of.ahead_of.gap.distance});
    problem.facts.push_back({"clearance_m", of.ahead_of.required});
  }
  return problem;
}

void Guards::stop_before(std::size_t r, const char* code, const std::string& text) {
  Problem problem = problem_of(r, code, text);
  if (!recovered_by_others(cell_.setup, cell_.programs)) return cell_.life.fail(std::move(problem));
  cell_.observer.on_problem(cell_.machine.now(), problem);
  cell_.machine.hold_for(std::move(problem));
}

bool Guards::runs() const {
  return cell_.machine.snapshot().state == control::RunState::running &&
         cell_.machine.supervisor().latch().requested() == realtime::StopKind::none;
}

/// Stops a robot whose plan is not known when its braking would end too near to something.
void Guards::look_at_braking(std::size_t r) {
  Of& of = work_->robots[r];
  if (!of.jogged || of.goal != 0 || !is_unplanned(r) || !runs()) return;
  of.rates->stopping(of.axes, kLatency, of.braking_way);
  double most = 0;
  for (const double by : of.braking_way) most = std::max(most, std::abs(by));
  // After a stop the robot may go the same way again: it is judged as fast as it was.
  if (most > 0 && most < of.stopped_way)
    for (double& by : of.braking_way) by *= of.stopped_way / most;
  const jog::BodyGuard::InTheWay found = of.jogged->in_the_way(of.braking_way, work_->stopping);
  of.stopped_way = found.pair < 0 ? 0 : std::max(of.stopped_way, most);
  if (found.pair < 0) return;
  of.ahead_of = {0, found.pair, found.gap, found.required};
  stop_before(r, "guard", cell_.setup.robots[r]->entry.name + " stopped before a contact: " + text_of(r));
}

/// Notes where a robot would stand before something that does not move away by itself.
void Guards::note_stop(std::size_t r) {
  constexpr double kHere = 0.004;  // s of the plan: the robot is there in this tick or the next one
  const Of& of = work_->robots[r];
  if (of.goal == 0 || of.ahead_of.pair < 0 || !(of.ahead_of.free_until - of.time <= kHere)) return;
  const GuardPair& pair = work_->bodies->pairs()[static_cast<std::size_t>(of.ahead_of.pair)];
  if (!pair.own && pair.other_than(static_cast<int>(r)) >= 0) return;  // it waits
  Problem problem = problem_of(
      r, "guard", cell_.setup.robots[r]->entry.name + " would be stopped before a contact: " + text_of(r));
  problem.advice = "move the points or the obstacle, or let the move go around it: `around true`";
  problem.facts.push_back({"at_s", seconds(cell_.machine.now())});
  problem.facts.push_back({"doing", "check"});
  const auto is_same = [&](const Problem& other) {
    return other.where.text() == problem.where.text() && other.facts[1].value == problem.facts[1].value &&
           other.facts[2].value == problem.facts[2].value;
  };
  std::vector<Problem>& noted = work_->would_stop;
  if (std::none_of(noted.begin(), noted.end(), is_same)) noted.push_back(std::move(problem));
}

/// Holds the cell when a robot stands before something that does not move away by itself.
void Guards::judge(std::size_t r) {
  Of& of = work_->robots[r];
  const Nanoseconds now = cell_.machine.now();
  const bool blocked = runs() && of.goal != 0 && of.wanted == 0 && (of.by_points || of.speed == 0);
  if (!blocked) {
    of.stands_since = -1;
    of.reported = false;
    return;
  }
  if (of.stands_since < 0) of.stands_since = now;
  const Nanoseconds stands = now - of.stands_since;
  const std::string& name = cell_.setup.robots[r]->entry.name;
  if (!of.crossing.empty())
    return stop_before(r, "guard-workspace",
                       name + " stopped before it leaves the workspace: " + of.crossing);
  if (of.by_points) return stop_before(r, "guard", name + " stopped before a contact: " + text_of(r));
  if (of.ahead_of.pair < 0) {  // more is near than one tick can measure
    const std::string text = name + " stands: more bodies are near its path than a guard can measure in a tick";
    if (stands >= kForThings && !std::exchange(of.reported, true)) cell_.observer.on_note(text);
    if (stands >= kForRobots) stop_before(r, "guard-crowded", text);
    return;
  }
  const GuardPair& pair = work_->bodies->pairs()[static_cast<std::size_t>(of.ahead_of.pair)];
  const int other = pair.own ? -1 : pair.other_than(static_cast<int>(r));
  if (other < 0) {
    const bool fixed =
        pair.own || work_->bodies->is_static(pair.robot_a == static_cast<int>(r) ? pair.b : pair.a);
    if (fixed || stands >= kForThings)
      stop_before(r, "guard", name + " stopped before a contact: " + text_of(r));
    return;
  }
  const std::string& whom = cell_.setup.robots[static_cast<std::size_t>(other)]->entry.name;
  if (deadlocked(r)) {
    if (stands >= kForEachOther)
      stop_before(r, "guard-deadlock", name + " and " + whom + " wait for each other: " + text_of(r));
    return;
  }
  if (!std::exchange(of.reported, true))
    cell_.observer.on_note(name + " waits for " + whom + ": " + text_of(r));
  if (stands >= kForRobots && cell_.motions.idle(static_cast<std::size_t>(other)))
    stop_before(r, "guard", name + " stopped before a contact: " + text_of(r));
}

}  // namespace polyarm::cell
