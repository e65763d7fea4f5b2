#pragma once
/// The bodies of a running cell for guards: how near two bodies are now, how near they would be with one
/// robot in another joint state, and how a distance changes with the joints. Metres, radians; poses in the
/// world. One thread. After construction only look() allocates, and only when a part is taken, released,
/// brought or removed.
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/surroundings/sweep_bodies.hpp"

namespace polyarm::surroundings {

/// A region that the bodies of a robot keep out of, or a plane whose side they keep to.
struct GuardZone {
  std::string name;
  int robot = -1;               ///< index; -1: every robot
  bool box = false;             ///< the outside of a box; else the side of a plane that `normal` points to
  Vec3 point, normal{0, 0, 1};  ///< of the plane; unit normal
  Vec3 low, high;               ///< opposite corners of the box
};

/// Two bodies that may not touch.
struct GuardPair {
  std::uint32_t a = 0, b = 0;
  int robot_a = -1, robot_b = -1;  ///< the robots that move them; -1: none
  bool active = false;
  bool own = false;      ///< both are moved by one robot
  bool of_part = false;  ///< one of them is a part
  bool of_zone = false;
  double slack = 0;           ///< a lower bound of the distance now
  std::uint32_t version = 0;  ///< counts what parts change of it
  std::vector<double> lever;  ///< of an own pair: bound on the change of the distance, by variable

  bool concerns(int robot) const noexcept { return robot_a == robot || robot_b == robot; }
  /// The robot that is not `robot`; -1: none.
  int other_than(int robot) const noexcept { return robot_a == robot ? robot_b : robot_a; }
};

/// The distance of a pair: `a` moves away along the unit vector `normal`.
struct GuardGap {
  double distance = 0;  ///< negative: how deep they overlap
  Vec3 on_a, on_b, normal;
};

class GuardBodies : private SweepBodies {
 public:
  /// The most pairs of bodies: guards go through all of them in a tick.
  static constexpr std::size_t kMostPairs = 100'000;

  /// Throws as RobotBody does, and Error("too-many-bodies"). `robots` and `scene` outlive it; their meshes have
  /// their pieces.
  GuardBodies(std::vector<Robot> robots, const description::Scene& scene,
              const std::vector<GuardZone>& zones = {});

  /// The present moment. Bounds of distances follow the motion since the last one.
  void look(const Moment& moment);
  bool has_looked() const noexcept { return looked_; }

  std::size_t robots() const noexcept { return robots_.size(); }
  std::size_t bodies() const noexcept { return bodies_.size(); }
  std::size_t variables(std::size_t robot) const noexcept { return models_[robot]->variables(); }
  /// True if the base of the robot moves by itself: no guard knows where it would stand.
  bool drives(std::size_t robot) const noexcept { return robots_[robot].is_free && robots_[robot].on < 0; }
  const std::vector<GuardPair>& pairs() const noexcept { return pairs_; }
  const std::string& name(std::uint32_t body) const noexcept { return bodies_[body].name; }
  BodyKind kind(std::uint32_t body) const noexcept { return bodies_[body].kind; }
  /// True for tools, fingers, and the link that carries the tool with all behind it: they take parts.
  bool is_hand(std::uint32_t body) const noexcept { return is_hand(bodies_[body]); }
  /// False for parts, movers and what robots move.
  bool is_static(std::uint32_t body) const noexcept { return bodies_[body].is_static; }
  /// How far a body has moved since the start, m; never less than it did.
  double moved(std::uint32_t body) const noexcept { return moved_[body]; }
  std::span<const double> joints(std::size_t robot) const noexcept { return moment_.robots[robot].joints; }

  /// A bound on how far a body goes when the joints of the robot that moves it change by at most `size`.
  double reach(std::uint32_t body, std::span<const double> size) const noexcept;
  /// How far each body goes, at most: those that `robot` moves when its joints change by at most `size`,
  /// those of another robot by the `others` of that robot. `out`: by body.
  void reaches(int robot, std::span<const double> size, std::span<const std::vector<double>> others,
               std::span<double> out) const noexcept;
  /// How far any body that a robot moves goes per rad or m of each joint, at most. `out`: by variable.
  void levers(int robot, std::span<double> out) const noexcept;
  /// The same of the farthest body that a robot moves.
  double fastest(int robot, std::span<const double> size) const noexcept;
  /// A bound on how much the distance of a pair changes per rad or m of each joint of `robot`, by variable;
  /// joints beyond its end change nothing.
  std::span<const double> lever_of(const GuardPair& pair, int robot) const noexcept {
    if (pair.own)
      return pair.robot_a == robot ? std::span<const double>(pair.lever) : std::span<const double>();
    if (pair.robot_a == robot) return bodies_[pair.a].lever;
    return pair.robot_b == robot ? std::span<const double>(bodies_[pair.b].lever) : std::span<const double>();
  }
  /// A bound on how much the distance of a pair changes when the joints of `robot` change by at most `size`.
  double change(const GuardPair& pair, int robot, std::span<const double> size) const noexcept;

  /// Puts a robot into another joint state for gap_of() with `moved`.
  void try_joints(std::size_t robot, std::span<const double> joints) noexcept;
  /// The frames of a robot in another joint state, for try_frames(). `out`: frames() of them.
  std::size_t frames(std::size_t robot) const noexcept { return models_[robot]->frames().size(); }
  void frames_at(std::size_t robot, std::span<const double> joints, std::vector<Pose>& out) const noexcept {
    place(robot, joints, out);
  }
  /// As try_joints(), with frames that are known already.
  void try_frames(const std::vector<Pose>& frames) noexcept {
    std::copy(frames.begin(), frames.end(), trial_.begin());
  }
  /// Where a robot would be while it brakes: at most kAhead places in order, and how far its joints go from
  /// each to the next. Without them the bounds of the caller count.
  static constexpr std::size_t kAhead = 8;
  void forget_ahead(std::size_t robot) noexcept { ahead_count_[robot] = -1; }
  void stands(std::size_t robot) noexcept { ahead_count_[robot] = 0; }
  void add_ahead(std::size_t robot, std::span<const double> joints, std::span<const double> step) noexcept;
  /// A lower bound of the distance of a pair while the other robot brakes, with robot `moved` as try_joints()
  /// put it; `drift`: how much nearer the other one may come, at most. Its places are looked at if that
  /// leaves less than `enough`.
  GuardGap gap_while_braking(const GuardPair& pair, int moved, double drift, double enough) noexcept;
  /// The exact distance now; `moved`: with that robot as try_joints() put it. A lower bound by bounding balls
  /// is returned instead if it exceeds `enough`; points and normal are then undefined.
  /// `ahead`: the other robot at that place of its braking.
  GuardGap gap_of(const GuardPair& pair, double enough, int moved = -1, int ahead = -1) noexcept;
  /// The exact distance with one body of the pair, `a` or else `b`, moved by `motion` in the world; or a
  /// lower bound, as gap_of().
  GuardGap gap_after(const GuardPair& pair, bool a, const Pose& motion, double enough) noexcept;
  /// What is nearest to a robot, as far as it is nearer than `within`; `tried`: with the robot as
  /// try_joints() put it. Two links of the robot do not count.
  struct Nearest {
    int pair = -1;  ///< -1: nothing is so near
    GuardGap gap;
  };
  Nearest nearest(int robot, double within, bool tried = false) noexcept;
  /// Measures the pair now and keeps the result as its slack.
  double measure(std::size_t pair, double enough) noexcept;

  /// Points of the pieces of a pair nearer than `range`, now: each is a plane between the two pieces and a
  /// point of the body of `robot` in front of it. While every point stays in front of its plane, the pieces
  /// do not touch. Returns their number. Measures the pair and keeps the result as its slack, as measure()
  /// does. `left_out`: a lower bound of the distance of what is in no point; infinite if that is farther than
  /// `range`.
  std::size_t measure_points(std::size_t pair, int robot, double range, std::span<GuardGap> out,
                             double& left_out) noexcept;
  /// How the distance of a gap changes with the joints of `robot`: per rad or m. `out`: by variable.
  void gradient(const GuardPair& pair, int robot, const GuardGap& gap, std::span<double> out) const noexcept;

  /// Exact distances of convex pieces that were computed so far.
  std::uint64_t measured() const noexcept { return measured_; }

 private:
  struct Plane {
    Vec3 normal;
    double offset = 0;
  };
  void add_zone(const GuardZone& zone);
  void add_pair(std::size_t a, std::size_t b);
  void renew(int part);
  void take_part_changes(const Moment& moment);
  void place(std::size_t robot, std::span<const double> joints, std::vector<Pose>& frames) const noexcept;
  void find_motion(const Moment& moment) noexcept;
  void follow_pairs() noexcept;
  double motion_of_robot_body(std::size_t body, const Pose& base, const Pose& next) const noexcept;
  Pose pose_of(std::uint32_t body, int moved, int ahead = -1) const noexcept;
  const std::vector<Pose>& frames(int robot, int moved, int ahead) const noexcept {
    if (robot == moved) return trial_;
    const auto r = static_cast<std::size_t>(robot);
    return ahead < 0 ? frames_[r] : ahead_[r][static_cast<std::size_t>(ahead)];
  }
  bool is_hand(const SweptBody& body) const noexcept;
  int frame_of(std::uint32_t body) const noexcept;
  GuardGap from_plane(const GuardPair& pair, int moved) const noexcept;
  GuardGap gap_at(const GuardPair& pair, const Pose& pose_a, const Pose& pose_b, double enough) noexcept;
  GuardGap between(const collision::ConvexBody& a, const Pose& pose_a, const collision::ConvexBody& b,
                   const Pose& pose_b) noexcept;
  void slide(std::uint32_t body, int robot, const Vec3& point, const Vec3& normal, double sign,
             std::span<double> out) const noexcept;

  std::vector<Plane> planes_;    // of bodies without pieces, by body
  std::vector<int> zone_robot_;  // by body; -2: no zone
  std::vector<GuardPair> pairs_;
  std::vector<PartMode> parts_;
  std::vector<std::vector<char>> hands_;  // of each robot, by link
  Moment moment_;
  bool looked_ = false;
  std::vector<std::vector<Pose>> frames_;  // of each robot, in the world
  std::vector<Pose> trial_;
  std::vector<std::array<std::vector<Pose>, kAhead>> ahead_;         // of each robot
  std::vector<std::array<std::vector<double>, kAhead>> ahead_step_;  // by variable
  std::vector<int> ahead_count_;                                     // -1: not known
  std::vector<std::vector<double>> joint_motion_;
  std::vector<double> motion_, moved_;  // by body
  std::vector<Pose> placed_;            // by body: of those that no robot moves
  std::uint64_t measured_ = 0;
};

}  // namespace polyarm::surroundings
