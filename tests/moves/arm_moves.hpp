#pragma once
/// Robots of the catalogue and moves of theirs, for tests.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/kinematics/singularity.hpp"
#include "polyarm/moves/move_plan.hpp"

namespace polyarm::moves::test {

using Values = std::vector<double>;

/// A robot of the catalogue with limits of its own making.
struct Arm {
  description::RobotModel model;
  std::unique_ptr<RobotFacts> facts;

  explicit Arm(const std::string& name)
      : model(description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name)) {
    kinematics::Chain chain(model, model.tool_link());
    std::vector<trajectory::JointMotionLimits> limits(chain.joints(), {3, 12, 120});
    auto solver = std::make_unique<const ik::InverseKinematics>(chain);
    const Values home(chain.joints(), 0.0);
    facts = std::make_unique<RobotFacts>(
        RobotFacts{"arm", &model, std::move(chain), std::move(limits), {}, home, std::move(solver), {}, {}});
  }
  const kinematics::Chain& chain() const { return facts->chain; }
};

inline Values bent(const Arm& arm) {
  Values q(arm.chain().joints(), 0.0);
  if (arm.model.name.find("ur") == 0) return {0.3, -1.4, 1.6, -1.8, -1.5, 0.2};
  std::mt19937_64 engine(7);
  for (;;) {
    for (std::size_t j = 0; j < q.size(); ++j) {
      const double low = std::max(arm.chain().lower()[j], -2.0), high = std::min(arm.chain().upper()[j], 2.0);
      q[j] =
          std::uniform_real_distribution<double>(low + 0.2 * (high - low), high - 0.2 * (high - low))(engine);
    }
    if (kinematics::smallest_singular_value(arm.chain(), q) > 0.1) return q;
  }
}

inline Move joint(const Values& q, const std::string& name, double blend = 0) {
  Move out;
  out.targets = {{q, name}};
  out.blend = blend;
  return out;
}
inline Move line(const Pose& to, const std::string& name, double blend = 0) {
  Move out;
  out.kind = MoveKind::line;
  out.targets = {{to, name}};
  out.blend = blend;
  return out;
}
inline Pose shifted(Pose pose, const Vec3& by) {
  pose.position = pose.position + by;
  return pose;
}

}  // namespace polyarm::moves::test
