// What forward kinematics, the Jacobian and inverse kinematics cost for a UR3 and a seven-joint arm, on one
// thread with the default options. Inverse: 10,000 random reachable poses (joint states uniform within
// limits, one turn), a random seed each (`inverse`) or the solution disturbed by up to 0.02 rad
// (`inverse_near`). Each iteration is one solve; the counters p50_us, p99_us, max_us are of every pose once,
// timed one by one, and solved_percent of the same. It cannot show what a caller's cold caches cost, nor
// poses that no joint state reaches: those cost milliseconds, spent on finding out why.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "polyarm/kinematics/inverse.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/kinematics/sample_robots.hpp"

namespace {

using namespace polyarm;
using namespace polyarm::kinematics;
constexpr std::size_t kPoses = 10000;

struct Question {
  std::vector<double> q, seed;
  Pose target;
};

Chain chain_of(const benchmark::State& state) {
  const auto model = state.range(0) == 7 ? test::seven() : test::ur3();
  return Chain(model, test::tip_of(model));
}

std::vector<Question> questions(const Chain& chain, bool near) {
  Random random(11);
  std::vector<Question> out(kPoses);
  for (Question& question : out) {
    for (std::size_t i = 0; i < chain.joints(); ++i) {
      question.q.push_back(random_value(chain, i, random));
      question.seed.push_back(near ? question.q[i] + random.between(-0.02, 0.02)
                                   : random_value(chain, i, random));
    }
    question.target = chain.forward(question.q);
  }
  return out;
}

void forward(benchmark::State& state) {
  const Chain chain = chain_of(state);
  const auto all = questions(chain, false);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(chain.forward(all[++i % kPoses].q));
}

void jacobian(benchmark::State& state) {
  const Chain chain = chain_of(state);
  const auto all = questions(chain, false);
  std::vector<double> J(6 * chain.joints());
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(chain.jacobian(all[++i % kPoses].q, J));
}

void report(benchmark::State& state, const Chain& chain, const std::vector<Question>& all) {
  std::vector<double> us;
  std::size_t solved = 0;
  for (const Question& question : all) {
    const auto begin = std::chrono::steady_clock::now();
    const IkResult result = solve_inverse(chain, question.target, question.seed);
    us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    const Pose reached = chain.forward(result.q);
    solved += result && norm(reached.position - question.target.position) < 1e-6 &&
              angle_between(reached.rotation, question.target.rotation) < 1e-6;
  }
  std::sort(us.begin(), us.end());
  state.counters["p50_us"] = us[us.size() / 2];
  state.counters["p99_us"] = us[us.size() * 99 / 100];
  state.counters["max_us"] = us.back();
  state.counters["solved_percent"] = 100.0 * static_cast<double>(solved) / static_cast<double>(us.size());
}

void inverse_from(benchmark::State& state, bool near) {
  const Chain chain = chain_of(state);
  const auto all = questions(chain, near);
  std::size_t i = 0;
  for (auto _ : state) {
    const Question& question = all[++i % kPoses];
    benchmark::DoNotOptimize(solve_inverse(chain, question.target, question.seed).q.data());
  }
  report(state, chain, all);
}

void inverse(benchmark::State& state) {
  inverse_from(state, false);
}
void inverse_near(benchmark::State& state) {
  inverse_from(state, true);
}

BENCHMARK(forward)->ArgName("joints")->Arg(6)->Arg(7);
BENCHMARK(jacobian)->ArgName("joints")->Arg(6)->Arg(7);
BENCHMARK(inverse)->ArgName("joints")->Arg(6)->Arg(7);
BENCHMARK(inverse_near)->ArgName("joints")->Arg(6)->Arg(7);

}  // namespace
