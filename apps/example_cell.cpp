#include "apps/example_cell.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "polyarm/base/error.hpp"
#include "polyarm/base/installation.hpp"
#include "polyarm/cell/known_cells.hpp"

namespace polyarm::apps {

namespace fs = std::filesystem;

namespace {
/// Copies into a folder beside `to` first, so that a copy that was cut off is never taken for a cell.
void copy_whole(const fs::path& from, const fs::path& to) {
  std::error_code error;
  const fs::path part = to.string() + ".part" + std::to_string(::getpid());
  fs::create_directories(to.parent_path(), error);
  fs::copy(from, part, fs::copy_options::recursive, error);
  if (!error) fs::rename(part, to, error);
  if (!error) return;
  const std::string why = error.message();
  fs::remove_all(part, error);
  throw Error("unwritable", from.string() + " cannot be copied to " + to.string() + ": " + why,
              "copy it yourself and name the copy: cp -r " + from.string() + " FOLDER");
}
}  // namespace

std::optional<fs::path> own_copy_of_example(const std::string& name) {
  constexpr std::string_view kFolder = "examples/";
  const fs::path wanted = name.starts_with(kFolder) ? name.substr(kFolder.size()) : name;
  if (wanted.empty() || wanted.has_parent_path() || wanted == "." || wanted == "..") return std::nullopt;
  std::error_code error;
  for (const fs::path& folder : installation::data_folders("examples", "pick_and_place")) {
    if (!fs::exists(folder / wanted / "cell.yaml", error)) continue;
    fs::path own = cell::projects_folder() / wanted;
    if (!fs::exists(own, error)) {
      copy_whole(folder / wanted, own);
      fmt::print(stderr, "the example {} is now a cell of yours: {}\n", wanted.string(), own.string());
    }
    return own;
  }
  return std::nullopt;
}

}  // namespace polyarm::apps
