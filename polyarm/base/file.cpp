#include "polyarm/base/file.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm {

namespace {
namespace fs = std::filesystem;

/// Closed when it goes.
struct Open {
  int fd = -1;
  ~Open() {
    if (fd >= 0) ::close(fd);
  }
};

/// Where the open file is, links resolved; what a name says may have changed since.
fs::path place_of(int fd, const fs::path& named) {
  std::error_code error;
  const fs::path out = fs::read_symlink("/proc/self/fd/" + std::to_string(fd), error);
  return error || !out.is_absolute() ? resolved(named) : out;
}

const char* kind_of(mode_t mode) {
  return S_ISFIFO(mode)                   ? "a pipe"
         : S_ISSOCK(mode)                 ? "a socket"
         : S_ISCHR(mode) || S_ISBLK(mode) ? "a device"
                                          : "not an ordinary file";
}

[[noreturn]] void refuse(const char* code, const fs::path& path, std::string what, std::string advice) {
  throw Error(Problem{code, {path.string()}, std::move(what), std::move(advice)});
}

/// Throws unless it is an ordinary file, before anything waits for it.
void require_regular(const fs::path& path, const struct stat& status) {
  if (S_ISDIR(status.st_mode)) refuse("no-file", path, "this is a folder, a file was expected", {});
  if (!S_ISREG(status.st_mode))
    refuse("not-a-file", path, std::string("this is ") + kind_of(status.st_mode) + ", a file was expected",
           "name an ordinary file");
}
}  // namespace

std::string read_file(const std::filesystem::path& path, std::size_t most) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) require_regular(path, status);  // a device is not even opened
  const Open file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)};
  if (file.fd < 0 && (errno == ENOENT || errno == ENOTDIR))
    refuse("no-file", path, "there is no such file", "check the name and the folder");
  const auto unreadable = [&] {
    refuse("unreadable", path, "cannot be read: " + std::string(std::strerror(errno)),
           errno == EMFILE || errno == ENFILE
               ? "close what is not needed, or allow more open files: ulimit -n"
               : "check its permissions");
  };
  if (file.fd < 0 || ::fstat(file.fd, &status) != 0) unreadable();
  require_regular(path, status);
  if (reach().confined()) reach().check(path, place_of(file.fd, path), Reach::Use::read);
  const auto too_large = [&] {
    refuse("too-large", path, "the file has more than " + std::to_string(most) + " bytes",
           "more is not read");
  };
  if (static_cast<std::uintmax_t>(status.st_size) > most) too_large();
  std::string out(static_cast<std::size_t>(status.st_size), '\0');
  for (std::size_t done = 0;;) {  // it may grow meanwhile, and files of /proc say that they are empty
    if (done == out.size()) out.resize(done + 4096);
    const ssize_t n = ::read(file.fd, out.data() + done, out.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) unreadable();
    done += static_cast<std::size_t>(n);
    if (done > most) too_large();
    if (n != 0) continue;
    out.resize(done);
    return out;
  }
}

namespace {
/// A name that stands for another file is followed: what it names is replaced, not the name.
std::filesystem::path followed(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_symlink(path, error)) return path;
  const auto target = std::filesystem::canonical(path, error);
  return error ? path : target;
}

/// What was tried, why the system refused it, and what would let it through.
Problem unwritable(const std::filesystem::path& path, const std::string& action, int error) {
  const std::string folder = path.has_parent_path() ? path.parent_path().string() : ".";
  std::error_code ignored;
  std::string advice = "check permissions and free space";
  if (error == EACCES || error == EPERM)
    advice = "you may not write in the folder " + folder +
             ": ls -ld shows the owner; work on a copy, or change the permissions";
  else if (error == EROFS)
    advice = "the folder " + folder + " is on a file system that is read-only; work on a copy elsewhere";
  else if (error == ENOENT || error == ENOTDIR)
    advice = "there is no folder " + folder + "; make it first";
  else if (error == ENOSPC || error == EDQUOT)
    advice = "the disk is full: make room there";
  const bool there = std::filesystem::exists(path, ignored);
  return {"unwritable",
          {path.string()},
          "cannot " + action + ": " + std::strerror(error),
          advice + (there ? "; the file is as it was" : "")};
}

/// So that the new name, too, is there after a power cut. Systems without this say so, and that is all right.
void flush_folder(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  (void)::fsync(fd);
  ::close(fd);
}

/// The process that wrote a temporary file: of ".NAME.tmpPID.COUNT".
std::optional<pid_t> writer_of(const std::string& name) {
  const auto at = name.rfind(".tmp");
  if (!name.starts_with('.') || at == std::string::npos || at < 1) return std::nullopt;
  const char* const end = name.data() + name.size();
  pid_t pid = 0;
  const auto number = std::from_chars(name.data() + at + 4, end, pid);
  if (number.ec != std::errc() || pid <= 0 || number.ptr == end || *number.ptr != '.') return std::nullopt;
  unsigned count = 0;
  const auto rest = std::from_chars(number.ptr + 1, end, count);
  return rest.ec == std::errc() && rest.ptr == end ? std::optional(pid) : std::nullopt;
}
}  // namespace

void write_file_atomically(const std::filesystem::path& named, std::string_view content, unsigned mode) {
  static std::atomic<unsigned> counter{0};
  const std::filesystem::path path = followed(named);
  if (reach().confined()) reach().check(path, Reach::Use::write);
  struct stat before {};
  const bool there = ::stat(path.c_str(), &before) == 0;
  if (there) require_regular(path, before);
  const std::filesystem::path temporary =
      path.parent_path() / ("." + path.filename().string() + ".tmp" + std::to_string(::getpid()) + "." +
                            std::to_string(counter++));
  const auto fail = [&](const char* action) {
    const int error = errno;
    ::unlink(temporary.c_str());
    throw Error(unwritable(path, action, error));
  };
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (fd < 0) fail("create a file beside it");
  if (there) (void)::fchmod(fd, before.st_mode & 07777);
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

void sweep_temporaries(const std::filesystem::path& folder) {
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const auto writer = writer_of(at->path().filename().string());
    std::error_code ignored;
    if (writer && fs::is_regular_file(at->symlink_status(ignored)) && ::kill(*writer, 0) != 0 &&
        errno == ESRCH)
      fs::remove(at->path(), ignored);
  }
}

}  // namespace polyarm
