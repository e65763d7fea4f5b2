#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>

#include "apps/apart.hpp"
#include "apps/client.hpp"
#include "apps/example_cell.hpp"
#include "apps/options.hpp"
#include "apps/sweep_report.hpp"
#include "apps/sweep_run.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/sha256.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/there.hpp"
#include "polyarm/sweeps/sweep_file.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

struct SweepArguments {
  std::string file, shard, out, csv, html;
  sweeps::Words words;
  std::vector<std::string> plugins;
  unsigned jobs = 0, slurm = 0;
  std::size_t top = 10;
  bool plan = false, show = false, json = false, again = false, submit = false;
};

/// A sweep with where its results are.
struct Opened {
  sweeps::Sweep sweep;
  fs::path out;
};

bool has_axes(const sweeps::Words& w) {
  return !(w.robots + w.base + w.programs + w.speeds + w.seeds + w.hardware).empty();
}

/// True for a cell's file; a file that is neither is taken for a sweep, whose reader says what is wrong.
bool is_cell_file(const fs::path& file) {
  return is_file(file) && read_file(file).find("polyarm: cell/") != std::string::npos;
}

/// The file of a sweep: the one named, that of an example, or empty for a cell with axes on the command line.
fs::path find_file(SweepArguments& a) {
  if (is_file(a.file) && !is_cell_file(a.file)) return fs::absolute(a.file);
  fs::path cell = a.file;
  if (!is_there(cell))
    if (const auto own = own_copy_of_example(a.file)) cell = *own;
  if (!is_file(cell / "cell.yaml") && !is_file(cell))
    throw WrongUse("no-file", "'" + a.file + "' is no sweep file and no cell",
                   "polyarm sweep FILE, or polyarm sweep CELL --robots 'ur*'");
  if (!has_axes(a.words)) {
    if (const fs::path file = cell / "sweep.yaml"; is_file(file)) return fs::absolute(file);
    throw WrongUse("no-axis", "the cell has no sweep.yaml, and no option says what is varied",
                   "--robots 'ur*,abb/*' --base x=-0.1:0.1:5,y=0 --speeds 50%,100%");
  }
  a.words.cell = fs::absolute(cell).lexically_normal().string();
  return {};
}

Opened open_sweep(SweepArguments& a, const description::Catalogue& catalogue) {
  const fs::path file = find_file(a);
  Opened out;
  if (!file.empty()) {
    if (has_axes(a.words))
      throw WrongUse("bad-value", "the sweep file says what is varied, and so do options",
                     "write it into the file, or name the cell instead of the file");
    out.sweep = sweeps::read_sweep_file(file, catalogue);
    out.out = file.parent_path() / ".state" / "sweeps" / out.sweep.name;
  } else {
    const std::string text = sweeps::text_of(a.words);
    const fs::path cell = a.words.cell, folder = is_folder(cell) ? cell : cell.parent_path();
    out.out = folder / ".state" / "sweeps" / ("options-" + sha256(text).substr(0, 8));
    out.sweep = sweeps::read_sweep(text, folder / "command line", catalogue);
    out.sweep.file = out.out / "sweep.yaml";
    if (a.slurm > 0) fs::create_directories(out.out), write_file_atomically(out.sweep.file, text);
  }
  if (!a.out.empty()) out.out = fs::absolute(a.out);
  return out;
}

/// Rows of other inputs are not mixed with new ones: with --again they are deleted, else this is an error.
void settle_inputs(sweeps::Store& store, const sweeps::Inputs& now, bool again) {
  const sweeps::Inputs before = store.inputs();
  const std::vector<std::string> changed = sweeps::changes(before, now);
  if (again || before.empty()) store.clear();
  if (!again && !before.empty() && !changed.empty())
    throw Error("changed-inputs",
                fmt::format("the {} rows that are there were made before these changed: {}", store.count(),
                            join(changed, ", ")),
                "--again deletes them and runs every variant; --out FOLDER keeps them; --show shows them");
  store.set_inputs(now);
}

/// Adds the rows of shards that lie beside.
void merge_shards(sweeps::Store& store, const fs::path& out) {
  for (const fs::path& file : sweeps::shard_files(out)) {
    try {
      store.merge(file);
    } catch (const Error& e) {
      fmt::print(stderr, "polyarm sweep: {}\n", e.what());
    }
  }
}

fs::path own_path() {
  std::error_code error;
  const fs::path path = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path("polyarm") : path;
}

/// Writes the batch script, and submits it if that was asked.
int write_job(const SweepArguments& a, const Opened& opened) {
  fs::create_directories(opened.out);
  const fs::path script = opened.out / "sweep.sbatch";
  write_file_atomically(script, sweeps::slurm_script({own_path().string(), opened.sweep.file, opened.out,
                                                      opened.sweep.name, a.slurm, a.jobs > 0 ? a.jobs : 1}));
  if (!a.submit) {
    fmt::print("written: {}\nsubmit it with: sbatch --chdir={} {}\nthen: polyarm sweep {} --out {} --show\n",
               script.string(), opened.out.string(), script.string(), opened.sweep.file.string(),
               opened.out.string());
    return kOk;
  }
  std::fflush(nullptr);
  const std::string folder = "--chdir=" + opened.out.string();
  ::execlp("sbatch", "sbatch", folder.c_str(), script.c_str(), nullptr);
  throw Error("no-sbatch", std::string("sbatch cannot be run: ") + std::strerror(errno),
              "run it on a machine of the cluster; the script is " + script.string());
}

/// What --csv, --html and --json want, or the table.
int report(const SweepArguments& a, const Opened& opened, const description::Catalogue& catalogue,
           const sweeps::Store& store) {
  const SweepReport report(opened.sweep, catalogue, store, a.top);
  if (!a.csv.empty()) report.write_csv(a.csv);
  if (!a.html.empty()) report.write_html(a.html);
  if (a.json)
    report.print_json();
  else if (a.csv != "-")
    report.print_table();
  return report.summary().total().completed > 0 ? kOk : kFailed;
}

int show(const SweepArguments& a, const Opened& opened, const description::Catalogue& catalogue) {
  const fs::path file = sweeps::results_file(opened.out);
  if (!sweeps::shard_files(opened.out).empty()) {
    sweeps::Store store(file, sweeps::Store::Open::write);
    merge_shards(store, opened.out);
  }
  const sweeps::Store store(file, sweeps::Store::Open::read);
  const auto changed = sweeps::changes(store.inputs(), sweeps::inputs_of(opened.sweep, POLYARM_VERSION));
  if (!changed.empty())
    fmt::print(stderr, "polyarm sweep: these rows were made before this changed: {}\n", join(changed, ", "));
  return report(a, opened, catalogue, store);
}

SweepProgress measure_cost(const SweepWork& whole) {
  SweepWork part = whole;
  part.most = std::max<std::uint64_t>(4, 2 * whole.jobs);
  part.every = std::max<std::uint64_t>(1, whole.variants.count() / part.most);
  part.progress = false;
  return run_variants(part);
}

void print_plan(const Opened& opened, const SweepWork& work, const SweepProgress& p) {
  const sweeps::Sweep& s = opened.sweep;
  std::vector<std::string> axes;
  const auto add = [&](const char* name, std::size_t count) {
    if (count > 1) axes.push_back(fmt::format("{} {}", count, name));
  };
  add("robots", s.robots.size()), add("base places", s.places.size()), add("programs", s.programs.size());
  add("speeds", s.speeds.size()), add("faults", s.faults.size()), add("seeds", s.seeds.size());
  for (const sweeps::ValueAxis& axis : s.values) add(("values of " + axis.name).c_str(), axis.values.size());
  fmt::print(
      "{} variants: {}{}\n", work.variants.count(),
      join(axes, s.combine == sweeps::Combine::zip ? " with " : " × "),
      s.sample ? fmt::format("; {} random ones of {}", work.variants.count(), work.variants.all()) : "");
  const std::uint64_t left = p.of - p.before - p.done;
  if (p.done == 0) {
    fmt::print("{} have a result, {} are left; none was measured now\n", p.before, left);
    return;
  }
  const double each = p.wall_s / static_cast<double>(p.done);
  fmt::print("{} measured: {:.2f} s each ({:.2f} to {:.2f} s); {} at a time take {:.2f} s for each\n", p.done,
             p.cost_s / static_cast<double>(p.done), p.cost_least_s, p.cost_most_s, work.jobs, each);
  fmt::print("{} have a result, {} are left: about {} on this machine\n", p.before + p.done, left,
             duration_text(each * static_cast<double>(left)));
}

/// After a run: what is left, and how to go on.
int ending(const SweepArguments& a, const SweepProgress& p, const fs::path& file) {
  const std::uint64_t left = p.of - p.before - p.done;
  if (!a.json)
    fmt::print(stderr, "{} variants run in {} ({:.0f} an hour), {} had a result before; results: {}\n",
               p.done, duration_text(p.wall_s),
               p.wall_s > 0 ? 3600 * static_cast<double>(p.done) / p.wall_s : 0, p.before, file.string());
  if (p.lost > 0) fmt::print(stderr, "{} variants were killed from outside and have no row\n", p.lost);
  if (left > 0) fmt::print(stderr, "{} variants are left: the same command goes on with them\n", left);
  return p.stopped ? kStopped : left > 0 ? kFailed : kOk;
}

int sweep(SweepArguments& a) {
  const description::Catalogue catalogue = open_catalogue();
  const Opened opened = open_sweep(a, catalogue);
  const sweeps::Variants variants(opened.sweep);
  if (a.show) return show(a, opened, catalogue);
  check_names(opened.sweep, catalogue);
  if (a.slurm > 0) return write_job(a, opened);
  const sweeps::Shard shard = a.shard.empty() ? sweeps::Shard{} : sweeps::read_shard(a.shard);
  const fs::path file = sweeps::results_file(opened.out, shard), whole = sweeps::results_file(opened.out);
  sweeps::Store store(file, sweeps::Store::Open::write);
  settle_inputs(store, sweeps::inputs_of(opened.sweep, POLYARM_VERSION), a.again);
  std::optional<sweeps::Store> others;
  if (shard.count == 1 && !a.again) merge_shards(store, opened.out);
  if (shard.count > 1 && !a.again && is_file(whole)) others.emplace(whole, sweeps::Store::Open::read);
  if (others && !sweeps::changes(others->inputs(), store.inputs()).empty()) others.reset();
  sweeps::RobotHashes robots(catalogue);
  SweepWork work{opened.sweep, variants, catalogue, robots, store, others ? &*others : nullptr, shard};
  work.jobs = a.jobs > 0 ? a.jobs : processors();
  if (a.plan) {
    const SweepProgress p = measure_cost(work);
    print_plan(opened, work, p);
    return p.stopped ? kStopped : kOk;
  }
  const SweepProgress p = run_variants(work);
  const int code = ending(a, p, file);
  if (code != kOk || shard.count > 1) return code;
  return report(a, opened, catalogue, store);
}

}  // namespace

int run_sweep(int argc, char** argv) {
  CommandLine app(
      "Runs a program on many robots, base places, speeds and faults, in simulation: the best, and why",
      "polyarm sweep");
  SweepArguments a;
  app.add_option("file", a.file,
                 "a sweep file (polyarm: sweep/1), a cell with a sweep.yaml, or a cell and --robots …")
      ->required();
  app.add_option("--robots", a.words.robots, "names, patterns or conditions: 'ur*,abb/*,payload >= 5kg'");
  app.add_option("--base", a.words.base,
                 "base places: x=-0.1:0.1:5,y=0|0.1,yaw=0|90deg (FROM:TO:STEPS, or values)");
  app.add_option("--programs", a.words.programs, "programs of the cell");
  app.add_option("--speeds", a.words.speeds, "shares of the programmed speed: 50%,100%");
  app.add_option("--seeds", a.words.seeds, "seeds of the deviations");
  app.add_option("--hardware", a.words.hardware, "declared, mock or mujoco")->check(wrong_hardware, "NAME");
  app.add_flag("--plan", a.plan, "how many variants, and how long they take, measured on a few");
  app.add_flag("--show", a.show, "show what is there; run nothing");
  app.add_option("--top", a.top, "so many of the best are shown (10)");
  app.add_flag("--json", a.json, "all rows as a JSON list");
  app.add_option("--csv", a.csv, "write all rows to this file; -: standard output");
  app.add_option("--html", a.html, "write a page with maps over base places");
  app.add_option("--out", a.out, "folder of the results (.state/sweeps/NAME beside the file)");
  app.add_flag("--again", a.again, "delete the results that are there, and run every variant");
  app.add_option("-j,--jobs", a.jobs, "so many at a time (as many as there are processors)");
  app.add_option("--shard", a.shard, "INDEX/COUNT: only this part of the variants, into a file of its own");
  app.add_option("--slurm", a.slurm, "write a job array of so many shards for Slurm")->range(1, 100'000);
  app.add_flag("--submit", a.submit, "with --slurm: submit it");
  add_plugin_option(app, a.plugins);
  app.footer(
      examples({"polyarm sweep examples/pick_and_place",
                "polyarm sweep examples/pick_and_place --robots 'ur*,abb/*' --base x=-0.1:0.1:5,y=0 "
                "--programs flowing --html map.html",
                "polyarm sweep night.yaml --plan", "polyarm sweep night.yaml --slurm 64 --submit"}) +
      "\nExit codes: 0 done, 1 no variant completed or some are left, 2 wrong command line, 3 stopped by a "
      "person\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  load_plugins(a.plugins);
  return sweep(a);
}

}  // namespace polyarm::apps
