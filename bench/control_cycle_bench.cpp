// What one control cycle costs: read, judge, a joint trajectory controller that follows a running trajectory
// of position and velocity, a joint state broadcaster, limits (limits:1), write, and the snapshot with its
// ring of cycle records (publish:1), against the mock. Back to back on a warm cache: it cannot show what
// wake-up, cold caches or a real bus cost. A name reads cycle/joints:6/limits:0/publish:1. Each iteration is
// one cycle; the counters p50_ns, p99_ns and max_ns are of 20,000 further cycles timed one by one, with the
// cost of reading the clock in them (about 25 ns).
#include <benchmark/benchmark.h>

#include "drivers/mock/mock.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/controllers/joint_state_broadcaster.hpp"
#include "polyarm/controllers/joint_trajectory_controller.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/trajectory/joint_move.hpp"

namespace {

using namespace polyarm;

description::RobotModel chain_of(int joints) {
  description::RobotModel model;
  model.name = "chain";
  model.links.push_back({"base"});
  for (int i = 0; i < joints; ++i) {
    description::Joint joint;
    joint.name = "joint_" + std::to_string(i + 1);
    joint.type = description::JointType::revolute;
    joint.parent_link = i;
    joint.child_link = i + 1;
    joint.axis = {0, 0, 1};
    joint.limits = {-3.0, 3.0, 2.0, 100.0, 8.0, 80.0};
    model.joints.push_back(joint);
    model.actuated.push_back(i);
    model.links.push_back({"link_" + std::to_string(i + 1), {}, {}, {}, i});
  }
  return model;
}

void cycle(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const description::RobotModel model = chain_of(n);
  control::LoopOptions options;
  options.limits = state.range(1) != 0;
  options.publish = state.range(2) != 0;
  options.measure = false;
  options.black_box_rows = 1000;
  control::ControlLoop loop(options);
  loop.supervisor().watch_cell = false;

  hardware::ComponentContext hardware;
  hardware.name = "mock";
  hardware.robots.push_back(
      {"arm", &model, nullptr, {}, std::vector<double>(static_cast<std::size_t>(n), 0.0), {}});
  loop.hardware().add(std::make_unique<drivers::MockComponent>(), hardware);
  loop.start_hardware();

  controllers::ControllerContext context;
  context.robot = "arm";
  std::vector<trajectory::JointMotionLimits> limits;
  for (const std::string& joint : model.joint_names()) {
    context.joints.push_back({"arm/" + joint, false, -3, 3, 2, 8, 80});
    context.parameters.entries["joints"].values.push_back(joint);
    limits.push_back({2, 8, 80});
  }
  context.name = "joint_trajectory_controller";
  auto made = std::make_unique<controllers::JointTrajectoryController>();
  controllers::JointTrajectoryController* jtc = made.get();
  loop.controllers().add(std::move(made), context);
  context.name = "joint_state_broadcaster";
  loop.controllers().add(std::make_unique<controllers::JointStateBroadcaster>(),
                         context);
  loop.controllers().activate("joint_trajectory_controller");
  loop.controllers().activate("joint_state_broadcaster");
  loop.prepare(context.joints);

  std::vector<double> at(static_cast<std::size_t>(n), 0.0);
  std::uint64_t goals = 0;
  realtime::Histogram costs;
  const auto keep_moving = [&] {
    if (jtc->status().finished.load() != goals) return;
    const std::vector<double> to(at.size(), at[0] > 0 ? -2.0 : 2.0);
    trajectory::JointMoveOptions slow;
    slow.duration = 20;
    auto goal = std::make_unique<controllers::TrajectoryGoal>();
    goal->id = ++goals;
    goal->trajectory = trajectory::plan_joint_move(at, to, limits, slow);
    jtc->follow(goal);
    at = to;
  };
  std::uint32_t count = 0;
  const auto one = [&] {
    if ((count++ & 1023) == 0) keep_moving();
    loop.step_next();
  };
  for (auto _ : state) one();
  for (int k = 0; k < 20'000; ++k) {  // the same again, each cycle by itself
    const Nanoseconds before = realtime::monotonic_now();
    one();
    costs.add(realtime::monotonic_now() - before);
  }
  state.counters["p50_ns"] = static_cast<double>(costs.percentile(0.5));
  state.counters["p99_ns"] = static_cast<double>(costs.percentile(0.99));
  state.counters["max_ns"] = static_cast<double>(costs.max());
}

BENCHMARK(cycle)
    ->ArgNames({"joints", "limits", "publish"})
    ->ArgsProduct({{6, 12, 60, 600}, {0, 1}, {1}})
    ->Unit(benchmark::kNanosecond);

}  // namespace
