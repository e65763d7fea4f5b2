#include "polyarm/sweeps/slurm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::sweeps {

namespace fs = std::filesystem;

namespace {
constexpr double kMostShards = 100'000;

/// For a shell, in single quotes.
std::string shell_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Letters, digits, dots and dashes: #SBATCH lines are read without a shell.
std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' ? c : '_';
  return out;
}
}  // namespace

Shard read_shard(const std::string& text) {
  const std::vector<std::string> parts = split_fields(text, '/');
  const auto index = parts.empty() ? std::nullopt : parse_number(parts[0]);
  const auto count = parts.size() == 2 ? parse_number(parts[1]) : std::nullopt;
  const auto whole = [](double value) { return value == std::floor(value); };
  if (!index || !count || !whole(*index) || !whole(*count) ||
      !(*index >= 0 && *index < *count && *count <= kMostShards))
    throw Error("bad-value", "'" + text + "' is no shard", "INDEX/COUNT, from 0/4 to 3/4");
  return {static_cast<std::uint64_t>(*index), static_cast<std::uint64_t>(*count)};
}

std::string slurm_script(const SlurmJob& job) {
  return fmt::format(
      "#!/bin/bash\n"
      "#SBATCH --job-name=polyarm-{0}\n"
      "#SBATCH --array=0-{1}\n"
      "#SBATCH --ntasks=1\n"
      "#SBATCH --cpus-per-task={2}\n"
      "#SBATCH --requeue\n"
      "#SBATCH --open-mode=append\n"
      "#SBATCH --output=polyarm-{0}-%a.log\n"
      "exec {3} sweep {4} --out {5} --shard \"$SLURM_ARRAY_TASK_ID/{6}\" --jobs {2}\n",
      plain(job.name), job.shards - 1, job.jobs, shell_quoted(job.command), shell_quoted(job.sweep.string()),
      shell_quoted(job.out.string()), job.shards);
}

fs::path results_file(const fs::path& out, const Shard& shard) {
  if (shard.count == 1) return out / "results.sqlite";
  return out / fmt::format("results.shard-{}-of-{}.sqlite", shard.index, shard.count);
}

std::vector<fs::path> shard_files(const fs::path& out) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(out, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("results.shard-") && name.ends_with(".sqlite")) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace polyarm::sweeps
