#include "polyarm/trajectory/trajectory.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <random>

#include "polyarm/base/error.hpp"

namespace {
std::atomic<int> allocations{0};
}

// Not inlined, as the compiler would take malloc and free for a mismatched pair.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size ? size : 1);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace polyarm::trajectory::trajectory_test {
namespace {

constexpr std::size_t kCount = Trajectory::kCoefficients;

/// `segments` random polynomials of two joints, each 0.1 to 1 s long.
Trajectory random_trajectory(std::mt19937& random, int segments) {
  std::uniform_real_distribution<double> value(-1, 1), length(0.1, 1);
  Trajectory out(2);
  std::vector<double> c(2 * kCount);
  for (int i = 0; i < segments; ++i) {
    for (double& x : c) x = value(random);
    out.append(length(random), c);
  }
  return out;
}

TEST(Trajectory, SamplesThePolynomialAndItsDerivatives) {
  Trajectory line(1);
  line.append(2, std::vector<double>{1, 2, 3, 4, 5, 6});
  std::vector<double> q(1), v(1), a(1);
  std::size_t hint = 0;
  line.sample(1, q, v, a, hint);
  EXPECT_DOUBLE_EQ(q[0], 21);
  EXPECT_DOUBLE_EQ(v[0], 2 + 6 + 12 + 20 + 30);
  EXPECT_DOUBLE_EQ(a[0], 6 + 24 + 60 + 120);
}

TEST(Trajectory, AnyHintAndAnyOrderGiveTheSame) {
  std::mt19937 random(1);
  const Trajectory trajectory = random_trajectory(random, 40);
  std::uniform_real_distribution<double> time(-1, trajectory.duration() + 1);
  std::vector<double> q(2), v(2), a(2), q2(2), v2(2), a2(2);
  std::size_t kept = 0;
  for (int i = 0; i < 5000; ++i) {
    const double t = i % 10 == 0 ? trajectory.end_of(random() % 40) : time(random);
    std::size_t fresh = random() % 7 == 0 ? 1000000 : random() % 40;
    trajectory.sample(t, q, v, a, kept);
    trajectory.sample(t, q2, v2, a2, fresh);
    EXPECT_EQ(q, q2);
    EXPECT_EQ(v, v2);
    EXPECT_EQ(a, a2);
    EXPECT_EQ(kept, fresh);
  }
}

TEST(Trajectory, RestsBeforeItsStartAndAfterItsEnd) {
  std::mt19937 random(2);
  const Trajectory trajectory = random_trajectory(random, 3);
  std::vector<double> start(2), end(2), q(2), v(2), a(2);
  std::size_t hint = 2;
  const std::vector<double> rest{0, 0};
  trajectory.sample(0, start, v, a, hint);
  EXPECT_NE(v, rest);
  trajectory.sample(trajectory.duration(), end, v, a, hint);
  for (const double early : {-1e-9, -5.0, -std::numeric_limits<double>::infinity()}) {
    trajectory.sample(early, q, v, a, hint);
    EXPECT_EQ(q, start);
    EXPECT_EQ(v, rest);
  }
  for (const double late : {1e-9, 5.0, std::numeric_limits<double>::infinity()}) {
    trajectory.sample(trajectory.duration() + late, q, v, a, hint);
    EXPECT_EQ(q, end);
    EXPECT_EQ(v, rest);
    EXPECT_EQ(a, rest);
  }
  trajectory.sample(NAN, q, v, a, hint);
  EXPECT_EQ(q, start);
}

TEST(Trajectory, SamplingAllocatesNothing) {
  std::mt19937 random(3);
  const Trajectory trajectory = random_trajectory(random, 20);
  std::vector<double> q(2), v(2), a(2);
  std::size_t hint = 0;
  const int before = allocations;
  for (double t = -1; t < trajectory.duration() + 1; t += 1e-3) trajectory.sample(t, q, v, a, hint);
  EXPECT_EQ(allocations, before);
}

TEST(Trajectory, AnEmptyOneLeavesTheValuesAlone) {
  std::vector<double> q{7};
  std::size_t hint = 3;
  Trajectory(1).sample(0.5, q, {}, {}, hint);
  EXPECT_EQ(q[0], 7);
  EXPECT_EQ(Trajectory(1).duration(), 0);
}

TEST(Trajectory, RefusesSegmentsThatAreNone) {
  Trajectory trajectory(2);
  const std::vector<double> enough(2 * kCount), few(kCount);
  EXPECT_THROW(trajectory.append(0, enough), Error);
  EXPECT_THROW(trajectory.append(NAN, enough), Error);
  EXPECT_THROW(trajectory.append(std::numeric_limits<double>::infinity(), enough), Error);
  EXPECT_THROW(trajectory.append(1, few), Error);
  EXPECT_TRUE(trajectory.empty());
}

}  // namespace
}  // namespace polyarm::trajectory::trajectory_test
