#pragma once
/// Maps the pose of a leader to a target of its follower. Metres, radians, world frame.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/jog/jog_generator.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/teleop/settings.hpp"

namespace polyarm::teleop {

/// engage() takes the poses from which both move; target() then maps. At the moment of engage() the target is
/// where the follower is, except for joints that are to match the leader's. Any one thread; only the
/// constructor allocates and throws.
class TeleopMap {
 public:
  /// Both chains must outlive the map. Throws Error("unknown-joint" | "unlike-arms") with the settings'
  /// place.
  TeleopMap(const PairSettings& settings, const kinematics::Chain& leader, const kinematics::Chain& follower);

  void engage(std::span<const double> leader, std::span<const double> follower) noexcept;
  /// joint_target or tcp_target, without velocity and speed. Joints stay within the follower's limits.
  jog::JogSetpoint target(std::span<const double> leader) const noexcept;

  /// The joint of the follower that is furthest from the leader's pose, and how far, rad or m.
  struct Distance {
    std::size_t joint = 0;
    double much = 0;
  };
  Distance furthest(std::span<const double> leader, std::span<const double> follower) const noexcept;

 private:
  struct Link {
    std::size_t from, to;
    double scale, offset;
  };
  void match_by_name();
  bool moves_all() const;
  void match_in_order();
  void match_as_set();
  double wanted(const Link& link, std::span<const double> leader) const noexcept;

  const PairSettings& settings_;
  const kinematics::Chain &leader_, &follower_;
  std::vector<Link> links_;
  jog::JogValues leader_at_{}, follower_at_{};
  Pose leader_tcp_, follower_tcp_;
  Quaternion axes_;  ///< maps directions of the leader's motion into the follower's, both in the world
};

}  // namespace polyarm::teleop
