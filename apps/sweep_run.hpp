#pragma once
/// Runs the variants of a sweep that have no result yet, each in a process of its own, and keeps their rows.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "polyarm/sweeps/inputs.hpp"
#include "polyarm/sweeps/slurm.hpp"
#include "polyarm/sweeps/store.hpp"
#include "polyarm/sweeps/variants.hpp"

namespace polyarm::apps {

struct SweepWork {
  const sweeps::Sweep& sweep;
  const sweeps::Variants& variants;
  const description::Catalogue& catalogue;
  sweeps::RobotHashes& robots;
  sweeps::Store& store;
  const sweeps::Store* others = nullptr;  ///< rows here count as done, too
  sweeps::Shard shard;
  unsigned jobs = 1;
  bool progress = true;             ///< on standard error
  std::uint64_t most = UINT64_MAX;  ///< run at most so many
  std::uint64_t every = 1;          ///< and only each of so many, to measure their cost
};

struct SweepProgress {
  std::uint64_t of = 0;                                ///< variants of the shard
  std::uint64_t before = 0;                            ///< that had a result before
  std::uint64_t done = 0, completed = 0, crashed = 0;  ///< in this run
  std::uint64_t lost = 0;  ///< whose process was ended from outside; they have no row
  bool stopped = false;    ///< by a person
  double wall_s = 0;       ///< of this run
  double cost_s = 0, cost_least_s = 0, cost_most_s = 0;  ///< wall time of all variants of this run; of one
};

/// Throws Error that lists the names of the sweep that its cell does not have. Looks in a process of its own.
void check_names(const sweeps::Sweep& sweep, const description::Catalogue& catalogue);

/// Ctrl-C ends it: variants under way are dropped, and the next run makes them.
SweepProgress run_variants(const SweepWork& work);

/// "2 h 05 min", "3 min 20 s", "4.1 s"
std::string duration_text(double seconds);

}  // namespace polyarm::apps
