#include "polyarm/signals/folder_turn.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/xattr.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <thread>

#include "polyarm/base/hash.hpp"

namespace polyarm::signals {

FolderTurn::FolderTurn(const std::filesystem::path& folder)
    : folder_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {}

bool FolderTurn::take() {
  constexpr int kTries = 200, kBetween = 100;  // interval in microseconds
  for (int i = 0; folder_ && i < kTries; ++i) {
    if (::flock(folder_.number(), LOCK_EX | LOCK_NB) == 0) return true;
    if (errno != EWOULDBLOCK && errno != EINTR) return true;
    std::this_thread::sleep_for(std::chrono::microseconds(kBetween));
  }
  return !folder_;
}

void FolderTurn::give_back() {
  if (folder_) ::flock(folder_.number(), LOCK_UN);
}

namespace {
constexpr const char* kMark = "user.polyarm.merged";

std::uint64_t hash_of(const std::string& text) {
  TraceHash hash;
  for (const char c : text) hash.add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
  return hash.value();
}
}  // namespace

void mark_as_merged(int file, const std::string& text) {
  const std::uint64_t hash = hash_of(text);
  ::fsetxattr(file, kMark, &hash, sizeof hash, 0);
}

bool is_merged(int file, const std::string& text) {
  std::uint64_t hash = 0;
  return ::fgetxattr(file, kMark, &hash, sizeof hash) == sizeof hash && hash == hash_of(text);
}

}  // namespace polyarm::signals
