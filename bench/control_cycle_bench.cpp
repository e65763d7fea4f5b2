// What one control cycle costs: read, judge, a joint trajectory controller that follows a message of 100
// points of position and velocity (cubic splines, 20 s), a joint state broadcaster, limits (limits:1), write,
// and the snapshot with its ring of cycle records (publish:1), against the mock; and so many arms with a
// controller each. Back to back on a warm cache: it cannot show what wake-up, cold caches or a real bus cost.
// A name reads cycle/joints:6/limits:0/publish:1. Each iteration is one cycle; the counters p50_ns, p99_ns
// and max_ns are of 20,000 further cycles timed one by one, with the cost of reading the clock in them (about
// 25 ns).
//
// Compare CPU times, not wall times, and say what else ran: the program prints processor and load. Two
// programs are compared in turns (--benchmark_enable_random_interleaving=true --benchmark_repetitions=9 does
// so for the cases of one); the medians are the result.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "drivers/mock/mock.hpp"
#include "polyarm/broadcasters/joint_state_broadcaster.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/joint_control/joint_trajectory_controller.hpp"
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

/// A loop with `arms` robots of `joints` joints on the mock, a joint trajectory controller for each of them,
/// and one joint state broadcaster.
struct Bench {
  description::RobotModel model;
  control::ControlLoop loop;
  std::vector<controllers::JointTrajectoryController*> followers;
  static constexpr double kAmplitude = 2;  // rad
  std::uint64_t goal = 0;                  // of the first, 0: none yet
  double at = kAmplitude;                  // where all joints are, or go

  static control::LoopOptions options(bool limited, bool published) {
    control::LoopOptions out;
    out.limits = limited;
    out.publish = published;
    out.measure = false;
    out.black_box_rows = 1000;
    return out;
  }

  Bench(int arms, int joints, bool limited, bool published)
      : model(chain_of(joints)), loop(options(limited, published)) {
    loop.supervisor().watch_cell = false;
    hardware::ComponentContext hardware;
    hardware.name = "mock";
    controllers::ControllerContext context;
    for (int i = 0; i < arms; ++i) {
      const std::string name = arm(i);
      hardware.robots.push_back(
          {name, &model, nullptr, {}, std::vector<double>(static_cast<std::size_t>(joints), at), {}});
      for (const std::string& joint : model.joint_names())
        context.joints.push_back({name + "/" + joint, false, -3, 3, 2, 8, 80});
    }
    loop.hardware().add(std::make_unique<drivers::MockComponent>(), hardware);
    loop.start_hardware();
    control::SwitchRequest request;
    for (int i = 0; i < arms; ++i) {
      context.robot = arm(i);
      context.name = arm(i) + "_controller";
      context.parameters = {};
      std::vector<std::string> names;
      for (const std::string& joint : model.joint_names()) names.push_back(arm(i) + "/" + joint);
      context.parameters.set("joints", names);
      auto made = std::make_unique<controllers::JointTrajectoryController>();
      followers.push_back(made.get());
      loop.controllers().add(std::move(made), context);
      request.activate.push_back(context.name);
    }
    context.name = "joint_state_broadcaster";
    context.parameters = {};
    loop.controllers().add(std::make_unique<controllers::JointStateBroadcaster>(), context);
    request.activate.push_back(context.name);
    loop.controllers().switch_now(request);
    loop.prepare(context.joints);
  }
  static std::string arm(int i) { return "arm" + std::to_string(i); }

  /// From where all joints are to the other side in 20 s: a cosine in 100 points.
  controllers::TrajectoryMessage message_of(const std::vector<std::string>& joints, double from) const {
    constexpr int kPoints = 100;
    constexpr double kDuration = 20;
    controllers::TrajectoryMessage out;
    out.joints = joints;
    for (int i = 1; i <= kPoints; ++i) {
      const double phase = std::numbers::pi * i / kPoints;
      trajectory::TrajectoryPoint point;
      point.positions.assign(joints.size(), from * std::cos(phase));
      point.velocities.assign(joints.size(),
                              i == kPoints ? 0.0 : -from * std::sin(phase) * std::numbers::pi / kDuration);
      point.time_from_start = kDuration * i / kPoints;
      out.points.push_back(point);
    }
    return out;
  }

  /// A new trajectory for everybody when the last one is over.
  void keep_moving() {
    const std::uint64_t last = followers.front()->status().finished.load();
    if (goal != 0 && last != goal) return;
    at = at > 0 ? -kAmplitude : kAmplitude;
    for (controllers::JointTrajectoryController* follower : followers) {
      const std::uint64_t id =
          follower->receive("joint_trajectory", message_of(follower->joints(), -at), false);
      if (follower == followers.front()) goal = id;
    }
  }
  void one() {
    if ((count_++ & 1023) == 0) keep_moving();
    loop.step_next();
  }

 private:
  std::uint32_t count_ = 0;
};

void measure(benchmark::State& state, Bench& bench) {
  for (auto _ : state) bench.one();
  realtime::Histogram costs;
  for (int k = 0; k < 20'000; ++k) {  // the same again, each cycle by itself
    const Nanoseconds before = realtime::monotonic_now();
    bench.one();
    costs.add(realtime::monotonic_now() - before);
  }
  state.counters["p50_ns"] = static_cast<double>(costs.percentile(0.5));
  state.counters["p99_ns"] = static_cast<double>(costs.percentile(0.99));
  state.counters["max_ns"] = static_cast<double>(costs.max());
}

void cycle(benchmark::State& state) {
  Bench bench(1, static_cast<int>(state.range(0)), state.range(1) != 0, state.range(2) != 0);
  measure(state, bench);
}

/// So many arms of six joints, each with a controller of its own.
void arms(benchmark::State& state) {
  Bench bench(static_cast<int>(state.range(0)), 6, true, true);
  measure(state, bench);
}

/// The same cycle woken 1,000 times a second, its caches cold: only step() is timed.
void paced(benchmark::State& state) {
  Bench bench(1, static_cast<int>(state.range(0)), true, true);
  realtime::Histogram costs;
  realtime::Periodic clock(1'000'000);
  for (auto _ : state) {
    clock.start();
    for (int k = 0; k < 2000; ++k) {
      clock.wait();
      const Nanoseconds before = realtime::monotonic_now();
      bench.one();
      costs.add(realtime::monotonic_now() - before);
    }
  }
  state.counters["p50_ns"] = static_cast<double>(costs.percentile(0.5));
  state.counters["p99_ns"] = static_cast<double>(costs.percentile(0.99));
  state.counters["max_ns"] = static_cast<double>(costs.max());
}

/// From a trajectory message that is received to the first command that follows it, in cycles (1: the next
/// one), and what receiving it costs the cell thread.
void posted(benchmark::State& state) {
  Bench bench(1, 6, true, true);
  const controllers::TrajectoryMessage message =
      bench.message_of(bench.followers.front()->joints(), bench.at);
  std::uint64_t cycles = 0, sent = 0;
  for (auto _ : state) {
    const std::uint64_t id = bench.followers.front()->receive("joint_trajectory", message, false);
    ++sent;
    do {
      bench.loop.step_next();
      ++cycles;
    } while (bench.followers.front()->status().active.load() != id);
  }
  state.counters["cycles_to_first_command"] = static_cast<double>(cycles) / static_cast<double>(sent);
}

/// Cycles from a reason to stop until no joint is measured to move, in the middle of a move at full speed
/// (2 rad/s, 8 rad/s², 80 rad/s³). 0: asked, 1: asked twice, 2: wall time went missing, 3: the cell fell
/// silent (half a second of it is the patience). A component that fails stands as its driver says.
void stop(benchmark::State& state) {
  for (auto _ : state) {
    Bench bench(1, 6, true, true);
    bench.loop.supervisor().watch_cell = state.range(0) == 3;
    auto goal = std::make_unique<controllers::TrajectoryGoal>();
    goal->id = bench.followers.front()->new_goal_id();
    const std::vector<trajectory::JointMotionLimits> limits(6, {2, 8, 80});
    goal->trajectory = trajectory::plan_joint_move(std::vector<double>(6, bench.at),
                                                   std::vector<double>(6, -0.5), limits, {});
    bench.followers.front()->follow(goal);
    const auto heart = [&] { bench.loop.supervisor().heartbeat(bench.loop.cycle().time); };
    for (int k = 0; k < 700; ++k) heart(), bench.loop.step_next();
    realtime::StopLatch& latch = bench.loop.supervisor().latch();
    if (state.range(0) == 0) latch.request(realtime::StopKind::controlled);
    if (state.range(0) == 1) latch.request(realtime::StopKind::immediate);
    int cycles = 0;
    for (double last = 1e9; cycles < 5000; ++cycles) {
      bench.loop.step_next(state.range(0) == 2 && cycles == 0);
      const double now = bench.loop.table().states()[2];
      if (now == last && bench.loop.supervisor().state() != control::RunState::running) break;
      last = now;
    }
    state.counters["cycles"] = cycles;
  }
}

BENCHMARK(cycle)
    ->ArgNames({"joints", "limits", "publish"})
    ->ArgsProduct({{6, 12, 60, 600}, {0, 1}, {1}})
    ->Args({6, 0, 0})
    ->Unit(benchmark::kNanosecond);
BENCHMARK(arms)->ArgName("")->Arg(1)->Arg(10)->Arg(100)->Unit(benchmark::kMicrosecond);
BENCHMARK(paced)->ArgName("joints")->Arg(6)->Arg(600)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(stop)->ArgName("cause")->DenseRange(0, 3)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(posted)->Unit(benchmark::kMicrosecond);

}  // namespace
