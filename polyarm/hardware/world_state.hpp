#pragma once
/// State of a simulated world, published in addition to the interface table.
#include <array>
#include <cstdint>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::hardware {

struct PartState {
  Pose pose;              ///< in the world
  Vec3 linear_velocity;   ///< m/s
  double speed = 0;       ///< approximate speed of its fastest point: |v| + |w| * size, m/s
  bool entered = false;   ///< true once it has been in the cell
  bool in_world = false;  ///< true while it is there: not waiting in a feeder, not removed by an outfeed
  bool asleep = false;
  int held_by = -1;  ///< RobotInstance::number of the robot that holds it; -1 if none does
};

/// An unwanted contact.
struct Contact {
  Nanoseconds time = 0;
  int a = -1, b = -1;  ///< indices into WorldState::names
  double depth = 0;    ///< largest penetration depth so far, m
  Vec3 position;       ///< in the world, at the largest depth, m
  bool now = false;    ///< true if it touches in the newest cycle
};

struct WorldState {
  static constexpr int kMaxFindings = 64;
  std::vector<PartState> parts;  ///< in the order of Scene::parts
  std::array<Contact, kMaxFindings>
      findings;           ///< one per start of a contact; number n is stored at n % kMaxFindings, and the
                          ///< newest replace the oldest
  int finding_count = 0;  ///< all findings so far
  int contacts = 0;           ///< contact points in the last physics step
  double tracking_error = 0;  ///< largest |commanded - measured| of a position-driven joint, last cycle
  bool at_rest = true;        ///< no part, mover or finger is moving
};

}  // namespace polyarm::hardware
