#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "polyarm/catalogue/catalogue.hpp"
#include "python/robot.hpp"

namespace polyarm::python {

namespace {
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A homogeneous matrix of 4 x 4 numbers, row-major, from a pose and back.
void put_matrix(const Pose& pose, double* out) {
  const Vec3 columns[3] = {pose.rotation * Vec3{1, 0, 0}, pose.rotation * Vec3{0, 1, 0},
                           pose.rotation * Vec3{0, 0, 1}};
  const double rows[16] = {columns[0].x,
                           columns[1].x,
                           columns[2].x,
                           pose.position.x,
                           columns[0].y,
                           columns[1].y,
                           columns[2].y,
                           pose.position.y,
                           columns[0].z,
                           columns[1].z,
                           columns[2].z,
                           pose.position.z,
                           0,
                           0,
                           0,
                           1};
  std::copy(rows, rows + 16, out);
}

/// The quaternion of a rotation matrix: from its largest component (Shepperd 1978).
Quaternion rotation_of(const double* m) {
  const double xx = m[0], yy = m[5], zz = m[10];
  const double squares[4] = {1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz, 1 + xx + yy + zz};
  const auto largest = std::max_element(squares, squares + 4) - squares;
  const double s = 0.5 / std::sqrt(squares[largest]);
  const double yx = m[4] + m[1], zx = m[8] + m[2], zy = m[9] + m[6];
  const double zmy = m[9] - m[6], xmz = m[2] - m[8], ymx = m[4] - m[1];
  switch (largest) {
    case 0:
      return {s * squares[0], s * yx, s * zx, s * zmy};
    case 1:
      return {s * yx, s * squares[1], s * zy, s * xmz};
    case 2:
      return {s * zx, s * zy, s * squares[2], s * ymx};
    default:
      return {s * zmy, s * xmz, s * ymx, s * squares[3]};
  }
}

/// Throws Error("bad-pose") unless the matrix is a rotation and a translation. `index`: of the pose among
/// `count`.
Pose pose_of(const double* m, py::ssize_t index, py::ssize_t count) {
  constexpr double kTolerance = 1e-6;
  const auto refused = [&](const std::string& what, const std::string& advice) {
    const std::string whose = count == 1 ? "a pose" : "pose " + std::to_string(index);
    return Error("bad-pose", "the matrix of " + whose + " " + what, advice);
  };
  for (int i = 0; i < 16; ++i)
    if (!std::isfinite(m[i])) throw refused("contains NaN or infinity", "");
  bool rigid = std::abs(m[12]) + std::abs(m[13]) + std::abs(m[14]) + std::abs(m[15] - 1) < kTolerance;
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) {
      const double product = m[a] * m[b] + m[4 + a] * m[4 + b] + m[8 + a] * m[8 + b];
      rigid = rigid && std::abs(product - (a == b ? 1 : 0)) < kTolerance;
    }
  const Vec3 x{m[0], m[4], m[8]}, y{m[1], m[5], m[9]}, z{m[2], m[6], m[10]};
  if (!rigid || dot(cross(x, y), z) < 0)
    throw refused("is not a rotation with a translation",
                  "pass 4 x 4 numbers with orthonormal columns; polyarm.pose() makes them");
  return {{m[3], m[7], m[11]}, normalized(rotation_of(m))};
}

description::RobotModel load(const std::string& name, const std::string& tip,
                             const std::map<std::string, std::string>& arguments, Problems& warnings) {
  const description::Catalogue catalogue(description::default_catalogue_folders());
  description::RobotModel out = description::load_robot(name, catalogue, warnings, arguments);
  description::set_tip(out, tip);
  return out;
}
}  // namespace

Robot::Robot(const std::string& name, const std::string& tip,
             const std::map<std::string, std::string>& arguments)
    : model_(load(name, tip, arguments, warnings_)), solver_(model_, model_.tool_link()) {}

std::vector<double> Robot::limits(std::optional<double> description::JointLimits::*member) const {
  std::vector<double> out;
  for (const int j : model_.actuated)
    out.push_back((model_.joints[std::size_t(j)].limits.*member).value_or(kNaN));
  return out;
}

std::vector<std::string> Robot::warnings() const {
  std::vector<std::string> out;
  for (const Problem& problem : warnings_.list()) out.push_back(problem.text());
  return out;
}

Numbers Robot::forward(const Numbers& q) const {
  const std::size_t states = states_of(q);
  std::vector<Pose> poses(states);
  Numbers out({states, std::size_t{4}, std::size_t{4}});
  double* const to = out.mutable_data();
  const std::span<const double> from(q.data(), states * joints());
  {
    const py::gil_scoped_release others;
    chain().screws().forward_batch(from, kinematics::BatchLayout::state_after_state, poses);
    for (std::size_t i = 0; i < states; ++i) put_matrix(poses[i], to + 16 * i);
  }
  return out;
}

Numbers Robot::jacobian(const Numbers& q, const std::string& frame) const {
  const std::size_t states = states_of(q), n = joints();
  const auto kind = frame == "world"   ? kinematics::JacobianFrame::local_world_aligned
                    : frame == "body"  ? kinematics::JacobianFrame::body
                    : frame == "space" ? kinematics::JacobianFrame::space
                                       : throw Error("bad-value", "there is no frame '" + frame + "'",
                                                     "use world, body or space");
  Numbers out({states, std::size_t{6}, n});
  double* const to = out.mutable_data();
  const double* const from = q.data();
  const py::gil_scoped_release others;
  for (std::size_t i = 0; i < states; ++i)
    chain().screws().jacobian({from + i * n, n}, {to + i * 6 * n, 6 * n}, kind);
  return out;
}

py::tuple Robot::solve(const Numbers& poses, const Numbers& seeds) const {
  const std::vector<Pose> targets = targets_of(poses);
  const std::size_t n = joints(), count = targets.size(), given = states_of(seeds);
  if (given != 1 && given != count)
    wrong_shape("there are " + std::to_string(count) + " poses and " + std::to_string(given) + " seeds");
  std::vector<kinematics::IkSolution> found(count);
  std::vector<kinematics::IkOutcome> outcomes(count);
  const double* const seed = seeds.data();
  {
    const py::gil_scoped_release others;
    if (given == 1)
      solver_.solve_batch(targets, {seed, n}, found, outcomes);
    else
      for (std::size_t i = 0; i < count; ++i)
        outcomes[i] = solver_.solve(targets[i], {seed + i * n, n}, found[i]);
  }
  Numbers out({count, n});
  py::list names;
  for (std::size_t i = 0; i < count; ++i) {
    const bool solved = outcomes[i] == kinematics::IkOutcome::solved;
    for (std::size_t j = 0; j < n; ++j) out.mutable_at(i, j) = solved ? found[i].q[j] : kNaN;
    names.append(kinematics::name(outcomes[i]));
  }
  return py::make_tuple(out, names);
}

Numbers Robot::solve_all(const Numbers& pose, const Numbers& seed) const {
  const Pose target = only_target(pose);
  const auto from = only_state(seed);
  const auto found = std::make_unique<kinematics::IkSolutions>();
  {
    const py::gil_scoped_release others;
    solver_.solve_all(target, from, *found);
  }
  const std::size_t n = joints();
  Numbers out({found->count, n});
  for (std::size_t i = 0; i < found->count; ++i)
    for (std::size_t j = 0; j < n; ++j) out.mutable_at(i, j) = (*found)[i].q[j];
  return out;
}

py::tuple Robot::explain(const Numbers& pose, const Numbers& seed) const {
  const auto why = solver_.explain(only_target(pose), only_state(seed));
  return py::make_tuple(kinematics::name(why.outcome), why.reason);
}

std::size_t Robot::states_of(const Numbers& q) const {
  if (q.ndim() != 2 || std::size_t(q.shape(1)) != joints())
    wrong_shape("a joint state of this robot has " + std::to_string(joints()) + " values");
  return std::size_t(q.shape(0));
}

std::span<const double> Robot::only_state(const Numbers& q) const {
  if (states_of(q) != 1) wrong_shape("one joint state is needed");
  return {q.data(), joints()};
}

std::vector<Pose> Robot::targets_of(const Numbers& poses) {
  if (poses.ndim() != 3 || poses.shape(1) != 4 || poses.shape(2) != 4)
    wrong_shape("a pose has 4 x 4 numbers");
  std::vector<Pose> out;
  const py::ssize_t count = poses.shape(0);
  out.reserve(std::size_t(count));
  for (py::ssize_t i = 0; i < count; ++i) out.push_back(pose_of(poses.data(i), i, count));
  return out;
}

Pose Robot::only_target(const Numbers& pose) {
  const std::vector<Pose> all = targets_of(pose);
  if (all.size() != 1) wrong_shape("one pose is needed");
  return all.front();
}

namespace {
py::list catalogue_rows() {
  py::list out;
  const description::Catalogue catalogue(description::default_catalogue_folders());
  for (const description::CatalogueEntry& entry : catalogue.entries()) {
    py::dict row;
    row["name"] = entry.name;
    row["maker"] = entry.maker;
    row["model"] = entry.model;
    row["axes"] = entry.axes;
    row["reach_m"] = entry.reach_m ? py::cast(*entry.reach_m) : py::none();
    row["payload_kg"] = entry.payload_kg ? py::cast(*entry.payload_kg) : py::none();
    row["mass_kg"] = entry.mass_kg ? py::cast(*entry.mass_kg) : py::none();
    out.append(row);
  }
  return out;
}
}  // namespace

void add_robots(py::module_& module) {
  using Limits = description::JointLimits;
  module.def("catalogue", &catalogue_rows);
  py::class_<Robot, std::shared_ptr<Robot>>(module, "Robot")
      .def(py::init<const std::string&, const std::string&, const std::map<std::string, std::string>&>())
      .def_property_readonly("name", [](const Robot& robot) { return robot.model().name; })
      .def_property_readonly("joint_names", [](const Robot& robot) { return robot.chain().names(); })
      .def_property_readonly("lower", [](const Robot& robot) { return robot.chain().lower(); })
      .def_property_readonly("upper", [](const Robot& robot) { return robot.chain().upper(); })
      .def_property_readonly("velocity", [](const Robot& robot) { return robot.limits(&Limits::velocity); })
      .def_property_readonly("acceleration",
                             [](const Robot& robot) { return robot.limits(&Limits::acceleration); })
      .def_property_readonly("jerk", [](const Robot& robot) { return robot.limits(&Limits::jerk); })
      .def_property_readonly("effort", [](const Robot& robot) { return robot.limits(&Limits::effort); })
      .def_property_readonly("start", [](const Robot& robot) { return robot.model().start(); })
      .def_property_readonly("named_states", [](const Robot& robot) { return robot.model().named_states; })
      .def_property_readonly("reach", [](const Robot& robot) { return robot.chain().reach(); })
      .def_property_readonly("ik_report", [](const Robot& robot) { return robot.solver().report(); })
      .def_property_readonly("ik_complete", [](const Robot& robot) { return robot.solver().complete(); })
      .def_property_readonly("warnings", &Robot::warnings)
      .def("forward", &Robot::forward)
      .def("jacobian", &Robot::jacobian)
      .def("solve", &Robot::solve)
      .def("solve_all", &Robot::solve_all)
      .def("explain", &Robot::explain);
}

}  // namespace polyarm::python
