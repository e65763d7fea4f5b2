#include "polyarm/data/file_lookup.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"

namespace polyarm::data {

namespace fs = std::filesystem;

std::vector<std::string> file_names_in(const fs::path& folder) {
  constexpr std::size_t kMost = 2000;
  std::vector<std::string> out;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end && out.size() < kMost;
       at.increment(error)) {
    std::error_code ignored;
    if (!at->is_regular_file(ignored)) continue;
    const fs::path name = at->path().filename();
    if (name.string().starts_with('.')) continue;
    out.push_back(name.string());
    const auto& endings = file_endings();
    if (std::find(endings.begin(), endings.end(), name.extension().string()) != endings.end())
      out.push_back(name.stem().string());
  }
  std::sort(out.begin(), out.end());
  return out;
}

namespace {
/// Finds a script. A data file of the same name is not a candidate.
fs::path find_script(const std::string& name, const fs::path& folder, const Location& named_at) {
  std::error_code ignored;
  const fs::path script = folder / (name + ".script");
  return fs::is_regular_file(script, ignored) ? script : find_file(name, folder, named_at);
}
}  // namespace

const std::vector<std::string>& file_endings() {
  static const std::vector<std::string> endings = {".points", ".data", ".script", ".txt"};
  return endings;
}

fs::path find_file(const std::string& name, const fs::path& folder, Location named_at) {
  if (name.empty() || name.find('\0') != std::string::npos || name.size() > 1000)
    throw Error(Problem{"no-file", named_at, "this is not a name of a file", {}});
  std::vector<std::string> tried = {name};
  const std::vector<std::string>& endings = file_endings();
  const bool ends =
      std::find(endings.begin(), endings.end(), fs::path(name).extension().string()) != endings.end();
  for (const std::string& ending : endings)
    if (!ends) tried.push_back(name + ending);
  for (const std::string& candidate : tried) {
    std::error_code ignored;
    if (fs::is_regular_file(folder / candidate, ignored)) return folder / candidate;
  }
  const fs::path place = (folder / name).parent_path();
  throw Error(Problem{"no-file", named_at,
                      "there is no file '" + name + "'" +
                          did_you_mean(fs::path(name).filename().string(), file_names_in(place)),
                      "looked in " + (place.empty() ? "." : place.string()) + " for " + join(tried, ", ")});
}

LoadedFiles load_files(const std::string& name, const fs::path& folder, Location named_at) {
  LoadedFiles out{ImportFile::load(find_file(name, folder, named_at).string()), {}, {}};
  const auto information = script_information(out.data.values());
  const fs::path beside = fs::path(out.data.file()).parent_path();
  const auto where = [&](const char* key) {
    const Entry* entry = out.data.values().find(key);
    return entry ? entry->where : Location{};
  };
  Problems problems;
  const Value* points = out.data.values().value("PointFile");
  if (points && points->as_text() && !points->as_text()->empty())
    collect(problems, [&] {
      out.points.push_back(
          ImportFile::load(find_file(*points->as_text(), beside, where("PointFile")).string()));
    });
  if (information)
    collect(problems,
            [&] { out.script = find_script(information->script_file, beside, where("ScriptFile")); });
  problems.throw_if_errors();
  return out;
}

}  // namespace polyarm::data
