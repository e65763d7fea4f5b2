#pragma once
/// Follows every pair of bodies of a cell through a motion and proves how near they come: between two moments
/// a distance changes by at most the way of both bodies, so a pair is measured only when that bound runs out.
/// Metres, radians, seconds; in the world. One thread; allocates.
///
/// Between two moments joints, bases, parts and movers go straight. A motion that is given every 2 ms bends
/// off that line by less than 0.02 mm at 20 rad/s².
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/surroundings/bodies.hpp"

namespace polyarm::surroundings {

/// The nearest that two bodies came while they were closer than the clearance.
struct Approach {
  std::string first,
      second;             ///< "arm/forearm", "fixture table"; the first one belongs to a robot, or is held
  std::size_t robot = 0;  ///< index: of `first`, or the one that holds it
  double distance = 0;    ///< negative: how deep they overlap
  Vec3 point;             ///< between them
  double time = 0;
  std::uint64_t mark = 0;  ///< what the caller said of that time
  std::uint64_t first_mark = 0;  ///< the same of the moment when they began to touch
  double first_distance = 0;     ///< the least under the first mark
  bool at_start = false;   ///< they touched in the first moment
};

/// Which pairs count: links, tools and held parts against fixtures, floor, parts and other robots, and links
/// of one robot against each other (contacts alone: they need no clearance). Fingers may touch parts. A part
/// that a gripper takes or releases may touch what it lies on, and the tool may touch it: an approach that
/// begins or ends with that counts only where bodies overlap by more than `kPressing`.
class Sweep {
 public:
  static constexpr double kPressing = 0.002;
  static constexpr double kResolution = 1e-4;  ///< of reported distances

  /// Throws as RobotBody does. `robots` and `scene` outlive it; their meshes have their pieces. `clearance`:
  /// approaches nearer than this are reported.
  Sweep(std::vector<Robot> robots, const description::Scene& scene, double clearance);
  ~Sweep();
  Sweep(const Sweep&) = delete;
  Sweep& operator=(const Sweep&) = delete;

  /// The next moment, at `time` s. `mark_of(robot)`: kept with an approach; asked when one gets nearer.
  void add(const Moment& moment, double time, const std::function<std::uint64_t(std::size_t)>& mark_of);
  /// The next moment does not follow from the last one: nothing moves between them. Held parts stay in hand.
  void jump();
  /// After the last moment. `holding_on`: the motion ends in the middle of a job, so that what touches a held
  /// part or the tool then may be about to be let go or taken.
  void finish(bool holding_on = false);
  /// Those that have ended, in their order.
  const std::vector<Approach>& approaches() const;
  /// The exact distances that were computed so far.
  std::uint64_t measured() const;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

/// "arm/forearm touched fixture table at 1.234 s, 2.10 mm deep, at (0.300, 0.000, 0.090)".
std::string text_of(const Approach& approach);

}  // namespace polyarm::surroundings
