#include "apps/sweep_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/apart.hpp"
#include "apps/client.hpp"
#include "apps/scratch.hpp"
#include "apps/terminal.hpp"
#include "polyarm/sweeps/names.hpp"
#include "polyarm/sweeps/run_variant.hpp"

namespace polyarm::apps {

namespace {

using Clock = std::chrono::steady_clock;

/// One line on a terminal that is written over; elsewhere a line now and then.
class ProgressLine {
 public:
  explicit ProgressLine(bool on) : on_(on), terminal_(::isatty(STDERR_FILENO) != 0) {}
  void show(const SweepProgress& p, std::uint64_t left) {
    const double wall = std::chrono::duration<double>(Clock::now() - begun_).count();
    if (!on_ || wall - shown_ < (terminal_ ? 0.2 : 30)) return;
    shown_ = wall;
    const double rate = static_cast<double>(p.done) / wall;
    const std::string text =
        fmt::format("{} of {} variants, {} did not complete, {:.2g} per second, {} left", p.before + p.done,
                    p.of, p.done - p.completed, rate, duration_text(static_cast<double>(left) / rate));
    fmt::print(stderr, "{}{}{}", terminal_ ? own_return() + own_escape("[K") : std::string(), text,
               terminal_ ? "" : "\n");
    std::fflush(stderr);
    drawn_ = terminal_;
  }
  ~ProgressLine() {
    if (drawn_) fmt::print(stderr, "{}{}", own_return(), own_escape("[K"));
  }

 private:
  bool on_, terminal_, drawn_ = false;
  double shown_ = 0;
  Clock::time_point begun_ = Clock::now();
};

/// The variants without a result, one by one.
class Pending {
 public:
  Pending(const SweepWork& work, std::map<std::uint64_t, std::string>& keys) : work_(work), keys_(keys) {}
  std::optional<std::size_t> next() {
    for (; next_ < work_.variants.count() && given_ < work_.most; next_ += work_.every) {
      if (!work_.shard.has(next_)) continue;
      const sweeps::Variant variant = work_.variants.at(next_);
      const std::string key = sweeps::key_of(variant, work_.robots.of(variant.robot));
      const bool has_row = work_.store.has(key) || (work_.others && work_.others->has(key));
      const bool under_way =
          std::any_of(keys_.begin(), keys_.end(), [&](const auto& each) { return each.second == key; });
      if (has_row || under_way) continue;
      keys_[next_] = key;
      ++given_;
      return static_cast<std::size_t>(std::exchange(next_, next_ + work_.every));
    }
    return std::nullopt;
  }

 private:
  const SweepWork& work_;
  std::map<std::uint64_t, std::string>& keys_;  ///< of variants under way
  std::uint64_t next_ = 0, given_ = 0;
};

/// Variants of the shard, and those that have a row.
void count_rows(const SweepWork& work, SweepProgress& out) {
  for (std::uint64_t i = work.shard.index; i < work.variants.count(); i += work.shard.count) {
    const sweeps::Variant variant = work.variants.at(i);
    const std::string key = sweeps::key_of(variant, work.robots.of(variant.robot));
    ++out.of;
    out.before += work.store.has(key) || (work.others && work.others->has(key));
  }
}

sweeps::Row row_of(const sweeps::Variant& variant, const std::string& key, const ApartResult& result) {
  auto row = result.said ? sweeps::row_from_json(*result.said) : std::nullopt;
  if (!row)
    row = sweeps::crashed_row(variant, key, result.why.empty() ? "it returned no result" : result.why);
  row->wall_s = result.seconds;
  return *row;
}

}  // namespace

std::string duration_text(double seconds) {
  if (!(seconds < 1e9)) return "?";
  const auto whole = static_cast<std::uint64_t>(seconds + 0.5);
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  if (whole < 48 * 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
  return fmt::format("{:.1f} days", seconds / 86400);
}

void check_names(const sweeps::Sweep& sweep, const description::Catalogue& catalogue) {
  using nlohmann::json;
  const Scratch scratch("sweep");
  Problems problems;
  const auto look = [&](std::size_t) {
    Problems found;
    collect(found, [&] {
      for (const Problem& p : sweeps::unknown_names(sweep, catalogue, scratch.of(0))) found.add(p);
    });
    json out = json::array();
    for (const Problem& p : found.list())
      if (p.severity == Severity::error)
        out.push_back({p.code, p.where.file, p.where.line, p.where.column, p.what, p.advice});
    return out.dump(-1, ' ', false, json::error_handler_t::replace);
  };
  run_apart(1, 1, sweep.patience, look, [&](std::size_t, const ApartResult& result) {
    if (!result.said) return;  // it crashed: the rows of the variants say why
    for (const json& p : json::parse(*result.said))
      problems.error(p[0], Location{p[1], p[2], p[3]}, p[4], p[5]);
  });
  problems.throw_if_errors();
}

SweepProgress run_variants(const SweepWork& work) {
  SweepProgress out;
  count_rows(work, out);
  const Scratch scratch("sweep");
  std::map<std::uint64_t, std::string> keys;
  Pending pending(work, keys);
  ProgressLine line(work.progress);
  const auto begun = Clock::now();
  catch_interrupts();
  run_apart([&] { return interrupted() ? std::nullopt : pending.next(); }, work.jobs, work.sweep.patience,
            [&](std::size_t number) {
              return sweeps::to_json(sweeps::run_variant(
                  work.sweep, work.variants.at(number), keys.at(number), work.catalogue, scratch.of(number)));
            },
            [&](std::size_t number, const ApartResult& result) {
              const std::string key = keys.at(number);
              keys.erase(number);
              scratch.drop(number);
              if (result.from_outside) {
                ++out.lost;
                return;
              }
              const sweeps::Row row = row_of(work.variants.at(number), key, result);
              work.store.add(row);
              ++out.done;
              out.completed += row.completed();
              out.crashed += row.ended == "crashed";
              out.cost_s += result.seconds;
              out.cost_least_s = out.done == 1 ? result.seconds : std::min(out.cost_least_s, result.seconds);
              out.cost_most_s = std::max(out.cost_most_s, result.seconds);
              line.show(out, out.of - out.before - out.done);
            },
            [] { return interrupted(); });
  out.stopped = interrupted();
  out.wall_s = std::chrono::duration<double>(Clock::now() - begun).count();
  return out;
}

}  // namespace polyarm::apps
