#include "polyarm/server/assets.hpp"

#include <zlib.h>

#include <deque>
#include <filesystem>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm::server {

std::map<std::string, Asset> page_in(const std::string& folder) {
  static std::deque<std::string> kept;  // never freed: the assets are views into these texts
  std::map<std::string, Asset> out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const AsUser user;
    kept.push_back(read_file(entry.path()));
    out["/" + std::filesystem::relative(entry.path(), folder).generic_string()] = {kept.back(), false};
  }
  return out;
}

std::string unzipped(std::string_view gzip) {
  constexpr std::size_t kMost = 64 << 20, kPart = 64 << 10;
  constexpr int kGzipAlone = 16 + MAX_WBITS;
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(gzip.data()));
  stream.avail_in = static_cast<uInt>(gzip.size());
  if (::inflateInit2(&stream, kGzipAlone) != Z_OK) throw Error("bad-gzip", "a file cannot be decompressed");
  std::string out;
  int result = Z_OK;
  while (result == Z_OK && out.size() < kMost) {
    out.resize(out.size() + kPart);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + out.size() - kPart);
    stream.avail_out = kPart;
    result = ::inflate(&stream, Z_NO_FLUSH);
    out.resize(out.size() - stream.avail_out);
    if (stream.avail_out > 0 && result == Z_OK) break;  // the input ends too early
  }
  ::inflateEnd(&stream);
  if (result != Z_STREAM_END) throw Error("bad-gzip", "a file cannot be decompressed");
  return out;
}

std::string zipped(std::string_view bytes) {
  constexpr int kGzip = 16 + MAX_WBITS, kMemory = 9;
  z_stream stream{};
  const auto failed = [] { return Error("bad-gzip", "bytes cannot be compressed"); };
  if (::deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw failed();
  std::string out(::deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int result = ::deflate(&stream, Z_FINISH);
  out.resize(out.size() - stream.avail_out);
  ::deflateEnd(&stream);
  if (result != Z_STREAM_END) throw failed();
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
