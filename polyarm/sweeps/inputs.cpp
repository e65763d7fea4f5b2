#include "polyarm/sweeps/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "polyarm/base/file.hpp"
#include "polyarm/base/sha256.hpp"
#include "polyarm/base/there.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::sweeps {

namespace fs = std::filesystem;

namespace {
constexpr std::size_t kMostFiles = 20'000;

/// True for what a cell does not read: notes, results and other sweeps beside it.
bool is_apart(const fs::path& file, const std::string& text) {
  for (const char* ending : {".md", ".html", ".csv", ".json", ".svg", ".log", ".sqlite"})
    if (file.extension() == ending) return true;
  return text.starts_with("polyarm: sweep/");
}

void add_file(const fs::path& file, const std::string& name, Inputs& out) {
  const std::string text = read_file(file);
  if (is_apart(file, text)) return;
  if (out.size() >= kMostFiles)
    throw Error("too-many", fmt::format("the cell has more than {} files", kMostFiles),
                "move what does not belong to it elsewhere");
  out[name] = sha256(text);
}

void add_folder(const fs::path& folder, Inputs& out) {
  for (auto at = fs::recursive_directory_iterator(folder); at != fs::recursive_directory_iterator(); ++at) {
    const std::string name = at->path().filename().string();
    if (at->is_directory() && (name.starts_with(".") || name == "failures" || name == "__pycache__"))
      at.disable_recursion_pending();
    else if (at->is_regular_file() && !name.starts_with("."))
      add_file(at->path(), at->path().lexically_relative(folder).generic_string(), out);
  }
}

/// What a variant does not tell and its result depends on.
std::string how_it_is_run(const Sweep& sweep) {
  std::string out = fmt::format("{} {} {} {} {} {} {} {} {}", sweep.robot, sweep.hardware, sweep.cycles,
                                sweep.seconds, sweep.clearance, sweep.least_clearance, sweep.vary.base,
                                sweep.vary.yaw, sweep.cell.filename().string());
  for (const auto& [name, deviation] : sweep.vary.points) out += fmt::format(" {} {}", name, deviation);
  return out;
}
}  // namespace

Inputs inputs_of(const Sweep& sweep, const std::string& version) {
  const cell::CellFile file = cell::read_cell_file(sweep.cell);
  Inputs out;
  add_folder(file.folder, out);
  std::vector<std::string> named = {file.scene, file.signals, file.plc};
  named.insert(named.end(), file.controllers.begin(), file.controllers.end());
  for (const cell::RobotEntry& robot : file.robots) named.insert(named.end(), {robot.model, robot.tool});
  named.insert(named.end(), sweep.programs.begin(), sweep.programs.end());
  for (const std::string& name : named)  // files beside the cell are there already
    if (const fs::path path = file.folder / name; name.starts_with("..") || fs::path(name).is_absolute())
      if (is_file(path)) add_file(path, name, out);
  out["how it is run"] = sha256(how_it_is_run(sweep));
  out["version"] = version;
  return out;
}

std::vector<std::string> changes(const Inputs& before, const Inputs& now) {
  std::vector<std::string> out;
  for (const auto& [name, hash] : before)
    if (const auto at = now.find(name); at == now.end() || at->second != hash) out.push_back(name);
  for (const auto& [name, hash] : now)
    if (!before.contains(name)) out.push_back(name);
  std::sort(out.begin(), out.end());
  return out;
}

const std::string& RobotHashes::of(const std::string& robot) {
  const auto [at, is_new] = known_.insert({robot, {}});
  if (!is_new || robot.empty()) return at->second;
  if (is_file(robot))
    at->second = sha256(read_file(robot));
  else if (const auto file = catalogue_.find(robot))
    at->second = sha256(read_file(*file));
  return at->second;
}

}  // namespace polyarm::sweeps
