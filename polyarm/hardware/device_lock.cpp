#include "polyarm/hardware/device_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::hardware {

namespace {
namespace fs = std::filesystem;

/// One folder for the locks of all users, because two users may share a port.
fs::path folder() {
  std::error_code error;
  for (const char* place : {"/run/lock", "/tmp"})
    if (access(place, W_OK | X_OK) == 0) return place;
  return fs::temp_directory_path(error);
}

fs::path lock_file(const std::string& device) {
  std::error_code error;
  const fs::path resolved = fs::weakly_canonical(device, error);
  std::string name = !error && fs::exists(resolved, error) ? resolved.string() : device;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '.' && c != '_') c = '_';
  return folder() / ("polyarm" + (name.front() == '_' ? name : "_" + name) + ".lock");
}

std::string holder_in(int file) {
  char text[256] = {};
  const ssize_t length = pread(file, text, sizeof(text) - 1, 0);
  return length > 0 ? std::string(text, static_cast<std::size_t>(length)) : "another process";
}

/// The number in "… (process 1234)"; 0 if there is none.
int process_in(const std::string& holder) {
  constexpr std::string_view kBefore = "(process ";
  const auto at = holder.rfind(kBefore);
  return at == std::string::npos ? 0 : std::atoi(holder.c_str() + at + kBefore.size());
}

/// True if the process has the file open; empty if this is not visible (another user's process).
std::optional<bool> has_open(int process, const fs::path& file) {
  std::error_code error;
  fs::directory_iterator at("/proc/" + std::to_string(process) + "/fd", error);
  if (error) return std::nullopt;
  for (const fs::directory_iterator end; !error && at != end; at.increment(error)) {
    std::error_code ignored;
    if (fs::equivalent(at->path(), file, ignored)) return true;
  }
  return false;
}
}  // namespace

std::string DeviceLock::holder(const std::string& device) {
  const fs::path path = lock_file(device);
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return {};
  const std::string text = holder_in(file);
  close(file);  // close first, or this process itself would have it open
  const int process = process_in(text);
  std::error_code error;
  if (process <= 0 || !fs::exists("/proc/" + std::to_string(process), error)) return {};
  return has_open(process, path).value_or(true) ? text : std::string();
}

DeviceLock::DeviceLock(const std::string& device, const std::string& holder) {
  const fs::path path = lock_file(device);
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file_ < 0)
    throw Error("lock-failed",
                "the lock " + path.string() + " of " + device + " cannot be created: " + std::strerror(errno),
                "remove that file, or run as the user who made it");
  fchmod(file_, 0666);  // the next process may belong to another user
  if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
    const std::string other = holder_in(file_);
    close(std::exchange(file_, -1));
    throw Error("device-in-use", device + " is in use by " + other,
                "end that first: a device has one master");
  }
  const std::string text = holder + " (process " + std::to_string(getpid()) + ")";
  if (ftruncate(file_, 0) != 0 || pwrite(file_, text.data(), text.size(), 0) < 0) return;  // a nameless lock
}

DeviceLock::~DeviceLock() {
  if (file_ >= 0) close(file_);
}

DeviceLock::DeviceLock(DeviceLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

DeviceLock& DeviceLock::operator=(DeviceLock&& other) noexcept {
  std::swap(file_, other.file_);
  return *this;
}

}  // namespace polyarm::hardware
