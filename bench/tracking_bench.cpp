// How nearly the joints of an arm in physics follow what is commanded at full speed: random programs of joint
// moves, lines and arcs with blends, planned within the arm's velocities, accelerations (0.25 s to full
// velocity), jerks and torques, streamed to the MuJoCo driver as positions, cycle after cycle. Told are the
// largest and the root mean square distance of measured from commanded joints and TCPs, and the largest share
// of a joint's torque. The driver holds the joints by their exact masses (computed torque) and without
// friction of gears: a real arm follows less nearly.
//
// tracking_bench [ROBOT] [PROGRAMS] [SEED]: universal_robots/ur5e, 10, 1; without ROBOT three more arms.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "drivers/mujoco/component.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/moves/move_plan.hpp"

namespace polyarm {
namespace {

using moves::Move;
using moves::MoveKind;
using Values = std::vector<double>;

constexpr double kTimeToSpeed = 0.25, kTimeToAcceleration = 0.1;  // s; as a cell assumes where nobody says

struct Bench {
  description::RobotModel model;
  moves::RobotFacts facts;
};

Bench arm(const std::string& name) {
  description::RobotModel model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
  kinematics::Chain chain(model, model.tool_link());
  std::vector<trajectory::JointMotionLimits> limits;
  std::vector<double> effort;
  for (const int index : model.actuated) {
    const auto& own = model.joints[static_cast<std::size_t>(index)].limits;
    const double velocity = own.velocity.value_or(1.0);
    const double acceleration = own.acceleration.value_or(velocity / kTimeToSpeed);
    limits.push_back({velocity, acceleration, own.jerk.value_or(acceleration / kTimeToAcceleration)});
    effort.push_back(own.effort.value_or(0.0));
  }
  auto solver = std::make_unique<const kinematics::ArmSolver>(chain);
  auto torques = moves::torque_limits_of(model, {}, {}, effort);
  const Values home(chain.joints(), 0.0);
  Bench out{std::move(model),
            {name, nullptr, std::move(chain), std::move(limits), {}, home, std::move(solver), {}, torques}};
  return out;
}

class Physics {
 public:
  Physics(const Bench& bench, const Values& q, Nanoseconds period) {
    hardware::ComponentContext context;
    context.name = "physics";
    context.robots = {{"arm", &bench.model, nullptr, {}, q, {}}};
    context.scene = &scene_;
    context.period = period;
    scene_.floor = false;
    component_.on_init(context), component_.on_configure(), component_.on_activate();
    states_.resize(component_.state_interfaces().size());
    commands_.assign(component_.command_interfaces().size(), std::nan(""));
    const auto place = [](const auto& all, const std::string& name) {
      const auto at = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == name; });
      return static_cast<std::size_t>(at - all.begin());
    };
    for (const int index : bench.model.actuated) {
      const auto& joint = bench.model.joints[static_cast<std::size_t>(index)];
      position_.push_back(place(component_.state_interfaces(), "arm/" + joint.name + "/position"));
      effort_.push_back(place(component_.state_interfaces(), "arm/" + joint.name + "/effort"));
      command_.push_back(place(component_.command_interfaces(), "arm/" + joint.name + "/position"));
    }
    cycle_.period = period;
    component_.read(cycle_, states_);
  }
  /// One cycle: what was commanded at its beginning should be there at its end.
  void follow(const Values& q, Values& measured, Values& torque) {
    for (std::size_t j = 0; j < q.size(); ++j) commands_[command_[j]] = q[j];
    component_.write(cycle_, commands_);
    cycle_.time += cycle_.period;
    ++cycle_.index;
    component_.read(cycle_, states_);
    for (std::size_t j = 0; j < q.size(); ++j)
      measured[j] = states_[position_[j]], torque[j] = states_[effort_[j]];
  }
  bool touched() const { return component_.world()->finding_count > 0; }

 private:
  description::Scene scene_;
  drivers::MujocoComponent component_;
  std::vector<double> states_, commands_;
  std::vector<std::size_t> position_, effort_, command_;
  hardware::Cycle cycle_;
};

/// Six moves about a joint state, of every kind but splines, with and without blends, at full speed.
std::vector<Move> program(const Bench& bench, const Values& q, std::mt19937_64& engine) {
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  const auto near = [&](double by) {
    Values out = q;
    for (std::size_t j = 0; j < q.size(); ++j)
      out[j] = std::clamp(q[j] + draw(-by, by), bench.facts.chain.lower()[j] + 0.05,
                          bench.facts.chain.upper()[j] - 0.05);
    return out;
  };
  const auto pose = [&] { return moves::MoveTarget{bench.facts.chain.forward(near(0.35)), "a pose"}; };
  std::vector<Move> out;
  for (int i = 0; i < 6; ++i) {
    Move move;
    const double what = draw(0, 1);
    if (what < 0.5) {
      move.targets = {{near(1.2), "a joint state"}};
    } else if (what < 0.8) {
      move.kind = MoveKind::line;
      move.targets = {pose()};
    } else {
      move.kind = MoveKind::arc;
      move.targets = {pose(), pose()};
    }
    if (draw(0, 1) < 0.5) move.blend = draw(0.01, 0.08);
    move.tcp_speed = move.kind == MoveKind::joint ? 0 : 2;
    out.push_back(std::move(move));
  }
  return out;
}

struct Followed {
  double joint = 0, joint2 = 0, tcp = 0, tcp2 = 0, torque = 0, fastest = 0, seconds = 0;
  std::size_t joints = 0, cycles = 0, motions = 0, touching = 0;
};

/// Adds what one motion shows, but where the arm touched itself: nobody looks for that before it moves here.
void follow(const Bench& bench, const moves::PlannedMotion& motion, Nanoseconds period, Followed& all) {
  Followed out = all;
  const std::size_t n = bench.facts.limits.size();
  Values q(n), v(n), a(n), j(n), measured(n), torque(n);
  std::size_t hint = 0;
  motion.path.sample(0, q, v, a, j, hint);
  Physics physics(bench, q, period);
  const double dt = seconds(period);
  Vec3 before = bench.facts.chain.forward(q).position;
  for (double t = dt; t < motion.path.duration() + dt; t += dt) {
    motion.path.sample(std::min(t, motion.path.duration()), q, v, a, j, hint);
    physics.follow(q, measured, torque);
    const Vec3 wanted = bench.facts.chain.forward(q).position;
    const double off = norm(bench.facts.chain.forward(measured).position - wanted);
    out.fastest = std::max(out.fastest, norm(wanted - std::exchange(before, wanted)) / dt);
    out.tcp = std::max(out.tcp, off), out.tcp2 += off * off, ++out.cycles;
    for (std::size_t k = 0; k < n; ++k, ++out.joints) {
      const double e = std::abs(measured[k] - q[k]);
      out.joint = std::max(out.joint, e), out.joint2 += e * e;
      const auto& effort =
          bench.model.joints[static_cast<std::size_t>(bench.model.actuated[k])].limits.effort;
      if (effort && *effort > 0) out.torque = std::max(out.torque, std::abs(torque[k]) / *effort);
    }
  }
  out.seconds += motion.path.duration();
  ++out.motions;
  if (physics.touched())
    ++all.touching;
  else
    all = out;
}

void bench(const std::string& name, int programs, std::uint64_t seed) {
  Bench robot = arm(name);
  robot.facts.model = &robot.model;
  const bool ur = name.find("/ur") != std::string::npos;
  Values q(robot.facts.limits.size(), 0.0);
  const Values bent = ur ? Values{0.3, -1.4, 1.6, -1.8, -1.5, 0.2} : Values{0.3, 0.3, 0.2, 0.4, 0.9, 0.2};
  if (bent.size() == q.size()) q = bent;
  for (const Nanoseconds period : {1'000'000, 2'000'000, 8'000'000}) {
    std::mt19937_64 engine(seed);
    Followed out;
    int done = 0;
    for (int tries = 0; done < programs && tries < 50 * programs; ++tries) {
      moves::MovePlan plan;
      try {
        plan = plan_moves(robot.facts, q, program(robot, q, engine));
      } catch (const Error&) {  // leads where this arm does not go
        continue;
      }
      ++done;
      for (const moves::PlannedMotion& motion : plan.motions) follow(robot, motion, period, out);
    }
    fmt::print(
        "{:<28} {:4.0f} Hz: {} motions, {:.0f} s, TCP up to {:.2f} m/s, torque up to {:.0f} % ({} motions "
        "more touched the arm itself)\n",
        name, 1e9 / double(period), out.motions, out.seconds, out.fastest, 100 * out.torque, out.touching);
    fmt::print("  joints {:.1e} mrad at most, {:.1e} rms; TCP {:.1e} mm at most, {:.1e} rms\n",
               1e3 * out.joint, 1e3 * std::sqrt(out.joint2 / double(out.joints)), 1e3 * out.tcp,
               1e3 * std::sqrt(out.tcp2 / double(out.cycles)));
  }
}

}  // namespace
}  // namespace polyarm

int main(int argc, char** argv) {
  const int programs = argc > 2 ? std::atoi(argv[2]) : 10;
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
  if (argc > 1) {
    polyarm::bench(argv[1], programs, seed);
    return 0;
  }
  for (const char* name :
       {"universal_robots/ur5e", "universal_robots/ur3", "abb/irb_120", "fanuc/lr_mate_200id_7l"})
    polyarm::bench(name, programs, seed);
}
