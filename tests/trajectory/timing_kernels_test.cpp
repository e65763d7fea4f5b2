#include "polyarm/trajectory/timing_kernels.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

namespace polyarm::trajectory {
namespace {

/// The loops for wider instructions give the bits of those that every processor has.
TEST(TimingKernels, AllSetsGiveTheSameBits) {
  std::mt19937_64 engine(15);
  std::uniform_real_distribution<double> draw(0.1, 2);
  const std::size_t n = 103;  // no multiple of a vector
  const auto list = [&] {
    std::vector<double> out(n);
    for (double& x : out) x = draw(engine);
    return out;
  };
  const std::vector<double> q0 = list(), q1 = list(), q2 = list(), scale = list(), d0 = list(), d1 = list(),
                            d2 = list();
  std::vector<std::vector<double>> state;
  for (int k = 0; k < 5; ++k) state.push_back(list());
  std::vector<std::vector<double>> results[2];
  for (int which = 0; which < 2; ++which) {
    const kernels::Set& set = which == 0 ? kernels::portable() : kernels::best();
    std::vector<std::vector<double>> s = state, sums(9, std::vector<double>(n, 0.5));
    const kernels::Row row{n,           q0.data(),   q1.data(),   q2.data(),   scale.data(), s[0].data(),
                           s[1].data(), s[2].data(), s[3].data(), s[4].data(), -0.7};
    double* to[9];
    for (std::size_t k = 0; k < 9; ++k) to[k] = sums[k].data();
    set.evaluate(row, d0.data(), d1.data(), d2.data());
    set.assemble(row, 0.3, to);
    kernels::Decrease most;
    set.decrease(row, 0.3, d0.data(), d1.data(), d2.data(), most);
    set.step(row, 0.3, d0.data(), d1.data(), d2.data(), 0.4, 0.6);
    double sum = 0, residual = 0;
    set.measure(row, sum, residual);
    std::vector<std::vector<double>> use(6, std::vector<double>(n, 0.25));
    set.use({n, q0.data(), q1.data(), q2.data(), 1.1, -0.9, 0.8, -1.2, 0.3, 7},
            {d0.data(), d1.data(), d2.data(), scale.data(), q0.data()},
            {{use[0].data(), use[1].data(), use[2].data()}, {use[3].data(), use[4].data(), use[5].data()}});
    results[which] = s;
    results[which].insert(results[which].end(), sums.begin(), sums.end());
    results[which].insert(results[which].end(), use.begin(), use.end());
    results[which].push_back({most.primal, most.dual, sum, residual});
  }
  ASSERT_EQ(results[0].size(), results[1].size());
  for (std::size_t k = 0; k < results[0].size(); ++k)
    EXPECT_EQ(std::memcmp(results[0][k].data(), results[1][k].data(), 8 * results[0][k].size()), 0) << k;
}

}  // namespace
}  // namespace polyarm::trajectory
