/// The node /move_group: what clients of MoveIt ask of it, one for each robot.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "polyarm/description/plain_urdf.hpp"
#include "polyarm/description/self_collision.hpp"
#include "polyarm/description/srdf.hpp"
#include "polyarm/move_group/groups.hpp"
#include "polyarm/move_group/scene.hpp"
#include "polyarm/ros2/move_group_cell.hpp"

namespace polyarm::ros2 {

namespace {

using move_group::Arm;
using move_group::Code;
namespace msg = move_group::msg;
namespace srv = move_group::srv;

constexpr Nanoseconds kStates = 100'000'000;  // between states of the robot on monitored_planning_scene
constexpr Nanoseconds kBetweenReports = 1'000'000'000;
constexpr int kPairSamples = 2000;  // joint states that are compared for the SRDF
constexpr double kMoved = 1e-4;     // rad or m: less is not told
const char* const kPipeline = "polyarm";
const char* const kPlanner = "RRTConnect";

bool is_at_origin(const Pose& pose) {
  return norm(pose.position) == 0 && std::abs(pose.rotation.w) == 1;
}

/// One robot's node.
class MoveGroupNode {
 public:
  MoveGroupNode(MoveGroupCell& shared, std::size_t robot, std::shared_ptr<const Arm> arm)
      : shared_{shared},
        bridge_{shared.bridge},
        robot_{*shared.bridge.cell().robots()[robot]},
        space_{bridge_.name(bridge_.cell().robots().size() == 1 ? "" : robot_.entry.name)},
        arm_{std::move(arm)} {
    while (space_.ends_with('/')) space_.pop_back();
    node_ = space_ + "/move_group";
    motion_.emplace(shared_, arm_, node_, space_);
    scene_topic_ =
        bridge_.wire().publisher(node_, space_ + "/monitored_planning_scene",
                                 bridge_.type("moveit_msgs/msg/PlanningScene"), {true, false, 100});
    semantic_topic_ =
        bridge_.wire().publisher(node_, space_ + "/robot_description_semantic",
                                 messages::type_info<messages::std_msgs::msg::String>(), {true, true, 1});
    offer_services();
    listen();
    offer_standard_services(bridge_, node_, parameters());
    make_semantic();
  }

  void serve() {
    motion_->serve();
    tell_state();
  }
  /// Sends the whole scene to those who follow it.
  void tell_scene() {
    if (!bridge_.wire().wanted(scene_topic_)) return;
    shared_.work.query([this, look = shared_.look(arm_)]() -> LongWork::Then {
      return [this, scene = move_group::to_message(look(), 0)] {
        bridge_.wire().publish(scene_topic_, encode(bridge_, scene));
      };
    });
  }
  static std::shared_ptr<const Arm> make_arm(Bridge& bridge, std::size_t robot) {
    const cell::CellRobot& of = *bridge.cell().robots()[robot];
    description::RobotModel model = of.model;
    move_group::add_groups(model, of.entry.name,
                           move_group::actors_of(bridge.cell().controllers(), of.entry.name));
    return std::make_shared<const Arm>(*of.facts, std::move(model), robot);
  }
  /// Called after each change of the scene.
  std::function<void()> on_change;

 private:
  template <class Request, class Response>
  using Answer =
      std::function<Response(const move_group::Around&, const Request&, const move_group::PlanSettings&)>;

  /// A service whose request and response are structs. `answer` runs on another thread.
  template <class Request, class Response>
  void serve(const char* name, const char* type, Answer<Request, Response> answer) {
    bridge_.wire().service(
        node_, space_ + "/" + name, type, [this, answer = std::move(answer), name](Wire::Request call) {
          const auto request = std::make_shared<Request>();
          if (!decode(bridge_, call.payload, *request)) return false;
          const auto reply =
              std::make_shared<std::function<void(std::vector<std::byte>)>>(std::move(call.answer));
          const bool plans = std::string_view(name) == "plan_kinematic_path" ||
                             std::string_view(name) == "compute_cartesian_path";
          LongWork::Work work = [this, answer, request, reply, look = shared_.look(arm_),
                                 settings = shared_.settings()]() -> LongWork::Then {
            const auto response = std::make_shared<Response>();
            std::string failure;
            try {
              *response = answer(look(), *request, settings);
            } catch (const std::exception& error) {
              failure = error.what();
            }
            return [this, response, reply, failure] {
              if (!failure.empty()) report(Code{Code::FAILURE, failure, "polyarm"});
              report(*response);
              (*reply)(encode(bridge_, *response));
            };
          };
          const bool posted =
              plans ? shared_.work.plan(std::move(work)) : shared_.work.query(std::move(work));
          if (!posted) (*reply)(encode(bridge_, Response{}));  // too many wait: the codes of the answer are 0
          return true;
        });
  }

  /// The sentence of a failure, for clients that have only the code.
  template <class Response>
  void report(const Response& response) {
    if constexpr (requires { response.error_code; }) report(response.error_code);
    if constexpr (requires { response.motion_plan_response; })
      report(response.motion_plan_response.error_code);
  }
  void report(const Code& code) {
    if (code.val == Code::SUCCESS || code.message.empty()) return;
    const Nanoseconds now = bridge_.cell().now();
    if (now - reported_at_ < kBetweenReports) return;  // a client may ask many times a second
    reported_at_ = now;
    shared_.tell(fmt::format("code {}: {}", code.val, code.message));
  }

  void offer_services() {
    using Around = move_group::Around;
    serve<srv::GetMotionPlan::Request, srv::GetMotionPlan::Response>(
        "plan_kinematic_path", "moveit_msgs/srv/GetMotionPlan",
        [](const Around& around, const auto& request, const auto& settings) {
          return srv::GetMotionPlan::Response{
              move_group::plan(around, request.motion_plan_request, settings)};
        });
    serve<srv::GetPositionIK::Request, srv::GetPositionIK::Response>(
        "compute_ik", "moveit_msgs/srv/GetPositionIK",
        [](const Around& around, const auto& request, const auto& settings) {
          return move_group::solve_ik(around, request.ik_request, settings);
        });
    serve<srv::GetPositionFK::Request, srv::GetPositionFK::Response>(
        "compute_fk", "moveit_msgs/srv/GetPositionFK",
        [](const Around& around, const auto& request, const auto&) {
          return move_group::solve_fk(around, request);
        });
    serve<srv::GetStateValidity::Request, srv::GetStateValidity::Response>(
        "check_state_validity", "moveit_msgs/srv/GetStateValidity",
        [](const Around& around, const auto& request, const auto&) {
          return move_group::validity(around, request);
        });
    serve<srv::GetCartesianPath::Request, srv::GetCartesianPath::Response>(
        "compute_cartesian_path", "moveit_msgs/srv/GetCartesianPath",
        [](const Around& around, const auto& request, const auto& settings) {
          return move_group::cartesian_path(around, request, settings);
        });
    serve<srv::GetPlanningScene::Request, srv::GetPlanningScene::Response>(
        "get_planning_scene", "moveit_msgs/srv/GetPlanningScene",
        [](const Around& around, const auto& request, const auto&) {
          return srv::GetPlanningScene::Response{
              move_group::to_message(around, request.components.components)};
        });
    serve<srv::ApplyPlanningScene::Request, srv::ApplyPlanningScene::Response>(
        "apply_planning_scene", "moveit_msgs/srv/ApplyPlanningScene",
        [this](const Around& around, const auto& request, const auto&) {
          return srv::ApplyPlanningScene::Response{
              apply(around, [&](auto& notes) { return move_group::applied(around, request.scene, notes); })};
        });
    offer_planners();
  }

  void offer_planners() {
    bridge_.service(
        node_, space_ + "/query_planner_interface", "moveit_msgs/srv/QueryPlannerInterfaces",
        [](const Json&, const Reply& reply) {
          reply({{"planner_interfaces", Json::array({{{"name", "Polyarm"},
                                                      {"pipeline_id", kPipeline},
                                                      {"planner_ids", Json::array({kPlanner})}}})}});
        });
    bridge_.service(node_, space_ + "/get_planner_params", "moveit_msgs/srv/GetPlannerParams",
                    [](const Json&, const Reply& reply) { reply(Json::object()); });
    bridge_.service(
        node_, space_ + "/set_planner_params", "moveit_msgs/srv/SetPlannerParams",
        [this](const Json& request, const Reply& reply) {
          if (!request["params"]["keys"].empty())
            shared_.tell("the planner has no parameters: those of set_planner_params have no effect");
          reply(Json::object());
        });
    bridge_.service(node_, space_ + "/clear_octomap", "std_srvs/srv/Empty",
                    [](const Json&, const Reply& reply) { reply(Json::object()); });
  }

  /// Changes the scene, on the thread of queries. Returns false, and reports why, if it stays as it was.
  bool apply(const move_group::Around& around,
             const std::function<move_group::SceneState(std::vector<std::string>& notes)>& change) {
    std::vector<std::string> notes;
    bool done = true;
    try {
      shared_.scene->set(change(notes));
    } catch (const std::exception& error) {
      notes = {std::string("the planning scene stays as it was: ") + error.what()};
      done = false;
    }
    const std::lock_guard lock(notes_mutex_);
    for (std::string& note : notes)
      if (notes_.size() < 20) notes_.push_back(std::move(note));
    changed_ = changed_ || done;
    return done;
  }

  /// Messages that change the scene without an answer.
  template <class Message>
  void listen(const char* topic,
              std::function<move_group::SceneState(const move_group::Around&, const Message&,
                                                   std::vector<std::string>&)>
                  change) {
    bridge_.wire().subscription(
        node_, space_ + "/" + topic, bridge_.type(messages::type_info<Message>().name), {true, false, 100},
        [this, topic, change = std::move(change)](std::span<const std::byte> payload) {
          const auto message = std::make_shared<Message>();
          if (!decode(bridge_, payload, *message)) return false;
          const bool posted =
              shared_.work.query([this, change, message, look = shared_.look(arm_)]() -> LongWork::Then {
                const move_group::Around around = look();
                apply(around, [&](auto& notes) { return change(around, *message, notes); });
                return [] {};
              });
          if (!posted) shared_.tell(fmt::format("a message on {} is dropped: too many wait", topic));
          return true;
        });
  }

  void listen() {
    using Notes = std::vector<std::string>;
    using Around = move_group::Around;
    listen<msg::PlanningScene>("planning_scene",
                               [](const Around& around, const msg::PlanningScene& message, Notes& notes) {
                                 return move_group::applied(around, message, notes);
                               });
    listen<msg::CollisionObject>("collision_object",
                                 [](const Around& around, const msg::CollisionObject& message, Notes&) {
                                   move_group::SceneState state = *around.scene;
                                   move_group::apply(around, message, state);
                                   ++state.version;
                                   return state;
                                 });
    listen<msg::AttachedCollisionObject>(
        "attached_collision_object",
        [](const Around& around, const msg::AttachedCollisionObject& message, Notes&) {
          move_group::SceneState state = *around.scene;
          move_group::apply(around, message, state);
          ++state.version;
          return state;
        });
  }

  void tell_state() {
    tell_notes();
    const Nanoseconds now = bridge_.cell().now();
    if (told_at_ >= 0 && now - told_at_ < kStates) return;
    told_at_ = now;
    if (!bridge_.wire().wanted(scene_topic_)) return;
    const std::vector<double> q = bridge_.cell().moment().robots[arm_->index()].joints;
    const bool moved =
        q.size() != told_.size() || !std::equal(q.begin(), q.end(), told_.begin(),
                                                [](double a, double b) { return std::abs(a - b) < kMoved; });
    if (!moved) return;
    told_ = q;
    msg::PlanningScene scene;
    scene.is_diff = true;
    scene.robot_model_name = arm_->model().name;
    scene.robot_state.is_diff = true;
    scene.robot_state.joint_state = arm_->joint_state(q);
    bridge_.wire().publish(scene_topic_, encode(bridge_, scene));
  }

  void tell_notes() {
    std::vector<std::string> notes;
    bool changed = false;
    {
      const std::lock_guard lock(notes_mutex_);
      notes.swap(notes_);
      changed = std::exchange(changed_, false);
    }
    for (const std::string& note : notes) shared_.tell(note);
    if (changed && on_change) on_change();
  }

  /// The SRDF takes a moment: which links can meet is found by samples.
  void make_semantic() {
    shared_.work.plan([this, look = shared_.look(arm_)]() -> LongWork::Then {
      const move_group::Around around = look();
      description::RobotModel model =
          *(*around.bodies.robots)[arm_->index()].model;  // with bodies of its meshes
      model.groups = arm_->model().groups;
      model.end_effectors = arm_->model().end_effectors;
      std::string text = description::write_srdf(model, description::needless_pairs(model, kPairSamples),
                                                 is_at_origin(around.base()));
      return [this, text = std::move(text)] {
        semantic_ = text;
        bridge_.wire().publish(semantic_topic_, messages::to_cdr(messages::std_msgs::msg::String{text}));
      };
    });
  }

  ParameterSource parameters() {
    ParameterSource out;
    out.list = [this](const std::function<void(Json)>& got) { got(parameter_list()); };
    out.set = [](const Json&, std::function<void(std::string)> done) {
      done("it is read when the cell is built");
    };
    return out;
  }

  Json parameter_list() const {
    Json all = Json::object();
    const auto add = [&](const std::string& key, const Json& value, const char* text) {
      all[key] = {{"value", value}, {"text", text}, {"read_only", true}};
    };
    add("robot_description", description::write_plain_urdf(robot_.model), "URDF");
    add("robot_description_semantic", semantic_, "SRDF; empty until it is made");
    add("use_sim_time", bridge_.cell().lock_step(), "true in lock-step");
    add("planning_pipelines", Json::array({kPipeline}), "the planners of the cell");
    add("default_planning_pipeline", kPipeline, "the planners of the cell");
    for (const move_group::Group& group : arm_->groups()) {
      const std::string of = "robot_description_kinematics." + group.name + ".";
      if (!group.solvable) continue;
      add(of + "kinematics_solver", "kdl_kinematics_plugin/KDLKinematicsPlugin",
          "for clients that solve by themselves");
      add(of + "kinematics_solver_search_resolution", 0.005, "for clients that solve by themselves");
      add(of + "kinematics_solver_timeout", 0.05, "for clients that solve by themselves, s");
    }
    const std::string planning = "robot_description_planning.";
    for (const char* factor : {"default_velocity_scaling_factor", "default_acceleration_scaling_factor"})
      add(planning + factor, 1.0, "of requests that state none");
    for (std::size_t i = 0; i < arm_->joints().size(); ++i) {
      const trajectory::JointMotionLimits& limits = robot_.facts->limits[i];
      const std::string of = planning + "joint_limits." + arm_->joints()[i] + ".";
      const auto limit = [&](const char* name, double value) {
        const bool has = std::isfinite(value) && value > 0;
        add(of + "has_" + name + "_limits", has, "as the cell moves");
        add(of + "max_" + name, has ? value : 0.0, "as the cell moves");
      };
      limit("velocity", limits.velocity);
      limit("acceleration", limits.acceleration);
      limit("jerk", limits.jerk);
    }
    return all;
  }

  MoveGroupCell& shared_;
  Bridge& bridge_;
  const cell::CellRobot& robot_;
  std::string space_, node_;
  const std::shared_ptr<const Arm> arm_;
  std::optional<MoveGroupMotion> motion_;
  Wire::Id scene_topic_ = 0, semantic_topic_ = 0;
  std::string semantic_;
  Nanoseconds reported_at_ = -kBetweenReports, told_at_ = -1;
  std::vector<double> told_;
  std::mutex notes_mutex_;
  std::vector<std::string> notes_;
  bool changed_ = false;
};

class MoveGroups : public Part {
 public:
  explicit MoveGroups(Bridge& bridge) : shared_{bridge} {
    for (std::size_t i = 0; i < bridge.cell().robots().size(); ++i) {
      // A node stays once it is made: its services and its work refer to it.
      std::shared_ptr<const Arm> arm = MoveGroupNode::make_arm(bridge, i);
      if (arm->groups().empty()) continue;
      auto node = std::make_unique<MoveGroupNode>(shared_, i, std::move(arm));
      node->on_change = [this] {
        for (const auto& each : nodes_) each->tell_scene();
      };
      nodes_.push_back(std::move(node));
    }
  }
  ~MoveGroups() override { shared_.closing->store(true); }

  void serve() override {
    shared_.work.finish();
    shared_.tell_guards();
    for (const auto& node : nodes_) node->serve();
  }

 private:
  std::vector<std::unique_ptr<MoveGroupNode>> nodes_;  // outlive the threads of `shared_`
  MoveGroupCell shared_;
};

}  // namespace

std::unique_ptr<Part> make_move_groups(Bridge& bridge) {
  return std::make_unique<MoveGroups>(bridge);
}

}  // namespace polyarm::ros2
