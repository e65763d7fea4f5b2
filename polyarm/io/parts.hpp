#pragma once
/// Tracks the parts of a scene during a run and judges their result at the end.
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
  waiting,    ///< at its start; nobody has touched it
  held,       ///< in a gripper
  moving,     ///< released, not yet at rest
  placed,     ///< at rest in its bin, within tolerance of its goal; or without a goal
  off_goal,   ///< at rest too far from its goal
  wrong_bin,  ///< at rest outside the bin it belongs in
};
const char* name(PartFate fate);

struct PartReport {
  std::string name, kind, bin;  ///< bin: where it lies; "" for none
  Vec3 at;  ///< position of its origin in the world, m; the last rest position if it was removed
  std::optional<description::Goal> goal;
  std::optional<double> error_m;  ///< 3D distance to the goal at rest; empty until it is released
  PartFate fate = PartFate::waiting;
  bool taken = false;  ///< an outfeed has removed it
  std::string sentence() const;
};

/// Tracks the parts of a scene. A released part is at rest when it was slower than 1 mm/s for 0.5 s.
class PartTracker {
 public:
  static constexpr double kRestSpeed = 1e-3;
  static constexpr Nanoseconds kRestTime = 500'000'000;

  explicit PartTracker(const description::Scene& scene) : scene_(&scene), tracks_(scene.parts.size()) {}
  void update(Nanoseconds now, const hardware::WorldState& world);
  /// True while a released part has not come to rest.
  bool anything_moving() const;
  /// All parts that ever entered the cell, each once.
  std::vector<PartReport> report() const;
  /// Reasons why the run is a failure; empty if there are none. `cut_short`: the run was ended before the
  /// program ended by itself, so untouched parts are no failure.
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

/// The parts held by the grippers of a cell. The part's name is known in simulation only; otherwise only that
/// there is a part. Cell thread.
class HeldParts {
 public:
  /// `robots`: names in the order of the world's robot numbers. `scene` must outlive this object.
  HeldParts(std::vector<std::string> robots, const description::Scene& scene,
            const hardware::InterfaceTable& table);

  /// "blank_2", or "a part in 'arm'" if only the gripper's sensor reports it.
  std::vector<std::string> names(const control::Snapshot& snapshot) const;
  /// True if this differs from the last call; the first call returns whether any part is held. Allocates only
  /// in the first call.
  bool changed(const control::Snapshot& snapshot);

 private:
  static constexpr std::size_t kNoSensor = static_cast<std::size_t>(-1);
  bool senses(std::size_t robot, const control::Snapshot& snapshot) const;

  std::vector<std::string> robots_;
  const description::Scene& scene_;
  std::vector<std::size_t> sensors_;  ///< by robot: its state tool/part_present
  std::vector<int> seen_;             ///< by part: its holder; then by robot: its sensor's state
};

}  // namespace polyarm::cell
