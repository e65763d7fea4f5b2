#pragma once
/// Planning with obstacles in `polyarm plan`: paths around obstacles, and the clearance of a motion.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "apps/plan_motion.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/moves/move_plan.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "polyarm/setup/bodies.hpp"
#include "polyarm/surroundings/bodies.hpp"

namespace polyarm::apps {

/// One robot of a cell among everything else, for plans of the verb.
class PlanAround {
 public:
  /// The other robots are at their starts. Bodies of meshes are computed, or taken from the user's cache.
  /// Adds a warning for each link, tool or fixture without a body. `clearance`: m. Throws Error.
  PlanAround(const cell::CellRobots& robots, const cell::CellRobot& own, const description::Scene& scene,
             double clearance, Problems& problems);

  /// A path around obstacles for each of `moves`, which must be joint moves, one behind the other; every
  /// section goes from stop to stop. Throws Error("start-in-contact" | "goal-in-contact" | "no-way" |
  /// "out-of-time" | "unreachable" | "bad-move") that names the move.
  struct Way {
    std::string name;
    paths::PathSections path;
  };
  std::vector<Way> around(const std::vector<double>& start, const std::vector<moves::Move>& moves,
                          std::uint64_t seed, double seconds);
  /// Measures the smallest clearance of each section, every few ms. Each section with a contact is an error
  /// in the motion's problems.
  void measure(PlannedMotion& motion);

 private:
  const moves::RobotFacts& robot_;
  std::shared_ptr<const cell::ContactBodies> bodies_;
  std::unique_ptr<surroundings::Surroundings> surroundings_;
};

}  // namespace polyarm::apps
