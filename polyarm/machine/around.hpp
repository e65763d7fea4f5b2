#pragma once
/// What is around the robots of a cell, for moves that go around obstacles.
#include <functional>
#include <memory>
#include <mutex>

#include "polyarm/moves/base_motion.hpp"
#include "polyarm/moves/obstacles.hpp"
#include "polyarm/setup/bodies.hpp"
#include "polyarm/surroundings/bodies.hpp"

namespace polyarm::cell {

/// The bodies of a cell, made when somebody needs them: that reads the disk. Any thread.
class SharedBodies {
 public:
  /// `robots` and `scene` outlive it.
  SharedBodies(const CellRobots& robots, const description::Scene& scene) : robots_(robots), scene_(scene) {}
  /// Throws Error as contact_bodies() does; then it tries again at the next call.
  std::shared_ptr<const ContactBodies> get();

 private:
  const CellRobots& robots_;
  const description::Scene& scene_;
  std::mutex mutex_;
  std::shared_ptr<const ContactBodies> made_;
};

struct AroundOptions {
  double clearance = 0;  ///< m; less where start or goal are nearer to something
  /// True ends a search; null: it ends after a number of samples alone, so that a run repeats itself.
  std::function<bool()> stop;
};

/// Obstacles of robot `own` at a moment. A search has a fixed seed.
std::shared_ptr<moves::Obstacles> obstacles_around(std::shared_ptr<SharedBodies> bodies,
                                                   surroundings::Moment moment, std::size_t own,
                                                   AroundOptions options);

/// A way of a base to a place.
struct BaseGoal {
  std::size_t robot = 0;
  Pose T_root_base;  ///< the frame that its wheels move, in the root link
  Pose goal;         ///< T_world_base
  double sharpest;   ///< curvature of its ways, 1/m; infinite: it turns on the spot
  AroundOptions options;
};

/// The search for a way from where the base is at this moment. It throws Error: start-in-contact,
/// goal-in-contact, no-way, out-of-time, and as SharedBodies.
moves::BaseSurroundings::Search base_search(std::shared_ptr<SharedBodies> bodies, surroundings::Moment moment,
                                            BaseGoal goal);

}  // namespace polyarm::cell
