/// What a tick of guards costs: a UR5e among 50 obstacles, on a planned way and while it is jogged. Time of
/// the thread, not of the wall, so that a shared machine hardly counts; caches are as warm as here, not as in
/// a cell.
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/jog/body_guard.hpp"
#include "polyarm/surroundings/look_ahead.hpp"

using namespace polyarm;

namespace {

double thread_us() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

class Straight : public surroundings::PlannedWay {
 public:
  Straight(std::vector<double> from, std::vector<double> to, double duration)
      : from_(std::move(from)), to_(std::move(to)), acceleration_(from_.size(), 5.0), duration_(duration) {}
  double duration() const noexcept override { return duration_; }
  void at(double time, std::span<double> q, std::span<double> v) noexcept override {
    const double s = std::clamp(time / duration_, 0.0, 1.0);
    for (std::size_t j = 0; j < from_.size(); ++j) {
      if (!q.empty()) q[j] = from_[j] + s * (to_[j] - from_[j]);
      if (!v.empty()) v[j] = (to_[j] - from_[j]) / duration_;
    }
  }
  std::span<const double> acceleration() const noexcept override { return acceleration_; }

 private:
  std::vector<double> from_, to_, acceleration_;
  double duration_;
};

void report(const char* what, std::vector<double> us, double measured) {
  std::sort(us.begin(), us.end());
  const auto at = [&](double share) {
    return us[static_cast<std::size_t>(share * static_cast<double>(us.size() - 1))];
  };
  double sum = 0;
  for (const double x : us) sum += x;
  fmt::print("{:<28} p50 {:6.2f}  p99 {:7.2f}  max {:8.2f}  mean {:6.2f} us; {:.2f} exact distances a tick\n",
             what, at(0.5), at(0.99), us.back(), sum / static_cast<double>(us.size()),
             measured / static_cast<double>(us.size()));
}

}  // namespace

int main() {
  const description::RobotModel model =
      description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur5e");
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> even(-1, 1);
  description::Scene scene;
  while (scene.fixtures.size() < 50) {
    const Vec3 at{even(engine), even(engine), 0.5 + 0.7 * even(engine)};
    if (norm(at) < 0.45) continue;
    description::Fixture fixture;
    fixture.name = fmt::format("box {}", scene.fixtures.size());
    description::Shape box;
    box.size = {0.12 + 0.08 * even(engine), 0.12 + 0.08 * even(engine), 0.12 + 0.08 * even(engine)};
    box.pose = {at, from_rpy(3 * even(engine), even(engine), 3 * even(engine))};
    fixture.shapes = {box};
    scene.fixtures.push_back(fixture);
  }
  surroundings::GuardBodies bodies({{"arm", &model, nullptr, -1, false, {}}}, scene);
  surroundings::LookAhead ahead(bodies, 0, {});
  std::vector<jog::AxisLimits> axes;
  for (const int index : model.actuated) {
    const auto& limits = model.joints[static_cast<std::size_t>(index)].limits;
    const double v = limits.velocity.value_or(1.0);
    axes.push_back({limits.lower.value_or(-6), limits.upper.value_or(6), v, v / 0.25, v / 0.025});
  }
  jog::BodyGuard guard(bodies, 0, axes);
  const auto barriers = std::make_unique<jog::Barriers>();
  const std::vector<std::vector<double>> nobody(1, std::vector<double>(6, 0.0));
  surroundings::Moment moment;
  moment.robots = {{{}, std::vector<double>(6, 0.0)}};
  std::vector<double> moves, begins, jogs, v(6);
  double on_moves = 0, on_jogs = 0;
  for (int w = 0; w < 200; ++w) {
    std::vector<double> from, to;
    for (int j = 0; j < 6; ++j) from.push_back(2 * even(engine)), to.push_back(2 * even(engine));
    Straight way(from, to, 2.5);
    moment.robots[0].joints = from;
    bodies.look(moment);
    double start = thread_us();
    ahead.begin(way, {});
    begins.push_back(thread_us() - start);
    for (double t = 0; t < 2.5; t += 0.002) {
      way.at(t, moment.robots[0].joints, v);
      std::uint64_t had = bodies.measured();
      start = thread_us();
      bodies.look(moment);
      const auto answer = ahead.look(way, t, t + 0.5, nobody);
      moves.push_back(thread_us() - start);
      on_moves += static_cast<double>(bodies.measured() - had);
      had = bodies.measured();
      start = thread_us();
      guard.fill(v, nobody, *barriers);
      jogs.push_back(thread_us() - start);
      on_jogs += static_cast<double>(bodies.measured() - had);
      if (answer.free_until - t < 0.01) break;  // it would stand here
    }
  }
  fmt::print("{} pairs of bodies\n", bodies.pairs().size());
  report("a planned way, a tick", moves, on_moves);
  report("a planned way, its first tick", begins, 0);
  report("jogging at full speed, a tick", jogs, on_jogs);
}
