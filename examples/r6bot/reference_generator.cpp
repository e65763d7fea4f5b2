// The reference generator of ros2_control's example 7: a closed curve of the tool becomes a joint trajectory,
// by integrating joint velocities that give the tool the velocity of the curve. (The example calls it a
// circle; its velocities describe an ellipse.) Prints a trajectory_msgs/JointTrajectory as YAML:
//
//   r6bot_reference examples/r6bot/r6bot.urdf | polyarm send r6bot_controller -
#include <fmt/format.h>

#include <Eigen/SVD>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace {

using namespace polyarm;

constexpr double kDuration = 3;  // s
constexpr int kPoints = 200;

/// Joint velocities of the least norm that give the tool the velocity `twist` (linear, angular; base axes).
Eigen::VectorXd joint_velocities(const kinematics::Chain& chain, const std::vector<double>& q,
                                 const Eigen::Vector<double, 6>& twist) {
  const auto n = static_cast<Eigen::Index>(q.size());
  std::vector<double> rows(6 * q.size());
  chain.jacobian(q, rows);
  const Eigen::Map<const Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>> J(rows.data(), 6, n);
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(1e-7);
  return svd.solve(twist);
}

void print_list(const char* name, const std::vector<double>& values) {
  std::string line;
  for (const double value : values) line += (line.empty() ? "" : ", ") + fmt::format("{:.9g}", value + 0.0);
  fmt::print("  {} {}: [{}]\n", name[0] == 'p' ? "-" : " ", name, line);
}

void generate(const std::string& file) {
  Problems warnings;
  const description::RobotModel model = description::read_urdf(read_file(file), file, warnings);
  const kinematics::Chain chain(model, model.tool_link());
  fmt::print("joint_names: [{}]\npoints:\n", join(model.joint_names(), ", "));
  std::vector<double> q(model.actuated.size(), 0.0);
  const double dt = kDuration / (kPoints - 1);
  for (int i = 0; i < kPoints; ++i) {
    const double t = i / static_cast<double>(kPoints - 1), turn = 2 * std::numbers::pi * t;
    Eigen::Vector<double, 6> twist = Eigen::Vector<double, 6>::Zero();
    twist[0] = 2 * 0.3 * std::cos(turn);
    twist[1] = -0.3 * std::sin(turn);
    const Eigen::VectorXd dq = joint_velocities(chain, q, twist);
    const bool last = i + 1 == kPoints;
    std::vector<double> velocities(q.size(), 0.0);
    for (std::size_t j = 0; j < q.size(); ++j) velocities[j] = last ? 0 : dq[static_cast<Eigen::Index>(j)];
    print_list("positions", q);
    print_list("velocities", velocities);
    fmt::print("    time_from_start: {:.9g}\n", dt * i);
    for (std::size_t j = 0; j < q.size(); ++j) q[j] += velocities[j] * dt;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: r6bot_reference ROBOT.urdf\n");
    return 2;
  }
  try {
    generate(argv[1]);
  } catch (const polyarm::Error& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
  return 0;
}
