#include "polyarm/catalogue/catalogue_index.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <charconv>
#include <cstdint>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;

namespace {
constexpr std::size_t kLargestIndex = std::size_t{4} << 20;
constexpr char kBetween = '\t';
constexpr const char* kEstimated = "estimated";
/// path, state of the file, name, maker, model, axes, reach, payload, mass, estimated
constexpr std::size_t kFields = 10;

/// Size and time of a file; empty if it does not exist.
std::string state_of(const fs::path& file) {
  struct stat now {};
  if (::stat(file.c_str(), &now) != 0) return {};
  return fmt::format("{}.{}.{}.{}", static_cast<std::int64_t>(now.st_size), static_cast<std::uint64_t>(now.st_ino),
                     static_cast<std::int64_t>(now.st_mtim.tv_sec), now.st_mtim.tv_nsec);
}

/// The index belongs to the build that made it, because the next build may read files differently.
std::string first_line() {
  return "polyarm: catalogue-index/1 " + state_of("/proc/self/exe");
}

std::string text_of(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}

bool read(const std::string& text, std::optional<double>& out) {
  if (text.empty()) return true;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  out = value;
  return error == std::errc{} && end == text.data() + text.size();
}

std::string line_of(const CatalogueEntry& entry, const std::string& state) {
  const std::array<std::string, kFields> fields{entry.file.string(), state, entry.name, entry.maker, entry.model,
                                                std::to_string(entry.axes), text_of(entry.reach_m),
                                                text_of(entry.payload_kg), text_of(entry.mass_kg),
                                                entry.mass_estimated ? kEstimated : "stated"};
  std::string out;
  for (const std::string& field : fields) {
    if (field.find_first_of("\t\n\r") != std::string::npos) return {};  // the index cannot store this field,
                                                                        // so the robot's file is read every
                                                                        // time
    if (!out.empty()) out += kBetween;
    out += field;
  }
  return out;
}

std::optional<CatalogueEntry> entry_of(const std::string& line) {
  const std::vector<std::string> fields = split_fields(line, kBetween);
  if (fields.size() != kFields) return std::nullopt;
  CatalogueEntry out;
  out.file = fields[0];
  out.name = fields[2];
  out.maker = fields[3];
  out.model = fields[4];
  const std::string& axes = fields[5];
  const bool good = std::from_chars(axes.data(), axes.data() + axes.size(), out.axes).ec == std::errc{} &&
                    read(fields[6], out.reach_m) && read(fields[7], out.payload_kg) && read(fields[8], out.mass_kg);
  out.mass_estimated = fields[9] == kEstimated;
  return good ? std::optional(std::move(out)) : std::nullopt;
}
}  // namespace

CatalogueIndex::CatalogueIndex(fs::path file) : file_{std::move(file)} {
  if (file_.empty()) return;
  try {
    const AsUser as_user;
    const std::vector<std::string> lines = split_fields(read_file(file_, kLargestIndex), '\n');
    if (lines.empty() || lines.front() != first_line()) return;
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines_.emplace(lines[i].substr(0, lines[i].find(kBetween)), lines[i]);
  } catch (const Error&) {  // the index is rebuilt
    lines_.clear();
  }
}

std::optional<CatalogueEntry> CatalogueIndex::find(const fs::path& robot) {
  const auto at = lines_.find(robot.native());
  if (at == lines_.end()) return std::nullopt;
  const std::string& line = at->second;
  const std::size_t begin = line.find(kBetween) + 1;
  if (line.substr(begin, line.find(kBetween, begin) - begin) != state_of(robot)) return std::nullopt;
  auto out = entry_of(line);
  if (out) used_.insert(*at);
  return out;
}

void CatalogueIndex::add(const CatalogueEntry& entry) {
  const std::string line = line_of(entry, state_of(entry.file));
  if (!line.empty()) used_.insert_or_assign(entry.file.string(), line);
  added_ = true;
}

void CatalogueIndex::save() const {
  if (file_.empty() || !added_) return;
  std::string text = first_line() + "\n";
  for (const auto& [path, line] : used_) text += line + "\n";
  std::error_code error;
  fs::create_directories(file_.parent_path(), error);
  if (error || text.size() > kLargestIndex) return;
  try {
    const AsUser as_user;
    write_file_atomically(file_, text, 0600);
  } catch (const Error&) {  // the next run reads the files again
  }
}

fs::path catalogue_index_file() {
  const fs::path folder = cache_folder();
  return folder.empty() ? folder : folder / "catalogue";
}

}  // namespace polyarm::description
