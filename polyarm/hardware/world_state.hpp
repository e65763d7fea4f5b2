#pragma once
/// Where everything is now, as a simulated world publishes it beside the interface table.
#include <array>
#include <cstdint>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::hardware {

struct PartState {
  Pose pose;              ///< in the world
  Vec3 linear_velocity;   ///< m/s
  double speed = 0;       ///< fastest point of the part, about: |v| + |w| * size, m/s
  bool entered = false;   ///< has been in the cell
  bool in_world = false;  ///< is there now: not waiting in a feeder, not taken by an outfeed
  bool asleep = false;
  int held_by = -1;  ///< index of the robot that holds it; -1: none
};

/// Something touched what it should not have.
struct Contact {
  Nanoseconds time = 0;
  int a = -1, b = -1;  ///< indices into WorldState::names
  double depth = 0;    ///< deepest penetration while it lasted, so far, m
  Vec3 position;       ///< in the world, where the pair is deepest in each other, m
  bool now = false;    ///< it touches in the newest cycle
};

struct WorldState {
  static constexpr int kMaxFindings = 64;
  std::vector<PartState> parts;  ///< in the order of Scene::parts
  std::array<Contact, kMaxFindings>
      findings;           ///< one for each time that a pair begins to touch;
                          ///< number n of them is at n % kMaxFindings, the newest replace the oldest
  int finding_count = 0;  ///< all findings so far
  int contacts = 0;           ///< contact points in the last physics step
  double tracking_error = 0;  ///< largest |commanded - measured| of a position-driven joint, last cycle
  bool at_rest = true;        ///< no part, mover or finger is moving
};

}  // namespace polyarm::hardware
