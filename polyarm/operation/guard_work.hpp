#pragma once
/// What guards keep from tick to tick. Private to this room.
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/jog/body_guard.hpp"
#include "polyarm/operation/guard_parts.hpp"
#include "polyarm/operation/guards.hpp"
#include "polyarm/surroundings/look_ahead.hpp"

namespace polyarm::cell {

/// One robot.
struct Guards::Of {
  std::unique_ptr<surroundings::LookAhead> ahead;
  std::unique_ptr<jog::BodyGuard> jogged;
  std::vector<jog::AxisLimits> axes;
  PathOfMove way;
  PathOfPoints points;
  surroundings::PlannedWay* along = nullptr;  // one of both
  bool by_points = false;  // a trajectory of points, which has no pace: the cell is held before a contact
  std::uint64_t goal = 0;  // of the motion that is followed; 0: none
  double time = 0, speed = 1;
  const moves::InStep* step = nullptr;
  const moves::RobotFacts* facts = nullptr;  // with the TCP of the motion; valid in this tick
  double duration = 0;
  Braking braking;
  double pace = 1, wanted = 1;
  bool slowed = false;  // during this motion
  bool anew = false;    // the bodies are new: the motion is looked at from its present place
  surroundings::LookAhead::Answer ahead_of;
  ZonesAhead zones;
  bool looks_at_zones = false;  // zones of this motion were not judged, or in another profile
  std::string crossing;         // what leaves the workspace at ahead_of.free_until; empty: nothing
  std::vector<double> velocity, before, q, v, last, step_size, braking_way;
  double stopped_way = 0;  ///< largest joint way of the braking that a guard began; 0: the way is free
  Nanoseconds stands_since = -1;
  bool reported = false;
  std::optional<JointRates> rates;
  std::optional<Pose> base;  // when it was first seen
  bool drove = false;
  Pose base_seen;    // in the last tick
  Pose base_before;  // at `base_since`
  Nanoseconds base_since = 0, base_changed = 0;
  Vec3 base_velocity;           // m/s in the world
  double base_turning = 0;      // rad/s about the vertical
  Nanoseconds base_asked = -1;  // when somebody last asked how fast it may drive
  std::uint64_t drive = 0;      // the present move of its base, or the last one
  surroundings::Moment at_drive_start;  // where all robots were when this move began
};

struct Guards::Work {
  std::shared_ptr<const ContactBodies> models;
  std::shared_ptr<const description::Scene> scene;  // of `bodies`
  std::vector<description::Fixture> more;
  std::vector<surroundings::AttachedThing> attached;
  /// Attached things of `bodies`: they are parts after those of the cell's scene.
  std::vector<surroundings::AttachedThing> held;
  bool has_news = false;  // `more` is not in `bodies` yet
  std::unique_ptr<surroundings::GuardBodies> bodies;
  std::vector<Of> robots;
  std::vector<std::vector<double>> stopping;
  surroundings::Moment moment;
  Nanoseconds seen = -1;
  std::vector<Problem> would_stop;
  bool reduced = false;  // zones of `bodies` are those of this profile
  // made on the planning thread
  struct Making {
    bool reduced = false;
    std::vector<surroundings::AttachedThing> attached;
    std::shared_ptr<const ContactBodies> models;
    std::shared_ptr<const description::Scene> scene;
    std::unique_ptr<surroundings::GuardBodies> bodies;
    std::string failed;
    std::atomic<bool> done{false};
  };
  std::shared_ptr<Making> making;
  bool off = false;
};

}  // namespace polyarm::cell
