#include "polyarm/cell/state_folder.hpp"

#include "polyarm/base/file.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

StateFolder::StateFolder(fs::path cell_folder, std::set<std::string> live, bool keep,
                         const fs::path& elsewhere)
    : folder_(std::move(cell_folder)),
      state_(elsewhere.empty() ? folder_ / ".state" / "data" : elsewhere),
      live_(std::move(live)) {
  std::error_code error;
  if (!keep) fs::remove_all(state_, error);
}

fs::path StateFolder::folder_of(const std::string& name) const {
  return live_.contains(name) ? folder_ : state_;
}

void StateFolder::bring(const fs::path& original, bool again) const {
  std::error_code error;
  fs::create_directories(state_, error);
  const fs::path ignore = state_.parent_path() / ".gitignore";
  const bool in_cell = state_.parent_path().filename() == ".state";
  if (in_cell && !fs::exists(ignore, error)) write_file_atomically(ignore, "*\n");
  const fs::path copy = state_ / original.filename();
  if (again || !fs::exists(copy, error)) write_file_atomically(copy, read_file(original));
}

void StateFolder::renew(const std::string& name, const Location& where) const {
  if (live_.contains(name)) return;
  const data::LoadedFiles originals = data::load_files(name, folder_, where);
  bring(originals.data.file(), true);
  for (const data::ImportFile& points : originals.points) bring(points.file(), true);
}

data::LoadedFiles StateFolder::load(const std::string& name, const Location& where) const {
  if (live_.contains(name)) return data::load_files(name, folder_, where);
  const data::LoadedFiles originals = data::load_files(name, folder_, where);
  bring(originals.data.file());
  for (const data::ImportFile& points : originals.points) bring(points.file());
  if (!originals.script.empty()) bring(originals.script);
  data::LoadedFiles copies = data::load_files(name, state_, where);
  copies.script = originals.script;
  return copies;
}

}  // namespace polyarm::cell
