#include "polyarm/server/assets.hpp"

#include <deque>
#include <filesystem>

#include "polyarm/base/file.hpp"

namespace polyarm::server {

std::map<std::string, Asset> page_in(const std::string& folder) {
  static std::deque<std::string> kept;  // views stay good for as long as the process lives
  std::map<std::string, Asset> out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    kept.push_back(read_file(entry.path()));
    out["/" + std::filesystem::relative(entry.path(), folder).generic_string()] = {kept.back(), false};
  }
  return out;
}

const char* media_type(std::string_view path) {
  constexpr std::pair<std::string_view, const char*> kTypes[] = {
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".webp", "image/webp"},
      {".ico", "image/x-icon"},
      {".woff2", "font/woff2"},
      {".wasm", "application/wasm"},
      {".webmanifest", "application/manifest+json"},
      {".txt", "text/plain; charset=utf-8"}};
  for (const auto& [ending, type] : kTypes)
    if (path.ends_with(ending)) return type;
  return "application/octet-stream";
}

}  // namespace polyarm::server
