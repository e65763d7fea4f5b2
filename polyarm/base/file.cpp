#include "polyarm/base/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "polyarm/base/error.hpp"

namespace polyarm {

std::string read_file(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    throw Error(
        Problem{"no-file", {path.string()}, "there is no such file", "check the name and the folder"});
  if (std::filesystem::is_directory(path, ignored))
    throw Error(Problem{"no-file", {path.string()}, "this is a folder, a file was expected", {}});
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  if (!in.good() && !in.eof())
    throw Error(Problem{"unreadable",
                        {path.string()},
                        "cannot be read: " + std::string(std::strerror(errno)),
                        "check its permissions"});
  return out.str();
}

namespace {
/// A name that stands for another file is followed: what it names is replaced, not the name.
std::filesystem::path followed(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_symlink(path, error)) return path;
  const auto target = std::filesystem::canonical(path, error);
  return error ? path : target;
}

/// So that the new name, too, is there after a power cut. Systems without this say so, and that is all right.
void flush_folder(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  (void)::fsync(fd);
  ::close(fd);
}
}  // namespace

void write_file_atomically(const std::filesystem::path& named, std::string_view content) {
  static std::atomic<unsigned> counter{0};
  const std::filesystem::path path = followed(named);
  struct stat before {};
  const mode_t mode = ::stat(path.c_str(), &before) == 0 ? before.st_mode & 07777 : 0;
  const std::filesystem::path temporary =
      path.parent_path() / ("." + path.filename().string() + ".tmp" + std::to_string(::getpid()) + "." +
                            std::to_string(counter++));
  const auto fail = [&](const char* action) {
    const std::string reason = std::strerror(errno);
    ::unlink(temporary.c_str());
    throw Error(Problem{"unwritable",
                        {path.string()},
                        std::string("cannot ") + action + ": " + reason,
                        "the file is as it was; check permissions and free space"});
  };
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (fd < 0) fail("create a file beside it");
  if (mode != 0) (void)::fchmod(fd, mode);
  for (std::size_t done = 0; done < content.size();) {
    const ssize_t n = ::write(fd, content.data() + done, content.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int error = errno;
      ::close(fd);
      errno = error;
      fail("write it");
    }
    done += static_cast<std::size_t>(n);
  }
  const bool flushed = ::fsync(fd) == 0;
  if (::close(fd) != 0 || !flushed) fail("flush it to disk");
  if (::rename(temporary.c_str(), path.c_str()) != 0) fail("replace it");
  flush_folder(path);
}

}  // namespace polyarm
