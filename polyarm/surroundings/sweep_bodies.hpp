#pragma once
/// The bodies that Sweep follows, and which of them may not touch. Private to this room. Metres.
#include <memory>
#include <string>
#include <vector>

#include "polyarm/collision/box_tree.hpp"
#include "polyarm/surroundings/bodies.hpp"

namespace polyarm::surroundings {

enum class BodyKind { link, tool, fingers, part, fixture, floor };

/// Convex pieces in the frame of their owner: a joint frame, a part, a fixture, the world.
struct SweptBody {
  std::string name;
  BodyKind kind = BodyKind::link;
  int robot = -1, frame = -1;  ///< of a robot
  int part = -1, fixture = -1;
  int link = -1;  ///< of the model
  std::vector<collision::ConvexBody> pieces;
  std::vector<collision::Ball> balls;  ///< of each piece
  collision::BoxTree tree;             ///< over the pieces, if there are many; else empty
  collision::Ball around;
  std::vector<double> lever;               ///< of a robot: by variable
  bool is_root = false, is_first = false;  ///< rigid with the root; behind the first joint
  bool rolls = false;                      ///< may touch the floor
  bool is_static = false;                  ///< floor, and fixtures without a mover

  bool of_robot() const { return robot >= 0 && part < 0; }
  /// Calls take(piece) for each piece that may be nearer to the ball than range(); in the frame of the
  /// pieces.
  template <typename Range, typename Take>
  void each_near(const Vec3& center, double radius, const Range& range, const Take& take) const {
    if (!tree.empty()) {
      tree.each_near(
          center, [&] { return range() + radius; }, take);
      return;
    }
    for (std::size_t k = 0; k < pieces.size(); ++k)
      if (norm(center - balls[k].center) - radius - balls[k].radius <= range()) take(k);
  }
};

/// Calls take(piece of a, piece of b) for each two pieces that may be nearer to each other than range().
template <typename Range, typename Take>
void each_near(const SweptBody& a, const Pose& pose_a, const SweptBody& b, const Pose& pose_b,
               const Range& range, const Take& take) {
  if (!a.tree.empty()) {
    const Pose T_a_b = inverse(pose_a) * pose_b;
    for (std::size_t k = 0; k < b.pieces.size(); ++k)
      a.each_near(T_a_b * b.balls[k].center, b.balls[k].radius, range, [&](std::size_t i) { take(i, k); });
    return;
  }
  const Pose T_b_a = inverse(pose_b) * pose_a;
  for (std::size_t i = 0; i < a.pieces.size(); ++i)
    b.each_near(T_b_a * a.balls[i].center, a.balls[i].radius, range, [&](std::size_t k) { take(i, k); });
}

/// How a part is in the world at a moment.
struct PartMode {
  bool in_world = false;
  int held_by = -1;  ///< index of a robot; -1: none
  Pose in_hand;      ///< T_frame_part, of the frame of the tool
  bool operator==(const PartMode& o) const { return in_world == o.in_world && held_by == o.held_by; }
};

/// All bodies of a cell. `robots` and `scene` outlive it.
class SweepBodies {
 public:
  SweepBodies(std::vector<Robot> robots, const description::Scene& scene);

 protected:
  /// Two bodies, neither a part, that are not of one robot: may they not touch?
  bool counts(const SweptBody& a, const SweptBody& b) const;
  /// The same for two bodies of which at least one is a part. `parts`: of all parts.
  bool counts(const SweptBody& a, const SweptBody& b, const std::vector<PartMode>& parts) const;
  /// The robot that moves a body, as its own or in its hand; -1: none.
  static int robot_of(const SweptBody& body, const std::vector<PartMode>& parts) {
    return body.part >= 0 ? parts[static_cast<std::size_t>(body.part)].held_by : body.robot;
  }
  /// The bounding balls of the pieces of a part, in the frame of the tool that holds it.
  static std::vector<collision::Ball> balls_in_hand(const SweptBody& part, const Pose& in_hand);

  std::vector<Robot> robots_;
  const description::Scene& scene_;
  std::vector<std::shared_ptr<const collision::RobotBody>> models_;
  std::vector<std::size_t> first_body_;       // of each robot
  std::vector<std::vector<char>> near_tool_;  // of each robot, by link: what its tool may touch
  std::vector<int> tool_frame_;
  std::vector<SweptBody> bodies_;

 private:
  void add_robot(std::size_t r);
  void add_fixture(std::size_t f);
  bool may_meet(const SweptBody& a, const SweptBody& b) const;
  bool is_shared(const SweptBody& body, const SweptBody& other) const;
};

}  // namespace polyarm::surroundings
