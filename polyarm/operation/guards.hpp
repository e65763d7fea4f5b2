#pragma once
/// Guards of a running cell: they slow robots down and stop them before contacts, on planned moves, while
/// they are jogged and with streamed targets. A help for people and programs, not a safety function. Metres,
/// radians, seconds. Cell thread.
#include <memory>
#include <optional>
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
  /// In a cell whose contacts are listed instead of stopping it (CellOptions::contact_errors): where the
  /// guards would have stopped a robot, once for each pair in a line; warnings "guard" {robot, a, b,
  /// distance_m, clearance_m, at_s}.
  const std::vector<Problem>& would_stop() const;
  /// Exact distances of convex pieces that were computed so far.
  std::uint64_t measured() const;

 private:
  struct Work;
  struct Of;
  bool needed() const;
  bool listens() const;
  void see_moment();
  void see_base(std::size_t robot);
  bool is_planned(std::size_t robot) const;
  bool is_unplanned(std::size_t robot) const;
  void begin_bodies();
  bool take_bodies();
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
