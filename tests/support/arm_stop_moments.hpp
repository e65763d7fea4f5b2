#pragma once
/// Random stop requests on random TCP paths of arms.
#include <cstdint>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/paths/cartesian_path.hpp"
#include "tests/support/stop_moments.hpp"

namespace polyarm::test {

/// The chain to tool0, else to the last link.
inline kinematics::Chain chain_of(const std::string& name) {
  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (model.links[i].name == "tool0") return kinematics::Chain(model, static_cast<int>(i));
  return kinematics::Chain(model, static_cast<int>(model.links.size()) - 1);
}

/// Random lines, arcs and splines of the TCP around a pose, with blends. Each joint has other limits.
inline StopMoment moment_of_an_arm(std::uint64_t seed) {
  struct Robot {
    const char* name;
    std::vector<double> q;
  };
  static const Robot kRobots[] = {{"universal_robots/ur5e", {0, -1.4, 1.8, -2.0, -1.57, 0.3}},
                                  {"abb/irb_120", {0.2, 0.2, -0.1, 0.4, 0.8, 0.3}},
                                  {"fanuc/lr_mate_200id_7l", {0.1, 0.3, -0.2, 0.3, -0.9, 0.2}},
                                  {"kuka/lbr_iiwa_7_r800", {0.2, 0.5, -0.1, -1.4, 0.2, 0.9, 0}},
                                  {"franka/fer_panda", {0, -0.4, 0, -2.0, 0, 1.7, 0.8}}};
  const Robot& robot = kRobots[seed % std::size(kRobots)];
  const kinematics::Chain chain = chain_of(robot.name);
  std::mt19937_64 engine(seed);
  const auto near = [&] {
    std::vector<double> q = robot.q;
    for (double& x : q) x += std::uniform_real_distribution<double>(-0.25, 0.25)(engine);
    return chain.forward(q);
  };
  for (;;) {
    paths::CartesianPathBuilder builder(chain.forward(robot.q));
    for (int i = 0; i < 4; ++i) {
      const paths::Corner corner{std::uniform_real_distribution<double>(0.005, 0.05)(engine), ""};
      if (i % 3 == 0)
        builder.line(near(), corner);
      else if (i % 3 == 1)
        builder.arc(near().position, near(), paths::ArcOrientation::interpolated, corner);
      else
        builder.spline(std::vector<Pose>{near(), near()}, corner);
    }
    try {
      std::shared_ptr<const paths::Path> path =
          moves::joints_along(chain, builder.build().sections[0], robot.q);
      return moment_on(path, unequal_limits(engine, robot.q.size()), engine, seed % 4 < 2);
    } catch (const Error&) {  // the arm cannot follow this path: draw another one
    }
  }
}

}  // namespace polyarm::test
