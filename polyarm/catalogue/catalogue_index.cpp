#include "polyarm/catalogue/catalogue_index.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <charconv>
#include <cstdint>
#include <string_view>
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

/// Size, number and times of a file; empty if it does not exist. The time of its last change of any kind is
/// among them, because a copy may keep the time of the content.
std::string state_of(const fs::path& file) {
  struct stat now {};
  if (::stat(file.c_str(), &now) != 0) return {};
  return fmt::format("{}.{}.{}.{}.{}.{}", static_cast<std::int64_t>(now.st_size),
                     static_cast<std::uint64_t>(now.st_ino), static_cast<std::int64_t>(now.st_mtim.tv_sec),
                     now.st_mtim.tv_nsec, static_cast<std::int64_t>(now.st_ctim.tv_sec), now.st_ctim.tv_nsec);
}

/// FNV-1a, 64 bits.
std::uint64_t checksum(std::string_view text) {
  std::uint64_t out = 14695981039346656037u;
  for (const char c : text) out = (out ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return out;
}

/// An index belongs to the build that made it; the next build may read files differently. The checksum is that
/// of all other lines.
std::string first_line(std::string_view lines) {
  return fmt::format("polyarm: catalogue-index/2 {} {:016x}", state_of("/proc/self/exe"), checksum(lines));
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
    const std::string text = read_file(file_, kLargestIndex);
    const std::size_t end = text.find('\n');
    if (end == std::string::npos) return;
    const std::string_view body = std::string_view(text).substr(end + 1);
    if (text.substr(0, end) != first_line(body)) return;
    for (const std::string& line : split_fields(body, '\n'))
      lines_.emplace(line.substr(0, line.find(kBetween)), line);
  } catch (const Error&) {  // it is rebuilt
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
  std::string lines;
  for (const auto& [path, line] : used_) lines += line + "\n";
  const std::string text = first_line(lines) + "\n" + lines;
  std::error_code error;
  fs::create_directories(file_.parent_path(), error);
  // A link would lead out of the cache folder.
  if (error || text.size() > kLargestIndex || fs::is_symlink(fs::symlink_status(file_, error))) return;
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
