#include "polyarm/realtime/zeros.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace polyarm::realtime {
namespace {

constexpr std::size_t kBytes = 64u << 20;

/// Memory of this process that is there, in bytes.
std::size_t resident() {
  std::size_t all = 0, there = 0;
  std::ifstream("/proc/self/statm") >> all >> there;
  return there * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

TEST(Zeros, TakesMemoryAtOnceOrWhenItIsWritten) {
  const std::size_t before = resident();
  Zeros<double> later(kBytes / sizeof(double), false);
  EXPECT_LT(resident(), before + kBytes / 4);
  later[later.size() - 1] = 1;
  EXPECT_EQ(later[later.size() / 2], 0);
  EXPECT_EQ(later[later.size() - 1], 1);
  const std::size_t between = resident();
  const Zeros<double> now(kBytes / sizeof(double), true);
  EXPECT_GT(resident(), between + kBytes / 2);
  EXPECT_EQ(now[now.size() - 1], 0);
}

TEST(Zeros, MayBeEmpty) {
  EXPECT_EQ(Zeros<double>().size(), 0u);
  EXPECT_EQ(Zeros<double>(0, true).size(), 0u);
}

}  // namespace
}  // namespace polyarm::realtime
