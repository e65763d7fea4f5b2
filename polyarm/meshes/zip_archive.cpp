#include "polyarm/meshes/zip_archive.hpp"

#include <zip.h>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/printable.hpp"

namespace polyarm::meshes {

namespace {

constexpr zip_int64_t kMostEntries = bounds::kArchiveFiles;

struct Close {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

/// -1: it is not there.
zip_int64_t place_of(zip_t* archive, const std::string& file) {
  return zip_name_locate(archive, file.c_str(), ZIP_FL_ENC_RAW);
}

}  // namespace

void ZipArchive::Discard::operator()(zip* archive) const {
  zip_discard(archive);
}

void ZipArchive::refuse(const std::string& why) const {
  throw Error("bad-mesh", "the mesh " + name_ + " is not a whole archive: " + why, "export it again");
}

ZipArchive::ZipArchive(const std::string& bytes, std::string name, std::size_t most)
    : name_(std::move(name)), left_(most) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  zip_.reset(source ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr);
  const std::string why = zip_error_strerror(&error);
  zip_error_fini(&error);
  if (!zip_) {
    zip_source_free(source);
    refuse(why);
  }
  if (zip_get_num_entries(zip_.get(), 0) > kMostEntries) refuse("it has more than 10,000 files");
}

bool ZipArchive::has(const std::string& file) const {
  return place_of(zip_.get(), file) >= 0;
}

std::string ZipArchive::read(const std::string& file) {
  const zip_int64_t at = place_of(zip_.get(), file);
  if (at < 0) refuse("there is no '" + shortened(file) + "' in it");
  const auto damaged = [&] { refuse("'" + shortened(file) + "' is damaged"); };
  zip_stat_t facts;
  constexpr zip_uint64_t kSize = ZIP_STAT_SIZE | ZIP_STAT_ENCRYPTION_METHOD;
  if (zip_stat_index(zip_.get(), static_cast<zip_uint64_t>(at), 0, &facts) != 0 ||
      (facts.valid & kSize) != kSize)
    damaged();
  if (facts.encryption_method != ZIP_EM_NONE) refuse("'" + shortened(file) + "' is encrypted");
  if (facts.size > left_)
    throw Error("large-mesh", "the mesh " + name_ + " is too large when it is unpacked",
                "simplify it: some thousand triangles are enough to draw it");
  left_ -= facts.size;
  const std::unique_ptr<zip_file_t, Close> opened(
      zip_fopen_index(zip_.get(), static_cast<zip_uint64_t>(at), 0));
  if (!opened) refuse("'" + shortened(file) + "' cannot be unpacked: " + zip_strerror(zip_.get()));
  std::string out(facts.size, '\0');
  std::size_t done = 0;
  while (done < out.size()) {
    const zip_int64_t n = zip_fread(opened.get(), out.data() + done, out.size() - done);
    if (n <= 0) damaged();
    done += static_cast<std::size_t>(n);
  }
  char more;  // its checksum is compared at the end
  if (zip_fread(opened.get(), &more, 1) != 0) damaged();
  return out;
}

}  // namespace polyarm::meshes
