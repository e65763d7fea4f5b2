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
#include "polyarm/planning/planner.hpp"

namespace polyarm::apps {

/// The robot, its tool and the scene, prepared for collision checks.
class Surroundings {
 public:
  /// Collision bodies of meshes are computed, or read from the user's cache. Adds a warning for each link,
  /// tool or fixture without a body. `clearance`: m. `scene` is a copy; its meshes get their convex pieces.
  Surroundings(const moves::RobotFacts& robot, const description::Tool& tool, description::Scene scene,
               double clearance, Problems& problems);

  collision::Probe& probe() { return *probe_; }
  /// Finds a path around obstacles for each of `moves`, in sequence; they must be joint moves. Every section
  /// starts and ends at rest. Throws Error("start-in-contact" | "goal-in-contact" | "no-way" | "out-of-time"
  /// | "unreachable" | "bad-move") that names the move.
  struct Way {
    std::string name;
    paths::PathSections path;
  };
  std::vector<Way> around(const moves::RobotFacts& robot, const std::vector<double>& start,
                          const std::vector<moves::Move>& moves, std::uint64_t seed, double seconds);
  /// Measures the smallest clearance during the motion, every few ms. A contact becomes an error in the
  /// motion's problems.
  void measure(PlannedMotion& motion);

 private:
  std::unique_ptr<const collision::Checker> checker_;
  std::unique_ptr<collision::Probe> probe_;
};

}  // namespace polyarm::apps
