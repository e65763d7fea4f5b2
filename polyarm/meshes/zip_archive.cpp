#include "polyarm/meshes/zip_archive.hpp"

#include <zlib.h>

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/base/printable.hpp"

namespace polyarm::meshes {

namespace {

constexpr std::size_t kEndSize = 22, kLongestComment = 65535, kEntrySize = 46, kHeaderSize = 30, kMostEntries = 10'000;
constexpr std::size_t kEndSign = 0x06054b50, kEntrySign = 0x02014b50, kHeaderSign = 0x04034b50;
constexpr unsigned kStored = 0, kDeflated = 8, kEncrypted = 1;

/// Exactly `size` bytes, or an empty text.
std::string inflated(const char* from, std::size_t packed, std::size_t size) {
  std::string out(size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(from));
  stream.avail_in = static_cast<uInt>(packed);
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(size);
  const int result = inflate(&stream, Z_FINISH);
  const bool whole = result == Z_STREAM_END && stream.total_out == size;
  inflateEnd(&stream);
  return whole ? out : std::string();
}

}  // namespace

void ZipArchive::refuse(const std::string& why) const {
  throw Error("bad-mesh", "the mesh " + name_ + " is not a whole archive: " + why, "export it again");
}

/// Little-endian.
std::size_t ZipArchive::number(std::size_t at, std::size_t count) const {
  if (at > bytes_.size() || bytes_.size() - at < count) refuse("it ends too early");
  std::size_t out = 0;
  for (std::size_t i = count; i-- > 0;) out = out << 8 | static_cast<unsigned char>(bytes_[at + i]);
  return out;
}

/// Where the end record of the central directory begins. A comment may follow it.
std::size_t ZipArchive::directory() const {
  if (bytes_.size() < kEndSize) refuse("it is too short");
  const std::size_t last = bytes_.size() - kEndSize;
  for (std::size_t back = 0; back <= std::min(last, kLongestComment); ++back)
    if (number(last - back, 4) == kEndSign) return last - back;
  refuse("it has no list of files");
}

ZipArchive::ZipArchive(const std::string& bytes, std::string name, std::size_t most)
    : bytes_(bytes), name_(std::move(name)), left_(most) {
  const std::size_t end = directory(), count = number(end + 10, 2);
  std::size_t at = number(end + 16, 4);
  if (count > kMostEntries) refuse("it has more than 10,000 files");
  if (at == 0xffffffff) refuse("it is of the kind ZIP64");
  for (std::size_t i = 0; i < count; ++i) {
    if (number(at, 4) != kEntrySign) refuse("its list of files is damaged");
    const std::size_t length = number(at + 28, 2);
    if (bytes_.size() - at < kEntrySize + length) refuse("it ends too early");
    Entry entry;
    entry.flags = static_cast<unsigned>(number(at + 8, 2));
    entry.method = static_cast<unsigned>(number(at + 10, 2));
    entry.checksum = static_cast<unsigned>(number(at + 16, 4));
    entry.packed = number(at + 20, 4);
    entry.size = number(at + 24, 4);
    entry.header = number(at + 42, 4);
    entries_.emplace(bytes_.substr(at + kEntrySize, length), entry);
    at += kEntrySize + length + number(at + 30, 2) + number(at + 32, 2);
  }
}

std::string ZipArchive::read(const std::string& file) {
  const auto found = entries_.find(file);
  if (found == entries_.end()) refuse("there is no '" + shortened(file) + "' in it");
  const Entry& entry = found->second;
  if (entry.flags & kEncrypted) refuse("'" + shortened(file) + "' is encrypted");
  if (entry.method != kStored && entry.method != kDeflated)
    refuse("'" + shortened(file) + "' is compressed in another way than deflate");
  if (entry.size > left_)
    throw Error("large-mesh", "the mesh " + name_ + " is too large when it is unpacked",
                "simplify it: some thousand triangles are enough to draw it");
  left_ -= entry.size;
  if (number(entry.header, 4) != kHeaderSign) refuse("'" + shortened(file) + "' is damaged");
  const std::size_t at = entry.header + kHeaderSize + number(entry.header + 26, 2) + number(entry.header + 28, 2);
  if (at > bytes_.size() || entry.packed > bytes_.size() - at) refuse("it ends too early");
  const std::string out = entry.method == kStored ? bytes_.substr(at, entry.packed)
                                                  : inflated(bytes_.data() + at, entry.packed, entry.size);
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(out.data()), static_cast<uInt>(out.size()));
  if (out.size() != entry.size || sum != entry.checksum) refuse("'" + shortened(file) + "' is damaged");
  return out;
}

}  // namespace polyarm::meshes
