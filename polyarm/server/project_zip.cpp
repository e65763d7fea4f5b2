#include "polyarm/server/project_zip.hpp"

#include <zip.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <set>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/secrets.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::server {

namespace fs = std::filesystem;

namespace {

struct Discard {
  void operator()(zip_t* zip) const { zip_discard(zip); }
};
struct Release {
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using Zip = std::unique_ptr<zip_t, Discard>;
using Source = std::unique_ptr<zip_source_t, Release>;

Error failure(const std::string& what, zip_error_t& error) {
  std::string why = zip_error_strerror(&error);
  zip_error_fini(&error);
  return Error("bad-zip", what + ": " + why);
}

Zip open(zip_source_t* source, int flags) {
  zip_error_t error;
  zip_error_init(&error);
  Zip out(zip_open_from_source(source, flags, &error));
  if (!out) throw failure("the zip cannot be opened", error);
  return out;
}

Source buffer(const void* data, std::size_t size) {
  zip_error_t error;
  zip_error_init(&error);
  Source out(zip_source_buffer_create(data, size, 0, &error));
  if (!out) throw failure("there is no room for the zip", error);
  return out;
}

std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  fs::recursive_directory_iterator each(folder, fs::directory_options::skip_permission_denied, error), end;
  std::uintmax_t bytes = 0;
  for (; !error && each != end; each.increment(error)) {
    if (each->path().filename().string().starts_with('.')) {
      if (each->is_directory(error)) each.disable_recursion_pending();
      continue;
    }
    if (each->is_symlink(error) || !each->is_regular_file(error) || is_secret(each->path())) continue;
    bytes += each->file_size(error);
    out.push_back(each->path());
    if (bytes > kMostUnzipped || out.size() > kMostZippedFiles)
      throw Error("too-large", "the project " + folder.string() + " is too large for one zip",
                  "256 MB and 5000 files at most");
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// Path of an entry inside the folder. Throws if the name is hidden or leads out of it.
fs::path place_of(const std::string& name) {
  const fs::path path(name);
  const auto refuse = [&] {
    return Error(
        "bad-zip",
        "the zip has the file '" + shortened(printable_line(name)) + "', which cannot belong to a project",
        "names are plain text and stay within the folder");
  };
  if (name.empty() || name.find('\\') != std::string::npos || path.is_absolute() || name.size() > 400 ||
      printable_line(name) != name)
    throw refuse();
  for (const fs::path& part : path)
    if (part.string().starts_with('.') || part.empty()) throw refuse();
  return path;
}

/// A project must not bring native code onto a machine; a person installs that.
void refuse_native(const std::string& name, std::string_view text) {
  const std::string file = lower(fs::path(name).filename().string());
  const bool named = file.ends_with(".so") || file.find(".so.") != std::string::npos ||
                     file.ends_with(".dll") || file.ends_with(".dylib") || file.ends_with(".exe");
  const bool made = text.starts_with(
                        "\x7f"
                        "ELF") ||
                    text.starts_with("!<arch>\n") || text.starts_with("\xfe\xed\xfa") ||
                    text.starts_with("\xcf\xfa\xed\xfe") || text.starts_with("\xca\xfe\xba\xbe");
  if (named || made)
    throw Error("native-code", "the zip brings native code, '" + name + "', which is not taken from a zip",
                "build plugins on the machine itself, and approve them there: polyarm plugins approve");
}

Error too_many_files() {
  return Error("bad-zip", "the zip has too many files", std::to_string(kMostZippedFiles) + " at most");
}

/// Checks the count in the zip's end record before libzip loads the list of files: a zip of 64 MB may list a
/// million.
void require_few(std::string_view bytes) {
  constexpr std::size_t kEnd = 22, kLongestNote = 65535, kLarge = 20;
  const std::size_t from = bytes.size() - std::min(bytes.size(), kEnd + kLongestNote);
  for (std::size_t at = bytes.find("PK\5\6", from); at != std::string_view::npos && at + kEnd <= bytes.size();
       at = bytes.find("PK\5\6", at + 1)) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[at + i]); };
    const bool large = at >= kLarge && bytes.substr(at - kLarge, 4) == "PK\6\7";  // its counts have 64 bits
    if (large || byte(10) + 256u * byte(11) > kMostZippedFiles)
      throw too_many_files();
  }
}

/// Refuses links, devices, pipes and encrypted files.
void require_plain(zip_t* zip, zip_uint64_t index, const std::string& name) {
  constexpr zip_uint32_t kKind = 0170000, kFile = 0100000;
  zip_uint8_t system = 0;
  zip_uint32_t attributes = 0;
  zip_stat_t stat;
  const bool known = zip_file_get_external_attributes(zip, index, 0, &system, &attributes) == 0 &&
                     zip_stat_index(zip, index, 0, &stat) == 0;
  const zip_uint32_t kind = system == ZIP_OPSYS_UNIX ? (attributes >> 16) & kKind : 0;
  if (!known || (kind != 0 && kind != kFile))
    throw Error("bad-zip", "'" + name + "' of the zip is not an ordinary file",
                "pack files and folders alone");
  if ((stat.valid & ZIP_STAT_ENCRYPTION_METHOD) && stat.encryption_method != ZIP_EM_NONE)
    throw Error("bad-zip", "'" + name + "' of the zip is encrypted", "pack the project without a password");
  // Only Deflate, which every zip program writes, is accepted: libzip would use other libraries for the rest.
  if (!(stat.valid & ZIP_STAT_COMP_METHOD) ||
      (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE))
    throw Error("bad-zip", "'" + name + "' of the zip is packed in another way than zip programs do by default",
                "pack it again, by Deflate or without compression");
  if ((stat.valid & ZIP_STAT_SIZE) && stat.size > kMostUnzipped)
    throw Error("bad-zip", "the zip has more than 256 MB in it");
}

std::string content(zip_t* zip, zip_uint64_t index, const std::string& name, std::size_t most) {
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen_index(zip, index, 0), zip_fclose);
  if (!file) throw Error("bad-zip", "'" + name + "' of the zip cannot be read: " + zip_strerror(zip));
  std::string out;
  char part[65536];
  for (;;) {
    const zip_int64_t n = zip_fread(file.get(), part, sizeof part);
    if (n < 0) throw Error("bad-zip", "'" + name + "' of the zip is damaged");
    if (n == 0) return out;
    out.append(part, static_cast<std::size_t>(n));
    if (out.size() > most) throw Error("bad-zip", "the zip has more than 256 MB in it");
  }
}

void write(const fs::path& file, const std::string& text, const std::string& name) {
  try {
    write_file_atomically(file, text);
  } catch (const Error& e) {
    throw Error("bad-zip",
                "'" + shortened(name) + "' of the zip cannot be written: " + e.problems().front().what,
                "use short names");
  }
}

}  // namespace

fs::path place_beside(const fs::path& folder, const std::string& name) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(fs::absolute(folder), error);  // "." has no parent, "a/" is "a"
  const fs::path beside = (whole.has_filename() ? whole : whole.parent_path()).parent_path();
  std::size_t folders = 0;
  for (const auto& each : fs::directory_iterator(beside, error)) folders += each.is_directory(error) ? 1 : 0;
  if (folders >= bounds::kProjects)
    throw Error("too-many", "there are " + std::to_string(folders) + " folders beside that of the cell",
                "delete projects that nobody needs");
  return beside / name;
}

std::string zip_of(const fs::path& folder) {
  Source target = buffer(nullptr, 0);
  Zip zip = open(target.get(), ZIP_TRUNCATE);
  zip_source_keep(target.get());  // a second reference, because the zip has taken the first
  std::vector<std::string> contents;
  const std::vector<fs::path> files = files_of(folder);
  contents.reserve(files.size());
  for (const fs::path& file : files) {
    contents.push_back(read_file(file));
    zip_source_t* const source =
        zip_source_buffer(zip.get(), contents.back().data(), contents.back().size(), 0);
    const std::string name = file.lexically_relative(folder).generic_string();
    if (!source || zip_file_add(zip.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8) < 0) {
      zip_source_free(source);
      throw Error("bad-zip", "'" + name + "' cannot be packed: " + zip_strerror(zip.get()));
    }
  }
  if (zip_close(zip.get()) < 0)
    throw Error("bad-zip", std::string("the project cannot be packed: ") + zip_strerror(zip.get()));
  (void)zip.release();
  zip_stat_t stat;
  if (zip_source_stat(target.get(), &stat) < 0 || zip_source_open(target.get()) < 0)
    throw Error("bad-zip", "the packed project cannot be read");
  std::string out(stat.size, '\0');
  const zip_int64_t n = zip_source_read(target.get(), out.data(), out.size());
  zip_source_close(target.get());
  if (n != static_cast<zip_int64_t>(out.size())) throw Error("bad-zip", "the packed project cannot be read");
  return out;
}

void unzip_into(std::string_view bytes, const fs::path& folder) {
  const AsUser user;
  std::error_code error;
  if (fs::exists(folder, error))
    throw Error("exists", "there is a folder '" + folder.string() + "' already", "give another name");
  require_few(bytes);
  Source source = buffer(bytes.data(), bytes.size());
  const Zip zip = open(source.get(), ZIP_RDONLY);
  (void)source.release();  // owned by the zip now
  const zip_int64_t count = zip_get_num_entries(zip.get(), 0);
  if (count < 0 || static_cast<std::size_t>(count) > kMostZippedFiles)
    throw too_many_files();
  const fs::path coming = folder.parent_path() / ("." + folder.filename().string() + ".coming");
  fs::remove_all(coming, error);
  fs::create_directories(coming);
  try {
    std::size_t left = kMostUnzipped;
    std::set<fs::path> seen;
    for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(count); ++i) {
      const char* const raw = zip_get_name(zip.get(), i, 0);
      const std::string name = raw ? raw : "";
      if (name.ends_with('/')) continue;
      const fs::path file = coming / place_of(name);
      if (!seen.insert(file).second)
        throw Error("bad-zip", "the zip has the file '" + name + "' twice", "pack each file once");
      require_plain(zip.get(), i, name);
      const std::string text = content(zip.get(), i, name, left);
      left -= text.size();
      refuse_native(name, text);
      fs::create_directories(file.parent_path(), error);
      if (error)
        throw Error("bad-zip", "the zip has '" + name + "', which cannot be created: " + error.message(),
                    "use short names, and no name for a file and a folder");
      if (fs::exists(
              fs::symlink_status(file, error)))  // also where a file system ignores upper and lower case
        throw Error("bad-zip",
                    "the zip has '" + shortened(name) + "' twice, in another spelling or as a folder",
                    "use names that differ in more than upper and lower case");
      write(file, text, name);
    }
    if (!fs::exists(coming / "cell.yaml", error))
      throw Error("bad-zip", "the zip has no cell.yaml: it is not a project");
    fs::rename(coming, folder);
  } catch (...) {
    fs::remove_all(coming, error);
    rethrow_as_error("bad-zip", "unpacking the project");
  }
}

}  // namespace polyarm::server
