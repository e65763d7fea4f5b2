#pragma once
/// Writes the job of a sweep for Slurm: an array whose tasks each run one shard.
#include <cstdint>
#include <filesystem>
#include <string>

namespace polyarm::sweeps {

/// Shard `index` of `count` has the variants whose number leaves this remainder.
struct Shard {
  std::uint64_t index = 0, count = 1;
  bool has(std::uint64_t number) const { return number % count == index; }
};
/// "3/16". Throws Error("bad-value").
Shard read_shard(const std::string& text);

struct SlurmJob {
  std::string command;          ///< path of polyarm
  std::filesystem::path sweep;  ///< file
  std::filesystem::path out;    ///< folder of the results, which all nodes see
  std::string name;
  std::uint64_t shards = 1;
  unsigned jobs = 1;  ///< processes of a shard
};
/// The text of the batch script. A task that was killed or requeued goes on where it was.
std::string slurm_script(const SlurmJob& job);

/// The file of results of a shard, or of the whole sweep.
std::filesystem::path results_file(const std::filesystem::path& out, const Shard& shard = {});
/// Files of shards in the folder, in order.
std::vector<std::filesystem::path> shard_files(const std::filesystem::path& out);

}  // namespace polyarm::sweeps
