/// A robot among the obstacles of a scene, for Python: contacts, distances, ways around.
#include <pybind11/stl.h>

#include <memory>

#include "polyarm/description/scene_file.hpp"
#include "polyarm/planning/planner.hpp"
#include "polyarm/planning/pose_goals.hpp"
#include "polyarm/surroundings/bodies.hpp"
#include "python/robot.hpp"

namespace polyarm::python {

namespace {
const char* code_of(planning::PlanOutcome outcome) {
  switch (outcome) {
    case planning::PlanOutcome::start_touches:
      return "start-in-contact";
    case planning::PlanOutcome::goal_touches:
      return "goal-in-contact";
    case planning::PlanOutcome::bad_query:
      return "bad-value";
    default:
      return "no-way";
  }
}

/// One thread at a time: a probe has working memory.
class Surroundings {
 public:
  Surroundings(std::shared_ptr<const Robot> robot, const std::string& scene, double clearance)
      : robot_(std::move(robot)), model_(robot_->model()) {
    if (!scene.empty()) scene_ = description::read_scene(scene, warnings_);
    description::Tool no_tool;
    surroundings::make_meshes(model_, no_tool, model_.name, warnings_);
    surroundings::make_meshes(scene_, warnings_);
    surroundings::Robot own;
    own.model = &model_;
    surroundings::Moment moment = surroundings::start_of(scene_);
    moment.robots.push_back({Pose{}, std::vector<double>(robot_->joints(), 0.0)});
    around_ = std::make_unique<surroundings::Surroundings>(std::vector{own}, scene_, moment, 0, clearance);
    for (const std::string& name : surroundings::without_body(own, scene_))
      warnings_.warning("no-body", {}, name + " has no known body: contacts with it are not found");
    for (const std::string& pair : around_->checker().robot().always_touching())
      warnings_.warning("always-in-contact", {},
                        "the links " + pair + " always touch: this pair is not checked");
    probe_ = &around_->probe();
  }

  std::vector<std::string> warnings() const {
    std::vector<std::string> out;
    for (const Problem& problem : warnings_.list()) out.push_back(problem.text());
    return out;
  }
  py::array_t<bool> touches(const Numbers& q) {
    const std::size_t states = robot_->states_of(q), n = robot_->joints();
    py::array_t<bool> out(static_cast<py::ssize_t>(states));
    for (std::size_t i = 0; i < states; ++i)
      out.mutable_at(i) = probe_->touches_exactly({q.data() + i * n, n});
    return out;
  }
  py::tuple nearest(const Numbers& q) {
    const collision::Contact contact = probe_->nearest(robot_->only_state(q));
    return py::make_tuple(contact.first, contact.second, contact.distance);
  }
  std::vector<std::vector<double>> goals_for(const Numbers& pose, const Numbers& seed) const {
    return planning::goals_for(robot_->solver(), Robot::only_target(pose), robot_->only_state(seed));
  }
  /// The waypoints, and for each the radius with which its corner may be rounded.
  py::tuple plan(const Numbers& start, const Numbers& goals, std::uint64_t seed, std::size_t most_samples) {
    const auto from = robot_->only_state(start);
    const std::size_t count = robot_->states_of(goals), n = robot_->joints();
    planning::PlanQuery query{
        {from.begin(), from.end()}, {}, robot_->chain().lower(), robot_->chain().upper()};
    for (std::size_t i = 0; i < count; ++i)
      query.goals.emplace_back(goals.data() + i * n, goals.data() + (i + 1) * n);
    planning::PlanOptions options;
    options.seed = seed;
    options.most_samples = most_samples;
    const planning::Plan plan = planning::plan(*probe_, query, options);
    if (plan.outcome != planning::PlanOutcome::found)
      throw Error(code_of(plan.outcome), plan.reason,
                  "choose another goal or seed, more samples, or correct the scene");
    return py::make_tuple(plan.waypoints, planning::corner_radii(*probe_, plan.waypoints, plan.exact));
  }

 private:
  std::shared_ptr<const Robot> robot_;
  Problems warnings_;
  description::RobotModel model_;
  description::Scene scene_;
  std::unique_ptr<surroundings::Surroundings> around_;
  collision::Probe* probe_ = nullptr;
};
}  // namespace

void add_surroundings(py::module_& module) {
  py::class_<Surroundings>(module, "Surroundings")
      .def(py::init([](std::shared_ptr<Robot> robot, const std::string& scene, double clearance) {
        return std::make_unique<Surroundings>(std::move(robot), scene, clearance);
      }))
      .def_property_readonly("warnings", &Surroundings::warnings)
      .def("touches", &Surroundings::touches)
      .def("nearest", &Surroundings::nearest)
      .def("goals_for", &Surroundings::goals_for)
      .def("plan", &Surroundings::plan);
}

}  // namespace polyarm::python
