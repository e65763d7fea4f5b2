#include "polyarm/cell/known_cells.hpp"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/setup/cell_reach.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;
using Json = nlohmann::json;

fs::path projects_folder() {
  const char* data = std::getenv("XDG_DATA_HOME");
  const char* home = std::getenv("HOME");
  const fs::path base =
      data && *data ? fs::path(data) : fs::path(home && *home ? home : ".") / ".local/share";
  return base / "polyarm" / "cells";
}

namespace {
constexpr std::size_t kMostRecent = 12, kMostCells = 200, kLargestReadme = 900'000;
fs::path recent_file() {
  return projects_folder().parent_path() / "recent.json";
}

/// Recently opened cells, newest first. Cells that no longer exist are left out.
std::vector<fs::path> recent_cells() {
  std::vector<fs::path> out;
  std::error_code error;
  const fs::path file = recent_file();
  if (!fs::is_regular_file(file, error) || fs::file_size(file, error) > 100'000) return out;
  const Json list = Json::parse(read_file(file), nullptr, false);
  if (!list.is_array()) return out;
  for (const Json& each : list)
    if (each.is_string() && out.size() < kMostRecent &&
        fs::exists(fs::path(each.get<std::string>()) / "cell.yaml", error))
      out.emplace_back(each.get<std::string>());
  return out;
}

/// Puts the open cell first in the list of recent cells. Does nothing if the list cannot be written.
std::vector<fs::path> note_recent(const fs::path& open) {
  std::vector<fs::path> all = recent_cells();
  if (!all.empty() && all.front() == open) return all;
  std::erase(all, open);
  all.insert(all.begin(), open);
  if (all.size() > kMostRecent) all.resize(kMostRecent);
  Json list = Json::array();
  for (const fs::path& each : all) list.push_back(each.string());
  std::error_code error;
  fs::create_directories(recent_file().parent_path(), error);
  try {
    write_file_atomically(recent_file(), list.dump());
  } catch (const std::exception&) {
  }
  return all;
}

/// The first words of the README.md; empty without one.
std::string title_of(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_regular_file(folder / "README.md", error)) return {};
  std::string text;
  Problems ignored;
  collect(ignored, [&] { text = read_file(folder / "README.md", kLargestReadme); });
  const std::string first = text.substr(0, text.find('\n'));
  return first.starts_with("# ") ? std::string(trim(first.substr(2))) : std::string{};
}

protocol::KnownCell cell_entry(const fs::path& folder, bool recent) {
  const AsUser user;
  std::vector<std::string> robots;
  try {
    for (const RobotEntry& robot : read_cell_file(folder).robots) robots.push_back(robot.model);
  } catch (const Error&) {  // can be opened; opening then reports the error
  }
  return {folder.filename().string(), folder.string(), title_of(folder), robots, recent};
}

void add_cells(const fs::path& parent, std::vector<fs::path>& out) {
  std::error_code error;
  std::vector<fs::path> here;
  for (const auto& entry : fs::directory_iterator(parent, error))
    if (entry.is_directory(error) && fs::exists(entry.path() / "cell.yaml", error) &&
        !entry.path().filename().string().starts_with("."))
      here.push_back(fs::weakly_canonical(entry.path(), error));
  std::sort(here.begin(), here.end());
  for (const fs::path& each : here)
    if (std::find(out.begin(), out.end(), each) == out.end() && out.size() < kMostCells) out.push_back(each);
}

/// Folders of all cells that can be opened, including recent ones.
std::vector<fs::path> openable(const fs::path& open, const std::vector<fs::path>& recent) {
  std::vector<fs::path> folders;
  add_cells(projects_folder(), folders);
  if (!open.empty()) add_cells(open.parent_path(), folders);
  // Also list the neighbours of recent cells, so examples stay in the list after a project is opened.
  for (const fs::path& each : recent) add_cells(each.parent_path(), folders);
  return folders;
}

protocol::CellReach::Answer wants_of(const CellFile& file) {
  protocol::CellReach::Answer out;
  Problems unread;
  for (const Wanted& each : required_by(file, &unread))
    out.wants.push_back({each.kind, each.what, each.why, each.sha256, each.allowed});
  if (!unread.list().empty()) out.unread = unread.list().front().text();
  return out;
}

/// `text` is host:NAME or secret:NAME and must be something that the cell needs. Remote clients can allow
/// nothing else.
void allow_one(const CellFile& file, const std::string& text) {
  const auto colon = text.find(':');
  const std::string kind = text.substr(0, colon), what = colon == std::string::npos ? "" : text.substr(colon + 1);
  if (kind != "host" && kind != "secret")
    throw Error("not-here", "'" + text + "' cannot be allowed here: hosts and secrets can",
                kind == "plugin" ? "native code is approved at a terminal: polyarm plugins approve FILE"
                                 : "files are allowed where the cell is started: polyarm run CELL --allow PATH");
  for (const Wanted& each : required_by(file))
    if (each.kind == kind && each.what == what) return remember_allowed(file, each);
  throw Error("not-wanted", "the cell does not access '" + text + "'",
              "the request cell.reach lists what it accesses");
}
}  // namespace

protocol::CellsList::Answer known_cells(const fs::path& open_folder) {
  const AsUser user;
  std::error_code error;
  const fs::path open = open_folder.empty() ? fs::path{} : fs::weakly_canonical(open_folder, error);
  const std::vector<fs::path> recent = open.empty() ? recent_cells() : note_recent(open);
  protocol::CellsList::Answer out{open.string(), {}};
  for (const fs::path& folder : openable(open, recent))
    out.cells.push_back(cell_entry(
        folder, folder != open && std::find(recent.begin(), recent.end(), folder) != recent.end()));
  return out;
}

protocol::CellReach::Answer reach_of_cell(const fs::path& open, const std::string& folder,
                                          const std::vector<std::string>& allow) {
  const AsUser user;
  std::error_code error;
  fs::path path = open;
  if (!folder.empty()) {
    const fs::path asked = fs::weakly_canonical(folder, error);
    const std::vector<fs::path> known =
        openable(open.empty() ? open : fs::weakly_canonical(open, error).parent_path(), recent_cells());
    if (std::find(known.begin(), known.end(), asked) == known.end())
      throw Error("unknown-cell", "'" + folder + "' is not one of the cells that can be opened",
                  "the request `cells` lists them");
    path = asked;
  }
  if (path.empty()) throw Error("no-cell", "no cell is open", "name one: folder");
  const CellFile file = read_cell_file(path);
  for (const std::string& each : allow) allow_one(file, each);
  return wants_of(file);
}

namespace {
[[noreturn]] void refuse_outside(const char* what, const std::string& named) {
  throw Error(
      "outside-cell",
      std::string("the ") + what + " '" + shortened(named) + "' is outside the project; this cell continues",
      std::string("name one of the project; a ") + what + " elsewhere must be named when Polyarm is started");
}

/// The folder that the request names; the open cell's folder if it names none.
fs::path folder_wished(const std::string& cell, const fs::path& open) {
  if (cell.empty()) return open;
  std::error_code error;
  const fs::path named = resolved(cell);
  const fs::path folder = fs::is_directory(named, error) ? named : named.parent_path();
  const std::vector<fs::path> known = openable(open, recent_cells());
  const bool listed = std::find(known.begin(), known.end(), folder) != known.end();
  const bool beside = !open.empty() && polyarm::inside(folder, project_root(open));
  if (!fs::exists(named, error) || (!listed && !beside))
    throw Error("unknown-cell",
                "'" + shortened(cell) + "' is not one of the cells that can be opened; this one continues",
                "name its folder or its file; `cells` lists those that are known");
  return folder;
}
}  // namespace

void require_within_reach(const RestartRequest& wish, const fs::path& open_folder) {
  const AsUser user;
  const fs::path folder = folder_wished(wish.cell, open_folder.empty() ? open_folder : resolved(open_folder));
  const auto in_project = [&](const fs::path& path) {
    return !folder.empty() && polyarm::inside(resolved(path), project_root(folder));
  };
  if (!wish.program.empty() && !in_project(folder / wish.program)) refuse_outside("program", wish.program);
  const std::string model = wish.robot.substr(wish.robot.find('=') + 1);
  std::error_code error;
  if (fs::is_regular_file(model, error) && !in_project(model))  // otherwise a name in the catalogue
    refuse_outside("robot", model);
}

}  // namespace polyarm::cell
