#include "polyarm/meshes/image.hpp"

#include <cstdint>
#include <optional>
#include <system_error>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"

namespace polyarm::meshes {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kPng = "\x89PNG\r\n\x1a\n", kJpeg = "\xff\xd8\xff";
constexpr int kFoldersUp = 8;  // to look for package.xml

using Size = std::pair<std::size_t, std::size_t>;

/// Big-endian. The caller checks the length.
std::size_t big_endian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::size_t out = 0;
  for (std::size_t i = 0; i < count; ++i) out = out << 8 | static_cast<unsigned char>(bytes[at + i]);
  return out;
}

/// PNG 1.2, 11.2.2: IHDR is the first chunk.
std::optional<Size> size_of_png(std::string_view bytes) {
  if (bytes.size() < 33 || bytes.substr(12, 4) != "IHDR") return std::nullopt;
  return Size{big_endian(bytes, 16, 4), big_endian(bytes, 20, 4)};
}

/// ITU-T T.81, B.2.2: segments up to the frame header SOF0 to SOF15, without DHT, JPG and DAC.
std::optional<Size> size_of_jpeg(std::string_view bytes) {
  for (std::size_t at = 2; at + 9 < bytes.size();) {
    if (big_endian(bytes, at, 1) != 0xff) return std::nullopt;
    const std::size_t kind = big_endian(bytes, at + 1, 1);
    if (kind == 0xff) {
      ++at;  // a fill byte
      continue;
    }
    if (kind >= 0xc0 && kind <= 0xcf && kind != 0xc4 && kind != 0xc8 && kind != 0xcc)
      return Size{big_endian(bytes, at + 7, 2), big_endian(bytes, at + 5, 2)};
    at += 2 + big_endian(bytes, at + 2, 2);
  }
  return std::nullopt;
}

/// The folder whose files a mesh may use.
fs::path home_of(const fs::path& mesh) {
  std::error_code error;
  const fs::path own = fs::canonical(mesh, error).parent_path();
  fs::path folder = own;
  for (int i = 0; i < kFoldersUp && folder != folder.parent_path(); ++i, folder = folder.parent_path())
    if (fs::exists(folder / "package.xml", error)) return folder;
  return own;
}

bool lies_in(const fs::path& path, const fs::path& folder) {
  const fs::path way = path.lexically_relative(folder);
  return !way.empty() && *way.begin() != "..";
}

}  // namespace

const char* media_type(std::string_view image) {
  return image.starts_with(kPng) ? "image/png" : "image/jpeg";
}

std::string why_no_image(std::string_view bytes) {
  if (bytes.size() > kMostImageBytes) return "it is too large";
  const bool is_png = bytes.starts_with(kPng);
  if (!is_png && !bytes.starts_with(kJpeg)) return "it is neither PNG nor JPEG";
  const std::optional<Size> size = is_png ? size_of_png(bytes) : size_of_jpeg(bytes);
  if (!size || size->first == 0 || size->second == 0) return "its header is damaged";
  if (size->first > kMostImagePixels || size->second > kMostImagePixels)
    return "it has " + std::to_string(size->first) + " × " + std::to_string(size->second) +
           " pixels, of at most " + std::to_string(kMostImagePixels) + " in each direction";
  return {};
}

Image read_image(const fs::path& mesh, const std::string& name, Problems& problems) {
  const auto refuse = [&](const std::string& why) {
    problems.warning(
        "no-image", {},
        "the mesh " + mesh.string() + " is shown without its image '" + shortened(name) + "': " + why,
        "put a PNG or JPEG file there");
    return Image();
  };
  std::string local = name.starts_with("file://") ? name.substr(7) : name;
  for (char& c : local)
    if (c == '\\') c = '/';
  std::error_code error;
  const fs::path path = fs::canonical(mesh.parent_path() / local, error);
  if (error || !fs::is_regular_file(path, error)) return refuse("there is no such file");
  if (!lies_in(path, home_of(mesh))) return refuse("it is outside the folder of the mesh and its package");
  if (fs::file_size(path, error) > kMostImageBytes) return refuse("it is too large");
  try {
    std::string bytes = read_file(path, kMostImageBytes);
    if (const std::string why = why_no_image(bytes); !why.empty()) return refuse(why);
    return std::make_shared<const std::string>(std::move(bytes));
  } catch (const Error& e) {
    return refuse(e.what());
  }
}

}  // namespace polyarm::meshes
