#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "polyarm/move_group/goals.hpp"
#include "polyarm/move_group/plans.hpp"
#include "polyarm/move_group/poses.hpp"
#include "polyarm/move_group/trajectories.hpp"

namespace polyarm::move_group {

namespace {

using planning::JointState;

constexpr double kUsualStep = 0.01, kTurnStep = 0.05;  // m, rad
constexpr std::size_t kMostSteps = 20'000;

/// A path of the TCP along straight lines, step by step, until something stands against it.
class CartesianPath {
 public:
  CartesianPath(Around around, const srv::GetCartesianPath::Request& request, const PlanSettings& settings)
      : around_(std::move(around)),
        request_(request),
        settings_(settings),
        arm_(*around_.arm),
        group_(arm_.group(request.group_name)),
        path_(around_, request.path_constraints) {
    if (!group_.solvable)
      throw Refusal(Code::INVALID_GROUP_NAME, "the group '" + group_.name + "' has no inverse kinematics");
    if (request.waypoints.size() > kMostWaypoints)
      throw Refusal(Code::INVALID_GOAL_CONSTRAINTS, fmt::format("the path has {} waypoints; {} are possible",
                                                                request.waypoints.size(), kMostWaypoints));
    if (!(request.max_step > 0 && std::isfinite(request.max_step)))
      throw Refusal(Code::INVALID_GOAL_CONSTRAINTS, "max_step is not above 0");
    const int link = request.link_name.empty() ? group_.tip : arm_.link(request.link_name);
    const Pose frame =
        arm_.facts().chain.base() * inverse(around_.base()) * around_.frame(request.header.frame_id);
    for (const geometry::Pose& pose : request.waypoints)
      targets_.push_back(frame * pose_of(pose, "a waypoint", Code::INVALID_GOAL_CONSTRAINTS) *
                         arm_.tcp_in_link(link));
  }

  void run(srv::GetCartesianPath::Response& out) {
    if (request_.avoid_collisions) surroundings_ = compiled(around_, around_.joints(), 0);
    const std::vector<Pose> reached = follow(out.fraction);
    if (reached.empty()) return;
    out.solution = to_message(arm_, group_, timed(reached), around_.joints());
  }

 private:
  /// The ends of the lines that can be followed; the last one may be cut.
  std::vector<Pose> follow(double& fraction) {
    std::vector<Pose> out;
    JointState q = around_.joints();
    Pose from = arm_.facts().chain.forward(q);
    double length = 0, done = 0;
    std::vector<double> lengths;
    for (Pose last = from; const Pose& target : targets_) {
      lengths.push_back(norm(target.position - last.position) +
                        angle_between(target.rotation, last.rotation) * 0.1);
      length += lengths.back();
      last = target;
    }
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      const double part = line(from, targets_[i], q);
      done += part * lengths[i];
      if (part > 0) out.push_back(part < 1 ? between(from, targets_[i], part) : targets_[i]);
      if (part < 1) break;
      from = targets_[i];
      if (i + 1 == targets_.size()) done = length;
    }
    fraction = length > 0 ? done / length : (targets_.empty() ? 0 : 1);
    return out;
  }

  static Pose between(const Pose& a, const Pose& b, double s) {
    const Vec3 turn = to_rotation_vector(inverse(a.rotation) * b.rotation);
    const double angle = norm(turn);
    return {a.position + s * (b.position - a.position),
            angle > 0 ? a.rotation * from_axis_angle(normalized(turn), s * angle) : a.rotation};
  }

  /// How far along the line the arm gets, 0 to 1; `q` follows.
  double line(const Pose& from, const Pose& to, JointState& q) {
    const double way = norm(to.position - from.position), turn = angle_between(from.rotation, to.rotation);
    const double step = std::min(request_.max_step, kUsualStep);
    const auto wanted = static_cast<std::size_t>(std::ceil(std::max({way / step, turn / kTurnStep, 1.0})));
    const std::size_t steps = std::min(wanted, kMostSteps);
    for (std::size_t i = 1; i <= steps; ++i) {
      if (settings_.cancelled && settings_.cancelled())
        throw Refusal(Code::PREEMPTED, "the request was cancelled");
      if (Clock::now() > end_)
        throw Refusal(Code::TIMED_OUT,
                      fmt::format("the path takes longer than {} s: ask for a shorter one or larger steps",
                                  kLongestPlanning));
      const double s = static_cast<double>(i) / static_cast<double>(steps);
      if (!step_to(between(from, to, s), q)) return static_cast<double>(i - 1) / static_cast<double>(steps);
    }
    return 1;
  }

  bool step_to(const Pose& target, JointState& q) {
    ik::IkSolution solution;
    const ik::InverseKinematics* solver = arm_.facts().solver.get();
    if (!solver) {
      if (!own_) own_.emplace(arm_.facts().chain);
      solver = &*own_;
    }
    if (solver->solve(target, q, solution) != ik::IkOutcome::solved) return false;
    const JointState next(solution.q.begin(), solution.q.begin() + static_cast<std::ptrdiff_t>(q.size()));
    for (std::size_t i = 0; i < q.size(); ++i)
      if (std::abs(next[i] - q[i]) > jump(i)) return false;
    if (!path_.violated(next).empty()) return false;
    if (surroundings_) try {
        check_free(*surroundings_, {q, next}, Code::PLANNING_FAILED, "");
      } catch (const Refusal&) {
        return false;
      }
    q = next;
    return true;
  }

  /// A larger change in one step is another configuration.
  double jump(std::size_t joint) const {
    constexpr double kJump = 0.5;
    const double asked = arm_.facts().chain.slides(joint) ? request_.prismatic_jump_threshold
                                                          : request_.revolute_jump_threshold;
    return asked > 0 ? std::min(asked, kJump) : kJump;
  }

  moves::MovePlan timed(const std::vector<Pose>& ends) const {
    const auto share = [](double asked) { return asked > 0 && asked <= 1 ? asked : 1.0; };
    std::vector<moves::Move> moves;
    for (const Pose& end : ends) {
      moves::Move move;
      move.kind = moves::MoveKind::line;
      move.targets.push_back({end, fmt::format("waypoint {}", moves.size() + 1)});
      move.speed = share(request_.max_velocity_scaling_factor);
      move.acceleration = share(request_.max_acceleration_scaling_factor);
      if (request_.max_cartesian_speed > 0 && std::isfinite(request_.max_cartesian_speed))
        move.tcp_speed = request_.max_cartesian_speed;
      moves.push_back(std::move(move));
    }
    return moves::plan_moves(arm_.facts(), around_.joints(), moves, settings_.limits);
  }

  using Clock = std::chrono::steady_clock;

  const Clock::time_point end_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                    std::chrono::duration<double>(kLongestPlanning));
  Around around_;
  const srv::GetCartesianPath::Request& request_;
  const PlanSettings& settings_;
  const Arm& arm_;
  const Group& group_;
  const Goal path_;
  std::vector<Pose> targets_;
  std::optional<ik::InverseKinematics> own_;
  std::unique_ptr<surroundings::Surroundings> surroundings_;
};

}  // namespace

srv::GetCartesianPath::Response cartesian_path(const Around& around,
                                               const srv::GetCartesianPath::Request& request,
                                               const PlanSettings& settings) {
  srv::GetCartesianPath::Response out;
  try {
    Around now = around;
    take_state(request.start_state, now);
    out.start_state = robot_state(now, now.joints());
    CartesianPath(now, request, settings).run(out);
    out.error_code = success();
  } catch (const Refusal& refusal) {
    out.error_code = code_of(refusal);
    out.fraction = -1;
  } catch (const Error& error) {
    out.error_code = {Code::PLANNING_FAILED, error.problems().front().what, "polyarm"};
    out.fraction = -1;
  }
  return out;
}

}  // namespace polyarm::move_group
