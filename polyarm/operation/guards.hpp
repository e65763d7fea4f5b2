#pragma once
/// Guards of a running cell: they slow robots down and stop them before contacts, on planned moves, while
/// they are jogged and with streamed targets. A help for people and programs, not a safety function. Metres,
/// radians, seconds. Cell thread.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/machine/motions.hpp"
#include "polyarm/operation/jogging.hpp"

namespace polyarm::cell {

class LifeCycle;
class Programs;

/// Each robot is guarded along the path on which it would brake; one whose plan is not known (trajectories
/// and commands of other programs) along the straight line on which it would. Of other robots it counts where
/// they are and how far they still go until they stand: so two never meet, and one waits for the other. A
/// move that something blocks is held (a run that nobody watches has failed); a robot in the way is waited
/// for.
class Guards {
 public:
  struct Owners {
    const CellSetup& setup;
    Machine& machine;
    Motions& motions;
    const Programs& programs;
    Jogging& jogging;
    LifeCycle& life;
    Worker& planner;
    Observer& observer;
  };
  explicit Guards(const Owners& cell);
  ~Guards();

  /// Call each tick before programs run: on the wall clock it begins to make the bodies, before the first plan.
  void prepare();
  /// Call each tick, after new moves were handed over.
  void tick();
  /// The pace at which the guard lets a robot's move go on, 0 to 1.
  double pace(std::size_t robot) const;
  /// More things that robots are kept off, in addition to the scene, and things that robots hold: objects of
  /// MoveIt's clients. They replace those before; the guards know them some ticks later.
  void set_more(std::vector<description::Fixture> more,
                std::vector<surroundings::AttachedThing> attached = {});
  /// What is nearest to a robot that moves, for people: names of both bodies and the places between which it
  /// is.
  struct Near {
    std::string mine, other;
    double distance = 0;
    Vec3 on_mine, on_other;
    double kept = 0;  ///< of a planned move that is slowed down: the distance that is kept there; else 0
  };
  std::optional<Near> near(std::size_t robot) const;
  /// The distance of a robot with its joints at `q` from everything else as it is now, m, at most kFarthest;
  /// empty while there are no guards.
  static constexpr double kFarthest = 0.15;
  std::optional<double> clearance_at(std::size_t robot, std::span<const double> q) const;
  /// In a cell whose contacts are listed instead of stopping it (CellOptions::contact_errors): where the
  /// guards would have stopped a robot, once for each pair in a line; errors "guard" {robot, a, b,
  /// distance_m, clearance_m, at_s, doing}.
  const std::vector<Problem>& would_stop() const;
  /// Exact distances of convex pieces that were computed so far.
  std::uint64_t measured() const;

 private:
  struct Work;
  struct Of;
  bool needed() const;
  bool listens() const;
  bool is_reduced() const;
  void see_moment();
  void see_attached();
  void see_base(std::size_t robot);
  bool base_drives(std::size_t robot) const;
  bool has_moved_since_drive(std::size_t r, std::size_t k) const;
  BaseShare share_of_base(std::size_t robot, double ahead, double turn);
  struct NearBase;
  struct BaseWay;
  NearBase near_base(std::size_t robot, const Vec3& velocity, double turning, const BaseWay& way) const;
  double braking_of_base(std::size_t robot) const;
  void look_at_base(std::size_t robot);
  std::optional<Motions::Points> points(std::size_t robot) const;
  bool see_points(std::size_t robot);
  void look_at_zones(std::size_t robot, double until);
  bool is_planned(std::size_t robot) const;
  bool is_unplanned(std::size_t robot) const;
  void begin_bodies();
  bool take_bodies();
  void take_more();
  void begin_guards();
  void see(std::size_t robot);
  void find_stopping(std::size_t robot);
  void look_along(std::size_t robot);
  void set_paces();
  void fill_barriers(std::size_t robot);
  void judge(std::size_t robot);
  void look_at_braking(std::size_t robot);
  void note_stop(std::size_t robot);
  bool runs() const;
  bool deadlocked(std::size_t robot) const;
  Problem problem_of(std::size_t robot, const char* code, const std::string& text) const;
  void stop_before(std::size_t robot, const char* code, const std::string& text);
  std::string text_of(std::size_t robot) const;
  std::string obstacle_of(std::size_t robot, std::size_t pair) const;

  Owners cell_;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::cell
