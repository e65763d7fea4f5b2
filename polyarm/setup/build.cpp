#include "polyarm/setup/build.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "polyarm/base/shell_word.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/plugins/plugins.hpp"
#include "polyarm/program/checker.hpp"

namespace polyarm::cell {

namespace {
/// Calls `look` for each existing folder that the cell names.
template <typename Look>
void each_folder(const CellFile& file, Problems& problems, Look look) {
  for (const std::string& written : file.plugins) {
    const std::filesystem::path folder = file.folder / written;  // an absolute path stays unchanged
    std::error_code error;
    if (std::filesystem::is_directory(folder, error))
      look(written, folder);
    else
      problems.warning("no-folder", file.plugins_where, "'" + written + "' is not a folder with plugins",
                       "build your plugin, or correct 'plugins:'; folders are relative to the file");
  }
}

void load_the_users(Problems& problems) {
  plugins::load_default_folders();
  for (const plugins::Refusal& refusal : plugins::refused())
    problems.warning("plugin-refused", {refusal.file.string()}, refusal.reason, refusal.advice);
}
}  // namespace

void load_plugins(const CellFile& file, Problems& problems) {
  each_folder(file, problems, [&](const std::string&, const std::filesystem::path& folder) {
    plugins::load_approved_in(folder);
    for (const plugins::Library& library : plugins::unapproved())
      if (library.file.parent_path() == folder)
        problems.error("plugin-not-approved", {library.file.string()},
                       "the cell brings native code that nobody has approved on this machine; it would run "
                       "with all your rights",
                       "if you trust where it comes from: polyarm plugins approve " + shell_word(library.file.string()));
  });
  load_the_users(problems);
}

bool check_plugins_of_cell(const CellFile& file, Problems& problems) {
  load_the_users(problems);
  bool any = false;
  each_folder(file, problems, [&](const std::string& written, const std::filesystem::path& folder) {
    const std::vector<std::filesystem::path> files = plugins::not_loaded_in(folder);
    if (files.empty()) return;
    any = true;
    problems.warning("plugin-not-looked-into", file.plugins_where,
                     "check loads no native code of a cell: hardware and controllers of '" + written + "' (" +
                         files.front().filename().string() +
                         (files.size() > 1 ? " and " + std::to_string(files.size() - 1) + " more" : "") +
                         ") are not looked into",
                     "if you trust it: polyarm check CELL --plugins " + shell_word(folder.lexically_normal().string()));
  });
  return any;
}

namespace {
/// True for a script; otherwise the file is a script-information file.
bool is_script(const std::filesystem::path& path) {
  return path.extension() == ".script";
}

/// Loads a script's data at the start, as for a script-information file, so that checks of other files know
/// its names. The checker reports missing files.
void load_data_of(const program::Program& program, const CellFile& file, DataFiles& files,
                  Problems& problems) {
  for (const program::Statement* load : program::loads(program)) {
    const Location where = program.at(load->name_place);
    try {
      data::find_file(load->name, file.folder, where);
    } catch (const Error&) {
      continue;
    }
    collect(problems, [&] { files.load_now(load->name, where); });
  }
}
}  // namespace

std::string file_of_cell(const CellFile& file, const std::string& name, const Location& where) {
  namespace fs = std::filesystem;
  const fs::path path = file.folder / name;
  std::error_code error;
  if (fs::exists(path, error) || error) return path.string();
  std::vector<std::string> there;
  for (const auto& entry : fs::directory_iterator(path.parent_path(), error))
    if (const std::string ending = entry.path().extension(); ending == ".yaml" || ending == ".yml")
      there.push_back((fs::path(name).parent_path() / entry.path().filename()).string());
  std::sort(there.begin(), there.end());
  throw Error(Problem{"no-file", where, "there is no file '" + name + "'" + did_you_mean(name, there),
                      "looked in " + fs::absolute(path.parent_path()).lexically_normal().string()});
}

void add_robots(const CellFile& file, program::KnownNames& known) {
  if (file.robots.empty()) return;
  known.robots.emplace();
  for (const RobotEntry& robot : file.robots) {
    known.robots->names.push_back(robot.name);
    known.robots->tools.push_back(robot.tool);
  }
  for (const BeltEntry& belt : file.belts) known.robots->belts.push_back(belt.name);
}

void check_live(const CellFile& file, const signals::Signals& signals, Problems& problems) {
  for (const std::string& set : signals.live) {
    try {
      const auto where = signals.live_where.find(set);
      data::find_file(set, file.folder, where == signals.live_where.end() ? Location{} : where->second);
    } catch (const Error& e) {
      Problem problem = e.problems().front();
      problem.severity = Severity::warning;
      problem.what += ": nothing is live";
      problems.add(std::move(problem));
    }
  }
}

void add_provided(const signals::Signals& signals, program::KnownNames& known) {
  using Role = signals::LinkTag::Role;
  for (const signals::LinkEntry& link : signals.links)
    for (const signals::LinkTag& tag : link.tags)
      if (tag.direction == signals::Direction::in && (link.kind == "modbus" || tag.role == Role::answer))
        known.brought[tag.name] = link.name;
}

void add_places(const signals::Signals& signals, program::KnownNames& known) {
  for (const signals::Tag& tag : signals.tags)
    if (tag.where.line > 0) known.defined[tag.name] = tag.where;
}

namespace {
/// Adds the locations at which the user's data files define the names of the store.
void add_places(const data::DataStore& store, DataFiles& files, program::KnownNames& known) {
  for (const std::string& set : files.sets())
    for (const data::Entry& entry : files.origin(set).entries())
      if (entry.where.line > 0 && store.set_of(entry.name) == set) known.defined[entry.name] = entry.where;
}
}  // namespace

LoadedPrograms load_programs(const CellFile& file, const signals::Signals& signals, DataFiles& files,
                             data::DataStore& store, Problems& problems,
                             const std::function<void()>& more_names, const program::ReadPrograms& read) {
  LoadedPrograms out;
  std::size_t checked = 0;  // programs that came already parsed are already checked
  Problems of_data;         // names missing because of these problems are not reported
  const auto load_script = [&](const std::filesystem::path& path) -> std::optional<program::Program> {
    std::optional<program::Program> loaded = read ? read(path) : std::nullopt;
    if (loaded)
      ++checked;
    else
      collect(problems, [&] { loaded = program::load_program(path.string()); });
    return loaded;
  };
  if (!file.program.empty())
    collect(problems, [&] {
      std::filesystem::path path = data::find_file(file.program, file.folder, file.program_where);
      if (!is_script(path))
        collect(of_data, [&] {
          path =
              files.load_now(path.stem().string() == file.program ? file.program : path.filename().string(),
                             file.program_where);
        });
      if (of_data.has_errors()) return;
      if (path.empty())
        throw Error(Problem{"no-script", file.program_where, "'" + file.program + "' names no ScriptFile",
                            "add 'Name: ScriptFile' and 'Text: <script>' to it"});
      const bool bare = is_script(path) && path.stem() == std::filesystem::path(file.program).stem();
      out.program = load_script(path);
      if (bare && out.program) load_data_of(*out.program, file, files, of_data);
    });
  if (!file.plc.empty())
    collect(problems, [&] {
      out.plc = load_script(data::find_file(file.plc, file.folder, file.plc_where));
      if (out.plc) load_data_of(*out.plc, file, files, of_data);
    });
  for (const Problem& problem : of_data.list()) problems.add(problem);
  if (more_names) more_names();
  program::KnownNames known;
  known.add(store);
  known.folder = file.folder;
  add_robots(file, known);
  add_provided(signals, known);
  add_places(store, files, known);
  add_places(signals, known);
  for (const auto* loaded : {&out.program, &out.plc})
    if (*loaded && checked == 0 && !of_data.has_errors()) program::check(**loaded, known, problems);
  return out;
}

}  // namespace polyarm::cell
