#include "polyarm/move_group/plans.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "polyarm/move_group/goals.hpp"
#include "polyarm/move_group/poses.hpp"
#include "polyarm/move_group/trajectories.hpp"
#include "polyarm/planning/planner.hpp"
#include "polyarm/planning/pose_goals.hpp"

namespace polyarm::move_group {

namespace {

using planning::JointState;
using planning::PlanOutcome;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostSamples = 1'000'000, kMostStates = 60'000;
constexpr double kRoom = 0.8;         // of the distance that start and goal leave
constexpr double kLookEvery = 0.004;  // s along a timed path
constexpr int kMostAttempts = 10;

double since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// One motion plan request, resolved.
class Request {
 public:
  Request(Around around, const msg::MotionPlanRequest& message, const PlanSettings& settings)
      : around_(std::move(around)),
        message_(message),
        settings_(settings),
        arm_(*around_.arm),
        group_(arm_.group(message.group_name)),
        path_(around_, message.path_constraints) {
    double allowed = message.allowed_planning_time;
    if (!(allowed > 0)) allowed = kUsualPlanning;
    end_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                              std::chrono::duration<double>(std::min(allowed, kLongestPlanning)));
  }

  moves::MovePlan plan() {
    check();
    const std::string outside = arm_.outside_limits(around_.joints());
    if (!outside.empty())
      throw Refusal(Code::START_STATE_INVALID, "the start is outside the limits: " + outside);
    if (const std::string why = path_.violated(around_.joints()); !why.empty())
      throw Refusal(Code::START_STATE_VIOLATES_PATH_CONSTRAINTS, "the start: " + why);
    make_goals(false);
    try {
      return planned();
    } catch (const Refusal& refusal) {
      if (refusal.code == Code::START_STATE_IN_COLLISION || !has_pose_goals_) throw;
      make_goals(true);
      return planned();
    }
  }

 private:
  bool stopped() const { return (settings_.cancelled && settings_.cancelled()) || Clock::now() > end_; }

  void check() const {
    if (message_.goal_constraints.empty())
      throw Refusal(Code::INVALID_GOAL_CONSTRAINTS, "the request has no goal");
    if (message_.goal_constraints.size() > kMostAlternatives)
      throw Refusal(Code::INVALID_GOAL_CONSTRAINTS,
                    fmt::format("the request has {} goals; {} are possible", message_.goal_constraints.size(),
                                kMostAlternatives));
    if (!message_.trajectory_constraints.constraints.empty() || !message_.reference_trajectories.empty())
      throw Refusal(Code::INVALID_GOAL_CONSTRAINTS,
                    "trajectory constraints and reference trajectories are not supported");
  }

  /// Of the goals that can be resolved; if none can, the first reason counts.
  void make_goals(bool wide) {
    goals_.clear();
    std::optional<Refusal> first;
    for (const msg::Constraints& constraints : message_.goal_constraints) try {
        const Goal goal(around_, constraints);
        has_pose_goals_ = has_pose_goals_ || goal.has_poses();
        for (JointState& q : goal.states(group_, around_.joints(), wide)) add_goal(std::move(q), first);
      } catch (const Refusal& refusal) {
        if (!first) first = refusal;
      }
    if (goals_.empty() && (wide || !has_pose_goals_))
      throw first ? *first : Refusal(Code::GOAL_STATE_INVALID, "no goal is within limits");
  }

  void add_goal(JointState q, std::optional<Refusal>& first) {
    const std::string outside = arm_.outside_limits(q);
    const std::string path = path_.violated(q);
    if (outside.empty() && path.empty()) return goals_.push_back(std::move(q));
    if (first) return;
    first = outside.empty() ? Refusal(Code::GOAL_VIOLATES_PATH_CONSTRAINTS, "the goal: " + path)
                            : Refusal(Code::GOAL_STATE_INVALID, "the goal is outside the limits: " + outside);
  }

  moves::MovePlan planned() {
    if (goals_.empty()) throw Refusal(Code::NO_IK_SOLUTION, "no joint state reaches the goal");
    if (path_.has_poses()) return planned_within();
    const planning::Plan found = search(1);
    return timed(found);
  }

  /// With the cell's clearance; where start or goal leave less, with most of what they leave.
  planning::Plan search(std::uint64_t first_seed) {
    planning::PlanQuery query{around_.joints(), goals_, arm_.facts().chain.lower(),
                              arm_.facts().chain.upper()};
    for (std::size_t v = 0; v < query.lower.size(); ++v)
      if (!group_.has(v)) query.lower[v] = query.upper[v] = query.start[v];
    path_.narrow(query.lower, query.upper);
    planning::PlanOptions options;
    options.most_samples = kMostSamples;
    options.most_states = kMostStates;
    options.stop = [this] { return stopped(); };
    double clearance = settings_.clearance;
    surroundings_ = compiled(around_, query.start, clearance);
    planning::Plan out;
    bool narrow = false;
    const int attempts = std::clamp(message_.num_planning_attempts, 1, kMostAttempts);
    for (int attempt = 0; attempt < attempts; ++attempt) {
      options.seed = first_seed + static_cast<std::uint64_t>(attempt);
      out = planning::plan(surroundings_->probe(), query, options);
      const bool touches =
          out.outcome == PlanOutcome::start_touches || out.outcome == PlanOutcome::goal_touches;
      if (touches && !narrow && out.contact.distance > 0) {
        clearance = kRoom * room_of(query);
        if (!(clearance > 0)) break;
        narrow = true;
        surroundings_ = compiled(around_, query.start, clearance);
        --attempt;
        continue;
      }
      if (out.outcome != PlanOutcome::out_of_samples) break;
    }
    refuse_unless_found(out);
    return out;
  }

  double room_of(const planning::PlanQuery& query) {
    collision::Probe& probe = surroundings_->probe();
    double goal = 0;
    for (const JointState& q : query.goals) goal = std::max(goal, probe.nearest(q).distance);
    return std::min({settings_.clearance, probe.nearest(query.start).distance, goal});
  }

  void refuse_unless_found(const planning::Plan& plan) const {
    switch (plan.outcome) {
      case PlanOutcome::found:
        return;
      case PlanOutcome::start_touches:
        throw Refusal(Code::START_STATE_IN_COLLISION, plan.reason);
      case PlanOutcome::goal_touches:
        throw Refusal(Code::GOAL_IN_COLLISION, plan.reason);
      case PlanOutcome::out_of_time:
        if (settings_.cancelled && settings_.cancelled())
          throw Refusal(Code::PREEMPTED, "the request was cancelled");
        throw Refusal(Code::TIMED_OUT, plan.reason);
      default:
        throw Refusal(Code::PLANNING_FAILED, plan.reason);
    }
  }

  moves::Move move_to(JointState goal) const {
    moves::Move move;
    move.targets.push_back({std::move(goal), "the goal"});
    const auto share = [](double asked) { return asked > 0 && asked <= 1 ? asked : 1.0; };
    move.speed = share(message_.max_velocity_scaling_factor);
    move.acceleration = share(message_.max_acceleration_scaling_factor);
    if (message_.max_cartesian_speed > 0 && std::isfinite(message_.max_cartesian_speed))
      move.tcp_speed = message_.max_cartesian_speed;
    return move;
  }

  moves::MovePlan timed(const planning::Plan& plan) {
    moves::Move move = move_to(plan.waypoints.back());
    const std::vector<double> radii =
        planning::corner_radii(surroundings_->probe(), plan.waypoints, plan.exact);
    for (std::size_t k = 1; k + 1 < plan.waypoints.size(); ++k)
      move.over.push_back({plan.waypoints[k], radii[k]});
    return moves::plan_moves(arm_.facts(), around_.joints(), std::vector{move}, settings_.limits);
  }

  /// With constraints of the tool's pose along the path: a line of the TCP, the straight joint move, and ways
  /// around obstacles that happen to keep them.
  moves::MovePlan planned_within() {
    std::string why;
    const planning::Plan found = search(1);
    const auto keeps = [&](const moves::MovePlan& plan) {
      along(plan, kLookEvery, [&](std::span<const double> q) { return (why = path_.violated(q)).empty(); });
      return why.empty();
    };
    for (const JointState& goal : goals_) {
      if (stopped()) throw Refusal(Code::TIMED_OUT, "no way within the path constraints was found in time");
      if (const auto plan = line_to(goal); plan && keeps(*plan)) return *plan;
    }
    for (std::uint64_t seed = 2;; ++seed) {
      const moves::MovePlan plan = timed(seed == 2 ? found : search(seed));
      if (keeps(plan)) return plan;
      if (seed >= kMostAttempts || stopped()) break;
    }
    throw Refusal(
        Code::PLANNING_FAILED,
        "no way that keeps the path constraints was found: a line of the tool and ways around obstacles were "
        "tried. On the last one " +
            why);
  }

  std::optional<moves::MovePlan> line_to(const JointState& goal) {
    const moves::RobotFacts& facts = arm_.facts();
    moves::Move move = move_to(goal);
    move.kind = moves::MoveKind::line;
    move.targets.front().at = facts.chain.forward(goal);
    try {
      moves::MovePlan plan = moves::plan_moves(facts, around_.joints(), std::vector{move}, settings_.limits);
      for (std::size_t i = 0; i < goal.size(); ++i)
        if (!has_pose_goals_ && std::abs(plan.end[i] - goal[i]) > 1e-3) return std::nullopt;
      std::vector<JointState> states;
      along(plan, kLookEvery, [&](std::span<const double> q) {
        states.emplace_back(q.begin(), q.end());
        return true;
      });
      check_free(*surroundings_, states, Code::PLANNING_FAILED, "the line");
      return plan;
    } catch (const Error&) {
      return std::nullopt;
    } catch (const Refusal&) {
      return std::nullopt;
    }
  }

  Around around_;
  const msg::MotionPlanRequest& message_;
  const PlanSettings& settings_;
  const Arm& arm_;
  const Group& group_;
  const Goal path_;
  Clock::time_point end_;
  std::vector<JointState> goals_;
  bool has_pose_goals_ = false;
  std::unique_ptr<surroundings::Surroundings> surroundings_;
};

/// Carries out `work` and turns what it throws into a code.
template <class Work>
Code answered(Work work) {
  try {
    work();
    return success();
  } catch (const Refusal& refusal) {
    return code_of(refusal);
  } catch (const Error& error) {
    return {Code::PLANNING_FAILED, error.problems().front().what, "polyarm"};
  } catch (const std::exception& error) {
    return {Code::FAILURE, error.what(), "polyarm"};
  }
}

msg::ContactInformation contact_of(const Around& around, const collision::Contact& contact) {
  msg::ContactInformation out;
  out.header.frame_id = around.arm->planning_frame();
  const Pose T_frame_world = inverse(around.base());
  const Vec3 at = T_frame_world * (0.5 * (contact.on_first + contact.on_second));
  const Vec3 normal = T_frame_world.rotation * normalized(contact.on_second - contact.on_first);
  out.position = {at.x, at.y, at.z};
  out.normal = {normal.x, normal.y, normal.z};
  out.depth = std::max(0.0, -contact.distance);
  out.contact_body_1 = body_name(contact.first);
  out.body_type_1 = body_type(contact.first);
  out.contact_body_2 = body_name(contact.second);
  out.body_type_2 = body_type(contact.second);
  return out;
}

/// The contact at a state, if something touches.
std::optional<collision::Contact> contact_at(const Around& around, std::span<const double> q) {
  const auto surroundings = compiled(around, q, 0);
  if (!surroundings->probe().touches_exactly(q)) return std::nullopt;
  collision::Contact contact = surroundings->probe().nearest(q);
  if (contact.distance > 0) return std::nullopt;
  return contact;
}

}  // namespace

void take_state(const msg::RobotState& state, Around& around) {
  std::vector<double>& q = around.moment.robots[around.arm->index()].joints;
  std::vector<double> next = q;
  around.arm->set_joints(state.joint_state, next);
  const int tool = around.arm->model().tool_link();
  const Pose T_new_old = around.link_in_world(tool, next) * inverse(around.link_in_world(tool));
  for (auto& part : around.moment.parts)
    if (part.in_world && part.held_by == static_cast<int>(around.arm->index()))
      part.pose = T_new_old * part.pose;
  q = std::move(next);
  for (const msg::AttachedCollisionObject& object : state.attached_collision_objects) {
    const description::Scene& scene = *around.bodies.scene;
    if (std::any_of(scene.parts.begin(), scene.parts.end(),
                    [&](const auto& p) { return p.name == object.object.id; }))
      continue;
    SceneState made = *around.scene;
    apply(around, object, made);
    around.scene = std::make_shared<const SceneState>(std::move(made));
  }
}

msg::MotionPlanResponse plan(const Around& around, const msg::MotionPlanRequest& request,
                             const PlanSettings& settings) {
  const auto begin = Clock::now();
  msg::MotionPlanResponse out;
  out.group_name = request.group_name;
  out.error_code = answered([&] {
    Around now = around;
    take_state(request.start_state, now);
    out.trajectory_start = robot_state(now, now.joints());
    const Group& group = now.arm->group(request.group_name);
    const moves::MovePlan made = Request(now, request, settings).plan();
    out.group_name = group.name;
    out.trajectory = to_message(*now.arm, group, made, now.joints());
  });
  out.planning_time = since(begin);
  return out;
}

srv::GetPositionIK::Response solve_ik(const Around& around, const msg::PositionIKRequest& request,
                                      const PlanSettings& settings) {
  srv::GetPositionIK::Response out;
  out.error_code = answered([&] {
    Around now = around;
    take_state(request.robot_state, now);
    const Group& group = now.arm->group(request.group_name);
    if (request.ik_link_names.size() > 1 || request.pose_stamped_vector.size() > 1)
      throw Refusal(Code::NO_IK_SOLUTION, "several links at once are not supported");
    const bool listed = !request.pose_stamped_vector.empty();
    const geometry::PoseStamped& target = listed ? request.pose_stamped_vector.front() : request.pose_stamped;
    std::string name = request.ik_link_names.empty() ? request.ik_link_name : request.ik_link_names.front();
    if (name.empty() && group.tip >= 0) name = now.arm->link_name(group.tip);
    if (!group.solvable)
      throw Refusal(Code::NO_IK_SOLUTION, "the group '" + group.name + "' has no inverse kinematics");
    const int link = now.arm->link(name);
    const Pose pose = now.frame(target.header.frame_id) *
                      pose_of(target.pose, "the target", Code::INVALID_GOAL_CONSTRAINTS);
    const Pose tcp = now.arm->facts().chain.base() * inverse(now.base()) * pose * now.arm->tcp_in_link(link);
    const Goal constraints(now, request.constraints);
    const std::optional<ik::InverseKinematics> made =
        now.arm->facts().solver ? std::nullopt
                                : std::optional<ik::InverseKinematics>(std::in_place, now.arm->facts().chain);
    const ik::InverseKinematics& solver = made ? *made : *now.arm->facts().solver;
    std::string why;
    for (const JointState& q : planning::goals_for(solver, tcp, now.joints())) {
      if (settings.cancelled && settings.cancelled())
        throw Refusal(Code::PREEMPTED, "the request was cancelled");
      const std::string violated = constraints.violated(q);
      const auto contact = violated.empty() && request.avoid_collisions ? contact_at(now, q) : std::nullopt;
      if (violated.empty() && !contact) {
        out.solution = robot_state(now, q);
        return;
      }
      if (why.empty()) why = contact ? planning::text_of(*contact) : violated;
    }
    throw Refusal(Code::NO_IK_SOLUTION, why.empty()
                                            ? solver.explain(tcp, now.joints()).reason
                                            : "no solution keeps what is asked; at the nearest one " + why);
  });
  return out;
}

srv::GetPositionFK::Response solve_fk(const Around& around, const srv::GetPositionFK::Request& request) {
  srv::GetPositionFK::Response out;
  out.error_code = answered([&] {
    Around now = around;
    take_state(request.robot_state, now);
    const Pose frame = inverse(now.frame(request.header.frame_id));
    if (request.fk_link_names.empty()) throw Refusal(Code::INVALID_LINK_NAME, "no link is named");
    if (request.fk_link_names.size() > kMostConstraints)
      throw Refusal(Code::INVALID_LINK_NAME, "too many links are named");
    for (const std::string& name : request.fk_link_names) {
      geometry::PoseStamped made;
      made.header.frame_id =
          request.header.frame_id.empty() ? now.arm->planning_frame() : request.header.frame_id;
      made.pose = to_message(frame * now.link_in_world(now.arm->link(name)));
      out.pose_stamped.push_back(std::move(made));
      out.fk_link_names.push_back(name);
    }
  });
  return out;
}

srv::GetStateValidity::Response validity(const Around& around,
                                         const srv::GetStateValidity::Request& request) {
  srv::GetStateValidity::Response out;
  Around now = around;
  take_state(request.robot_state, now);
  now.arm->group(request.group_name);
  const Goal constraints(now, request.constraints);
  out.constraint_result = constraints.evaluate(now.joints());
  out.valid = now.arm->outside_limits(now.joints()).empty() && constraints.violated(now.joints()).empty();
  if (const auto contact = contact_at(now, now.joints())) {
    out.valid = false;
    out.contacts.push_back(contact_of(now, *contact));
  }
  return out;
}

void check_trajectory(const Around& around, const msg::RobotTrajectory& trajectory, std::size_t from) {
  const auto& joints = trajectory.joint_trajectory;
  if (!trajectory.multi_dof_joint_trajectory.points.empty())
    throw Refusal(Code::INVALID_MOTION_PLAN,
                  "a trajectory of joints with several degrees of freedom is not supported");
  if (joints.points.size() > kMostTrajectoryPoints)
    throw Refusal(Code::INVALID_MOTION_PLAN, fmt::format("the trajectory has {} points; {} are possible",
                                                         joints.points.size(), kMostTrajectoryPoints));
  std::vector<std::vector<double>> states;
  if (from == 0) states.push_back(around.joints());
  for (std::size_t i = from; i < joints.points.size(); ++i) {
    messages::sensor_msgs::msg::JointState state;
    state.name = joints.joint_names;
    state.position = joints.points[i].positions;
    std::vector<double> q = around.joints();
    try {
      around.arm->set_joints(state, q);
    } catch (const Refusal& refusal) {
      throw Refusal(Code::INVALID_MOTION_PLAN, fmt::format("point {}: {}", i, refusal.what()));
    }
    states.push_back(std::move(q));
  }
  const auto surroundings = compiled(around, around.joints(), 0);
  check_free(*surroundings, states, Code::MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE,
             "the trajectory hits something");
}

void check_start(const Around& around, const msg::RobotTrajectory& trajectory) {
  constexpr double kNear = 0.01;  // rad or m, as MoveIt's allowed_start_tolerance
  const auto& joints = trajectory.joint_trajectory;
  if (joints.points.empty()) throw Refusal(Code::INVALID_MOTION_PLAN, "the trajectory has no points");
  for (std::size_t j = 0; j < joints.joint_names.size(); ++j) {
    const auto variable = around.arm->find_joint(joints.joint_names[j]);
    if (!variable || j >= joints.points.front().positions.size()) continue;
    const double off = std::abs(joints.points.front().positions[j] - around.joints()[*variable]);
    if (!(off <= kNear))
      throw Refusal(Code::CONTROL_FAILED,
                    fmt::format("the trajectory begins {:.4f} away from where {} is; {} is allowed", off,
                                joints.joint_names[j], kNear));
  }
}

}  // namespace polyarm::move_group
