#include "polyarm/recording/attachments.hpp"

#include <algorithm>
#include <map>
#include <system_error>

#include "polyarm/base/bounds.hpp"

namespace polyarm::recording {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kLargest = bounds::kAttachmentBytes, kMost = bounds::kAttachmentsBytes;

bool belongs(const fs::path& path) {
  const std::string name = path.filename().string();
  return !name.starts_with('.') && path.extension() != ".mcap";
}

}  // namespace

std::string media_type_of(const std::string& name) {
  static const std::map<std::string, std::string> types = {
      {".yaml", "application/yaml"}, {".yml", "application/yaml"}, {".urdf", "application/xml"},
      {".xacro", "application/xml"}, {".srdf", "application/xml"}, {".json", "application/json"}};
  const auto at = types.find(fs::path(name).extension().string());
  return at == types.end() ? "text/plain" : at->second;
}

std::vector<AttachedFile> files_of(const cell::CellFile& file) {
  std::map<std::string, fs::path> found;
  std::error_code error;
  const std::string kind = file.path.extension().string();
  if (kind == ".yaml" || kind == ".yml")
    for (const auto& entry : fs::directory_iterator(file.folder, error))
      if (entry.is_regular_file(error) && belongs(entry.path()))
        found[entry.path().filename().string()] = entry.path();
  const auto name = [&](const fs::path& given) {
    const fs::path path = given.is_absolute() ? given : file.folder / given;
    if (fs::is_regular_file(path, error)) found.emplace(given.filename().string(), path);
  };
  for (const std::string& each : {file.program, file.plc, file.scene, file.signals})
    if (!each.empty()) name(each);
  for (const std::string& each : file.controllers) name(each);
  if (fs::is_regular_file(file.path, error)) found.emplace(file.path.filename().string(), file.path);
  std::vector<AttachedFile> out;
  std::uintmax_t all = 0;
  for (const auto& [called, path] : found) {
    const std::uintmax_t size = fs::file_size(path, error);
    if (error || size > kLargest || all + size > kMost) continue;
    all += size;
    out.push_back({called, path});
  }
  return out;
}

}  // namespace polyarm::recording
