#pragma once
/// The body of a robot for collision checks: its moving joints as a chain of frames, spheres around each
/// link, the pairs of links that can meet, and bounds on motion. Built once for each robot and tool; const
/// afterwards, any thread. Metres, radians; frames relative to the robot's base (its root link).
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "polyarm/collision/convex_body.hpp"
#include "polyarm/collision/sphere_cover.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::collision {

inline constexpr std::size_t kMostSteps = 64, kMostBodies = 256, kMostSpheres = 2048;

/// A body that moves with a link: a tool, or what a gripper holds.
struct AttachedBody {
  std::string name;
  int link = -1;  ///< index in RobotModel::links
  Pose pose;      ///< T_link_body, of the frame of `shapes`
  std::vector<description::Shape> shapes;
  std::vector<int> touches;  ///< links that it may touch, in addition to `link` and what is rigid with it
};

struct RobotBodyOptions {
  CoverOptions cover;  ///< for each link
  std::vector<AttachedBody> attached;
  /// States that are sampled to find pairs that are always in contact.
  int samples = 500;
};

/// One moving joint: its frame is parent * (t, r) * turn about z by (or shift along z by) ratio * q + offset.
struct JointFrame {
  int parent = -1;           ///< JointFrame; -1: the base
  std::size_t variable = 0;  ///< index in a joint state
  bool slides = false;
  double ratio = 1, offset = 0;
  double travel = 0;  ///< slides: the largest size of its shift, m
  Pose at;
};

/// One link, or attached body, with its shapes; in its joint frame.
struct LinkBody {
  std::string name;
  int link = -1;  ///< in RobotModel::links; of an attached body: the link that carries it
  bool attached = false;
  int frame = -1;  ///< JointFrame; -1: it does not move
  std::vector<ConvexBody> bodies;
  std::vector<Ball> spheres;  ///< contain the bodies
  Ball around;                ///< contains the spheres
  double excess = 0;          ///< how far a sphere stands out of the bodies, m
};

/// Two links that can meet, and how far their distance can change per rad or m of each joint, m.
struct LinkPairBody {
  std::size_t first = 0, second = 0;  ///< LinkBody
  std::vector<double> lever;          ///< by variable
};

class RobotBody {
 public:
  /// Planar and floating joints stay at zero. Meshes count as their convex pieces (hulls::make_bodies).
  /// Throws Error("bad-model" | "bad-shape" | "too-many").
  explicit RobotBody(const description::RobotModel& model, const RobotBodyOptions& options = {});

  std::size_t variables() const noexcept { return variables_; }
  const std::vector<JointFrame>& frames() const noexcept { return frames_; }
  const std::vector<LinkBody>& links() const noexcept { return links_; }
  const std::vector<LinkPairBody>& pairs() const noexcept { return pairs_; }
  /// The largest way of any point of a link per rad or m of each joint, m: [link * variables() + variable].
  double lever(std::size_t link, std::size_t variable) const noexcept {
    return levers_[link * variables_ + variable];
  }
  /// Names of pairs that are not checked because they touch at the start state or nearly always: "a, b".
  const std::vector<std::string>& always_touching() const noexcept { return always_; }
  /// Names of links that have shapes, but none that is known.
  const std::vector<std::string>& without_body() const noexcept { return unknown_; }
  /// The joint frame that a link of the model is rigid with (-1: the base), and the link's pose in it.
  int frame_of(int link) const noexcept { return frame_of_link_[static_cast<std::size_t>(link)]; }
  const Pose& pose_in_frame(int link) const noexcept { return pose_in_frame_[static_cast<std::size_t>(link)]; }
  /// How far any point of `balls`, which are rigid with a joint frame, goes per rad or m of each joint, m: by
  /// variable.
  std::vector<double> levers_of(int frame, std::span<const Ball> balls) const;
  /// How far the distance of two bodies of this robot can change per rad or m of each joint, m: by variable.
  std::vector<double> pair_levers(int first_frame, std::span<const Ball> first, int second_frame,
                                  std::span<const Ball> second) const;
  /// Poses of all joint frames in the base. `out` has frames().size() poses.
  void place(std::span<const double> q, std::span<Pose> out) const noexcept;
  /// A bound on the distance of a link's points from the base's origin, m; may be infinite.
  double reach(std::size_t link) const noexcept { return reach_[link]; }

 private:
  void add_frames(const description::RobotModel& model);
  void add_links(const description::RobotModel& model, const RobotBodyOptions& options);
  void find_levers();
  void find_pairs(const description::RobotModel& model, const RobotBodyOptions& options);
  std::vector<double> levers_by_frame(int frame, std::span<const Ball> balls) const;

  std::size_t variables_ = 0;
  std::vector<JointFrame> frames_;
  std::vector<int> frame_of_link_;   // of the model
  std::vector<Pose> pose_in_frame_;  // of the model's links
  std::vector<LinkBody> links_;
  std::vector<LinkPairBody> pairs_;
  std::vector<double> levers_, reach_;
  std::vector<std::string> always_, unknown_;
};

}  // namespace polyarm::collision
