#pragma once
/// What became of the parts: followed through a run, judged at its end.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/hardware/world_state.hpp"

namespace polyarm::cell {

enum class PartFate {
  waiting,    ///< where it began; nobody has touched it
  held,       ///< in a gripper
  moving,     ///< let go of, not yet at rest
  placed,     ///< at rest within tolerance of its goal, in its bin; or it has no goal
  off_goal,   ///< at rest too far from its goal
  wrong_bin,  ///< at rest outside the bin it belongs in
};
const char* name(PartFate fate);

struct PartReport {
  std::string name, kind, bin;  ///< bin: the one it lies in, "" for none
  Vec3 at;  ///< of its origin, in the world; where it last came to rest if it was taken away
  std::optional<description::Goal> goal;
  std::optional<double> error_m;  ///< 3D distance to the goal at rest; empty while it has not been let go of
  PartFate fate = PartFate::waiting;
  bool taken = false;  ///< an outfeed has taken it away
  std::string sentence() const;
};

/// Follows the parts of a scene. A part has come to rest when, let go of, it was slower than 1 mm/s for 0.5
/// s.
class PartTracker {
 public:
  static constexpr double kRestSpeed = 1e-3;
  static constexpr Nanoseconds kRestTime = 500'000'000;

  explicit PartTracker(const description::Scene& scene) : scene_(&scene), tracks_(scene.parts.size()) {}
  void update(Nanoseconds now, const hardware::WorldState& world);
  /// True while a part has been let go of and has not come to rest.
  bool anything_moving() const;
  /// Every part that ever entered the cell, once.
  std::vector<PartReport> report() const;
  /// What makes the run a failure; empty when all is well. `cut_short`: the run was ended before the program
  /// ended by itself, so parts that nobody has touched yet are no failure.
  std::vector<std::string> failures(bool cut_short) const;

 private:
  struct Track {
    bool entered = false, touched = false, held = false, at_rest = false, taken = false;
    Nanoseconds slow_since = 0;
    bool slow = false;
    Vec3 at;
  };
  PartReport judge(std::size_t part) const;

  const description::Scene* scene_;
  std::vector<Track> tracks_;
};

/// What the grippers of a cell hold: the part by name where a simulation tells it, else that there is one.
/// Cell thread.
class HeldParts {
 public:
  /// `robots`: names, in the order in which the world counts them. `scene` has to outlive this.
  HeldParts(std::vector<std::string> robots, const description::Scene& scene,
            const hardware::InterfaceTable& table);

  /// "blank_2", or "a part in 'arm'" where only the gripper's own sensor knows.
  std::vector<std::string> names(const control::Snapshot& snapshot) const;
  /// Whether that is other than at the last call; at the first one, whether there is any. Allocates nothing
  /// but in the first.
  bool changed(const control::Snapshot& snapshot);

 private:
  static constexpr std::size_t kNoSensor = static_cast<std::size_t>(-1);
  bool senses(std::size_t robot, const control::Snapshot& snapshot) const;

  std::vector<std::string> robots_;
  const description::Scene& scene_;
  std::vector<std::size_t> sensors_;  ///< by robot: its state tool/part_present
  std::vector<int> seen_;             ///< by part who holds it, then by robot whether it feels one
};

}  // namespace polyarm::cell
