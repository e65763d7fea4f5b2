/// The actions move_action and execute_trajectory: a plan is made beside the cell thread, and its trajectory
/// goes to controllers as any goal of ROS 2 does.
#include <algorithm>
#include <cmath>
#include <map>

#include "polyarm/move_group/groups.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/ros2/goal_server.hpp"
#include "polyarm/ros2/move_group_cell.hpp"

namespace polyarm::ros2 {

namespace {

using move_group::Code;
using move_group::Refusal;
namespace msg = move_group::msg;
using MoveGroupGoal = messages::moveit_msgs::action::MoveGroup::Goal;
using MoveGroupResult = messages::moveit_msgs::action::MoveGroup::Result;
using ExecuteGoal = messages::moveit_msgs::action::ExecuteTrajectory::Goal;
using ExecuteResult = messages::moveit_msgs::action::ExecuteTrajectory::Result;

constexpr int kMostReplans = 10;
/// After a cancelled motion the next plan begins when no joint moves faster than kStill / kBetweenLooks, or
/// after kLongestStop.
constexpr double kStill = 2e-4;  // rad or m
constexpr Nanoseconds kBetweenLooks = 20'000'000, kLongestStop = 3'000'000'000;

template <class Message>
bool from_json(const Json& fields, Message& out) {
  return messages::from_cdr(messages::from_json(messages::type_info<Message>(), fields), out) ==
         messages::CdrError::none;
}

double seconds_of(const messages::builtin_interfaces::msg::Duration& time) {
  return time.sec + 1e-9 * time.nanosec;
}

/// The part of a trajectory that goes to one controller.
struct ControllerGoal {
  move_group::Actor actor;
  Json message;
};

/// All joints of the controller: those that the trajectory leaves out stay where they are.
Json trajectory_for(const move_group::Actor& actor, const move_group::Arm& arm, std::span<const double> now,
                    const messages::trajectory_msgs::msg::JointTrajectory& trajectory) {
  Json points = Json::array();
  std::vector<int> columns;
  for (const std::string& joint : actor.joints) {
    const auto at = std::find(trajectory.joint_names.begin(), trajectory.joint_names.end(), joint);
    columns.push_back(
        at == trajectory.joint_names.end() ? -1 : static_cast<int>(at - trajectory.joint_names.begin()));
  }
  for (const auto& point : trajectory.points) {
    Json made{{"time_from_start", seconds_of(point.time_from_start)}};
    const auto list = [&](const char* key, const std::vector<double>& values, bool positions) {
      if (values.size() != trajectory.joint_names.size()) return;
      Json& out = made[key] = Json::array();
      for (std::size_t j = 0; j < actor.joints.size(); ++j) {
        const auto variable = arm.find_joint(actor.joints[j]);
        out.push_back(columns[j] >= 0 ? values[static_cast<std::size_t>(columns[j])]
                                      : (positions && variable ? now[*variable] : 0.0));
      }
    };
    list("positions", point.positions, true);
    list("velocities", point.velocities, false);
    list("accelerations", point.accelerations, false);
    points.push_back(std::move(made));
  }
  std::vector<std::string> names;  // whole, so that they mean this robot's in any cell
  for (const std::string& joint : actor.joints) names.push_back(arm.name() + "/" + joint);
  return {{"trajectory", {{"joint_names", names}, {"points", std::move(points)}}}};
}

/// The end of the first of its joints that the trajectory moves.
Json gripper_goal_for(const move_group::Actor& actor,
                      const messages::trajectory_msgs::msg::JointTrajectory& trajectory) {
  const auto at = std::find_first_of(trajectory.joint_names.begin(), trajectory.joint_names.end(),
                                     actor.joints.begin(), actor.joints.end());
  const auto& positions = trajectory.points.back().positions;
  const auto index = static_cast<std::size_t>(at - trajectory.joint_names.begin());
  if (index >= positions.size())
    throw Refusal(Code::INVALID_MOTION_PLAN, "the last point has too few positions");
  const double position = positions[index];
  if (actor.type == "ParallelGripperCommand")
    return {{"command", {{"name", Json::array({*at})}, {"position", Json::array({position})}}}};
  return {{"command", {{"position", position}, {"max_effort", 0.0}}}};
}

}  // namespace

/// One goal at a time. May outlive its owner while the cell still has replies to send.
struct MoveGroupMotion::Work : std::enable_shared_from_this<Work> {
  /// A goal under way.
  struct Run {
    GoalPointer goal;
    GoalServer* server = nullptr;
    bool plans = false;  ///< move_action; else execute_trajectory
    MoveGroupGoal request;
    MoveGroupResult result;
    std::vector<std::string> wanted;  ///< controllers that the client names; empty: any
    std::shared_ptr<std::atomic<bool>> cancelled = std::make_shared<std::atomic<bool>>(false);
    bool preempted = false;  ///< by a newer goal
    int replans = 0;
    std::uint64_t turn = 0;   ///< of the cell, when the goal came
    std::uint64_t scene = 0;  ///< version that the trajectory was checked with
    bool checking = false;
    bool plans_again = false;               ///< once the robot stands
    std::map<std::string, double> reached;  ///< s along the trajectory, as its controllers report
    std::string invalidated;                ///< why the trajectory became invalid while it was carried out
    std::size_t sent = 0, ended = 0;
    std::string failure;
    std::vector<std::pair<std::string, std::uint64_t>> numbers;  ///< goals of the cell under way
    Nanoseconds began = 0;
  };
  using RunPointer = std::shared_ptr<Run>;

  Work(MoveGroupCell& to, std::shared_ptr<const move_group::Arm> of) : shared{to}, arm{std::move(of)} {}

  void begin(const std::string& node, const std::string& space) {
    move = std::make_shared<GoalServer>(shared.bridge, node, space + "/move_action",
                                        "moveit_msgs/action/MoveGroup");
    execute = std::make_shared<GoalServer>(shared.bridge, node, space + "/execute_trajectory",
                                           "moveit_msgs/action/ExecuteTrajectory");
    shown = shared.bridge.wire().publisher(node, space + "/display_planned_path",
                                           shared.bridge.type("moveit_msgs/msg/DisplayTrajectory"));
    for (GoalServer* server : {move.get(), execute.get()}) {
      const std::weak_ptr<Work> self = weak_from_this();
      server->begin({[self, server](const GoalPointer& goal, Json message, const Reply& reply) {
                       if (const auto work = self.lock()) work->take(*server, goal, message, reply);
                     },
                     [self](const GoalPointer& goal) {
                       if (const auto work = self.lock()) work->cancel(goal);
                     }});
    }
  }

  void take(GoalServer& server, const GoalPointer& goal, const Json& message, const Reply& reply) {
    const auto run = std::make_shared<Run>();
    run->goal = goal;
    run->server = &server;
    run->plans = &server == move.get();
    run->turn = turn;
    ExecuteGoal asked;
    const bool good = run->plans ? from_json(message, run->request) : from_json(message, asked);
    if (!good) return server.refuse(goal, reply);
    run->result.planned_trajectory = std::move(asked.trajectory);
    run->wanted = std::move(asked.controller_names);
    server.accept(goal, reply);
    if (!current && settling_since < 0) return start(run);
    if (next) finish(next, Code::PREEMPTED, "a newer goal took its place");
    next = run;
    if (!current) return;
    current->preempted = true;
    stop(*current);
  }

  void cancel(const GoalPointer& goal) {
    if (next && next->goal == goal) {
      finish(next, Code::PREEMPTED, "the goal was cancelled");
      next.reset();
    }
    if (current && current->goal == goal) stop(*current);
  }

  /// Ends planning and the goals of controllers.
  void stop(Run& run) {
    run.cancelled->store(true);
    for (const auto& [target, number] : run.numbers)
      shared.bridge.ask(protocol::GoalCancel{target, static_cast<double>(number)},
                        [](const protocol::Reply&) {});
  }

  void start(const RunPointer& run) {
    current = run;
    if (run->plans) return plan(run);
    tell_state(*run, "MONITOR");
    check(run, true);
  }

  void tell_state(const Run& run, const char* state) {
    run.server->tell_feedback(*run.goal, {{"state", state}});
  }

  void plan(const RunPointer& run) {
    tell_state(*run, "PLANNING");
    const bool posted = shared.work.plan([self = shared_from_this(), run, look = shared.look(arm),
                                          settings = shared.settings(run->cancelled)]() -> LongWork::Then {
      msg::MotionPlanResponse response;
      std::uint64_t scene = 0;
      try {
        move_group::Around around = look();
        scene = around.scene->version;
        const msg::PlanningScene& diff = run->request.planning_options.planning_scene_diff;
        std::vector<std::string> notes;
        if (diff.is_diff && run->request.planning_options.planning_scene_diff != msg::PlanningScene{})
          around.scene =
              std::make_shared<const move_group::SceneState>(move_group::applied(around, diff, notes));
        response = move_group::plan(around, run->request.request, settings);
      } catch (const Refusal& refusal) {
        response.error_code = move_group::code_of(refusal);
      } catch (const std::exception& error) {
        response.error_code = {Code::FAILURE, error.what(), "polyarm"};
      }
      return [self, run, scene, response = std::move(response)] { self->planned(run, scene, response); };
    });
    if (!posted) finish(run, Code::FAILURE, "too many requests wait");
  }

  void planned(const RunPointer& run, std::uint64_t scene, const msg::MotionPlanResponse& response) {
    run->scene = scene;
    run->result.trajectory_start = response.trajectory_start;
    run->result.planned_trajectory = response.trajectory;
    run->result.planning_time += response.planning_time;
    if (run->cancelled->load()) return finish(run, Code::PREEMPTED, why_stopped(*run));
    if (response.error_code.val != Code::SUCCESS)
      return finish(run, response.error_code.val, response.error_code.message);
    show(response);
    if (run->request.planning_options.plan_only) return finish(run, Code::SUCCESS, "");
    tell_state(*run, "MONITOR");
    send(run);
  }

  void show(const msg::MotionPlanResponse& response) {
    if (!shared.bridge.wire().wanted(shown)) return;
    msg::DisplayTrajectory display{arm->model().name, {response.trajectory}, response.trajectory_start};
    shared.bridge.wire().publish(shown, encode(shared.bridge, display));
  }

  /// Looks whether what is left of a trajectory is free. `whole`: before it is sent.
  void check(const RunPointer& run, bool whole) {
    run->checking = true;
    // A cell that is slowed down or held is behind the clock.
    double done = whole || run->reached.empty() ? 0 : seconds(shared.bridge.cell().now() - run->began);
    for (const auto& [to, time] : run->reached) done = std::min(done, time);
    // Not behind the plans of others: an object may be in the way of a robot that moves.
    const bool posted = shared.work.query(
        [self = shared_from_this(), run, whole, done, look = shared.look(arm)]() -> LongWork::Then {
          Code code = move_group::success();
          std::uint64_t scene = 0;
          try {
            const move_group::Around around = look();
            scene = around.scene->version;
            const auto& points = run->result.planned_trajectory.joint_trajectory.points;
            std::size_t from = 0;
            if (!whole)
              while (from + 1 < points.size() && seconds_of(points[from + 1].time_from_start) < done) ++from;
            if (whole) move_group::check_start(around, run->result.planned_trajectory);
            move_group::check_trajectory(around, run->result.planned_trajectory, from);
          } catch (const Refusal& refusal) {
            code = move_group::code_of(refusal);
          } catch (const std::exception& error) {
            code = {Code::FAILURE, error.what(), "polyarm"};
          }
          return [self, run, whole, scene, code] { self->checked(run, whole, scene, code); };
        });
    if (posted) return;
    run->checking = false;  // asked again in the next tick
    if (whole) finish(run, Code::FAILURE, "too many requests wait");
  }

  void checked(const RunPointer& run, bool whole, std::uint64_t scene, const Code& code) {
    run->checking = false;
    run->scene = scene;
    if (run != current) return;
    if (whole) {
      if (run->cancelled->load()) return finish(run, Code::PREEMPTED, why_stopped(*run));
      if (code.val != Code::SUCCESS) return finish(run, code.val, code.message);
      return send(run);
    }
    if (code.val == Code::SUCCESS || run->cancelled->load()) return;
    run->invalidated = code.message;
    stop(*run);
  }

  /// Hands the trajectory to controllers, as goals of clients are.
  void send(const RunPointer& run) {
    try {
      if (run->turn != turn)
        throw Refusal(Code::CONTROL_FAILED,
                      "the cell was stopped or started since the goal came: send it again");
      const std::vector<ControllerGoal> goals = goals_of(*run);
      if (run->result.planned_trajectory.joint_trajectory.points.size() == 1)  // it is there already
        return finish(run, Code::SUCCESS, "");
      run->began = shared.bridge.cell().now();
      run->sent = goals.size();
      run->ended = 0;
      run->reached.clear();
      for (const ControllerGoal& goal : goals)
        if (!goal.actor.gripper()) run->reached[goal.actor.name + "/" + goal.actor.action] = 0;
      for (const ControllerGoal& goal : goals) send(run, goal);
    } catch (const Refusal& refusal) {
      finish(run, refusal.code, refusal.what());
    }
  }

  std::vector<ControllerGoal> goals_of(const Run& run) const {
    const auto& trajectory = run.result.planned_trajectory.joint_trajectory;
    const move_group::Around around{arm, {}, shared.bridge.cell().moment(), shared.scene->now()};
    move_group::check_start(around, run.result.planned_trajectory);
    const std::vector<double>& now = around.joints();
    std::vector<ControllerGoal> out;
    std::vector<std::string> left = trajectory.joint_names;
    std::erase_if(left, [&](const std::string& joint) { return !arm->find_joint(joint); });
    for (const bool gripper : {false, true})
      for (const move_group::Actor& actor :
           move_group::actors_of(shared.bridge.cell().controllers(), arm->name())) {
        const bool named =
            run.wanted.empty() || std::count(run.wanted.begin(), run.wanted.end(), actor.name) > 0;
        const bool moves = std::any_of(
            actor.joints.begin(), actor.joints.end(),
            [&](const std::string& joint) { return std::count(left.begin(), left.end(), joint) > 0; });
        if (actor.gripper() != gripper || !named || !moves || !actor.active) continue;
        out.push_back({actor, gripper ? gripper_goal_for(actor, trajectory)
                                      : trajectory_for(actor, *arm, now, trajectory)});
        std::erase_if(left, [&](const std::string& joint) {
          return std::count(actor.joints.begin(), actor.joints.end(), joint) > 0;
        });
      }
    if (!left.empty())
      throw Refusal(Code::CONTROL_FAILED,
                    "no active controller follows trajectories of " + left.front() +
                        ": activate one that accepts FollowJointTrajectory or gripper goals");
    return out;
  }

  void send(const RunPointer& run, const ControllerGoal& goal) {
    protocol::SendMessage sent;
    sent.to = goal.actor.name + "/" + goal.actor.action;
    sent.message = protocol::Message(goal.message);
    sent.goal = true;
    shared.bridge.ask(std::move(sent), [self = shared_from_this(), run, to = sent.to](
                                           const protocol::Reply& reply) { self->answered(run, to, reply); });
  }

  void answered(const RunPointer& run, const std::string& to, const protocol::Reply& reply) {
    if (closed) return;
    if (reply.refusal) return ended(run, to + ": " + refusal_of(reply));
    const protocol::SendMessage::Answer& answer = reply.answer->as<protocol::SendMessage>();
    if (answer.feedback) return take_feedback(*run, to, answer.feedback->json());
    const std::string status = answer.status.value_or("");
    if (status == "accepted") {
      run->numbers.emplace_back(to, answer.goal.value_or(0));
      if (run->cancelled->load()) stop(*run);
    } else if (status == "succeeded") {
      ended(run, "");
    } else if (status == "aborted" || status == "canceled") {
      std::string why = answer.error.value_or("");
      if (why.empty()) why = answer.note.value_or("the motion was ended at the cell");
      if (answer.joint) why += " (" + *answer.joint + ")";
      ended(run, to + ": " + why);
    }
  }

  static void take_feedback(Run& run, const std::string& to, const Json& state) {
    const auto reached = run.reached.find(to);
    const auto reference = state.find("reference");
    if (reached == run.reached.end() || reference == state.end()) return;
    const auto time = reference->find("time_from_start");
    if (time != reference->end() && time->is_number()) reached->second = time->get<double>();
  }

  /// One of the controllers is done. If it failed, the others are stopped.
  void ended(const RunPointer& run, const std::string& failure) {
    ++run->ended;
    if (run->failure.empty() && !failure.empty()) {
      run->failure = failure;
      if (run->ended < run->sent) stop(*run);
    }
    if (run->ended < run->sent) return;
    run->numbers.clear();
    if (run->failure.empty()) {
      run->result.executed_trajectory = run->result.planned_trajectory;
      return finish(run, Code::SUCCESS, "");
    }
    settling_since = looked_at = shared.bridge.cell().now();
    last_joints.clear();
    if (!run->invalidated.empty()) return replan_or_end(run);
    const bool stopped = run->preempted || run->goal->status == GoalStatus::STATUS_CANCELING;
    finish(run, stopped ? Code::PREEMPTED : Code::CONTROL_FAILED, stopped ? why_stopped(*run) : run->failure);
  }

  void replan_or_end(const RunPointer& run) {
    const auto& options = run->request.planning_options;
    const int most = options.replan ? std::clamp(options.replan_attempts, 1, kMostReplans) : 0;
    if (!run->plans || run->replans >= most || run->preempted ||
        run->goal->status == GoalStatus::STATUS_CANCELING)
      return finish(run, Code::MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE, run->invalidated);
    ++run->replans;
    shared.tell("it plans again: " + run->invalidated);
    run->invalidated.clear();
    run->failure.clear();
    run->sent = run->ended = 0;
    run->cancelled = std::make_shared<std::atomic<bool>>(false);
    run->plans_again = true;
  }

  static std::string why_stopped(const Run& run) {
    return run.preempted ? "a newer goal took its place" : "the goal was cancelled";
  }

  void finish(const RunPointer& run, int code, const std::string& why) {
    if (code != Code::SUCCESS)
      shared.tell("a goal of " + arm->name() + " ended with code " + std::to_string(code) + ": " + why);
    const Code answer{code, why, "polyarm"};
    Json result;
    if (run->plans) {
      run->result.error_code = answer;
      result = json_of(run->result);
    } else {
      result = json_of(ExecuteResult{answer});
    }
    const bool canceled = run->goal->status == GoalStatus::STATUS_CANCELING && code == Code::PREEMPTED;
    run->server->end(run->goal,
                     code == Code::SUCCESS ? GoalStatus::STATUS_SUCCEEDED
                     : canceled            ? GoalStatus::STATUS_CANCELED
                                           : GoalStatus::STATUS_ABORTED,
                     std::move(result));
    if (run != current) return;
    current.reset();
    if (next && settling_since < 0) start(std::exchange(next, nullptr));
  }

  /// Goes on once the robot stands after a motion that was cut short.
  void settle() {
    if (settling_since < 0) return;
    const Nanoseconds now = shared.bridge.cell().now();
    if (now - looked_at < kBetweenLooks) return;
    looked_at = now;
    const std::vector<double> q = shared.bridge.cell().moment().robots[arm->index()].joints;
    const bool stands = q.size() == last_joints.size() &&
                        std::equal(q.begin(), q.end(), last_joints.begin(),
                                   [](double a, double b) { return std::abs(a - b) < kStill; });
    last_joints = q;
    if (!stands && now - settling_since < kLongestStop) return;
    settling_since = -1;
    if (const RunPointer run = current; run && std::exchange(run->plans_again, false)) {
      if (run->cancelled->load()) return finish(run, Code::PREEMPTED, why_stopped(*run));
      return plan(run);
    }
    if (!current && next) start(std::exchange(next, nullptr));
  }

  void serve() {
    move->serve();
    execute->serve();
    const bool runs = shared.bridge.cell().snapshot().state == control::RunState::running;
    if (std::exchange(running, runs) != runs) ++turn;
    settle();
    if (current && current->ended < current->sent && !current->checking && !current->cancelled->load() &&
        shared.scene->now()->version != current->scene)
      check(current, false);
  }

  MoveGroupCell& shared;
  const std::shared_ptr<const move_group::Arm> arm;
  std::shared_ptr<GoalServer> move, execute;
  Wire::Id shown = 0;
  RunPointer current, next;
  bool closed = false;
  bool running = true;     ///< the cell, at the last tick
  std::uint64_t turn = 0;  ///< counts how often the cell was stopped and started
  /// Since when the robot may still move after a motion that was cut short; -1: it stands.
  Nanoseconds settling_since = -1, looked_at = 0;
  std::vector<double> last_joints;
};

MoveGroupMotion::MoveGroupMotion(MoveGroupCell& shared, std::shared_ptr<const move_group::Arm> arm,
                                 std::string node, const std::string& space)
    : work_{std::make_shared<Work>(shared, std::move(arm))} {
  work_->begin(node, space);
}

MoveGroupMotion::~MoveGroupMotion() {
  work_->closed = true;
  if (work_->current) work_->current->cancelled->store(true);
  work_->move->close();
  work_->execute->close();
}

void MoveGroupMotion::serve() {
  work_->serve();
}

}  // namespace polyarm::ros2
