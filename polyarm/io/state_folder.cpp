#include "polyarm/io/state_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {
/// Process id of the lock's holder, found by the inode of the lock file; 0 if unknown.
long holder_of(ino_t file) {
  std::string text;
  Problems ignored;
  const AsUser user;
  collect(ignored, [&] { text = read_file("/proc/locks"); });
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string number, kind, manner, access, pid, place;
    words >> number >> kind >> manner >> access >> pid >> place;
    const auto colon = place.rfind(':');
    if (kind == "FLOCK" && colon != std::string::npos && place.substr(colon + 1) == std::to_string(file))
      return std::atol(pid.c_str());
  }
  return 0;
}

/// Refuses links in the state folder: a downloaded cell could use them to delete or overwrite other files.
void refuse_links(const fs::path& state) {
  std::error_code error;
  const fs::path own = resolved(state.parent_path());
  const auto refuse = [&](const fs::path& place) {
    if (!fs::is_symlink(place, error)) return;
    if (reach().confined()) reach().check(place, Reach::Use::write);
    const fs::path real = resolved(place);
    if (polyarm::inside(own, real))
      throw Error(Problem{"bad-state",
                          {place.string()},
                          "this link leads to " + real.string(),
                          "remove it: runs store their files in this folder"});
    if (!fs::exists(place, error))
      throw Error(Problem{"bad-state",
                          {place.string()},
                          "this link leads to " + real.string() + ", which does not exist",
                          "remove it: runs store their files in this folder"});
  };
  refuse(state);
  if (fs::is_symlink(state, error)) return;  // a link to a folder that the cell may write
  fs::recursive_directory_iterator each(state, fs::directory_options::skip_permission_denied, error), end;
  for (; !error && each != end; each.increment(error)) refuse(each->path());
}
}  // namespace

StateLock::StateLock(const fs::path& file, int wait_limit_ms) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  fd_ = ::open(file.c_str(), O_RDONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600);
  // Without a lock two runs could write to one folder. A read-only folder needs no lock.
  if (fd_ < 0 && errno != EACCES && errno != EPERM && errno != EROFS && errno != ENOENT && errno != ENOTDIR)
    throw Error(Problem{"bad-state",
                        {file.string()},
                        errno == ELOOP
                            ? "this is a link, but a run needs a file for its lock here"
                            : std::string("the lock of a run cannot be created: ") + std::strerror(errno),
                        "remove it"});
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(wait_limit_ms);
  for (;;) {
    if (fd_ < 0 || ::flock(fd_, LOCK_EX | LOCK_NB) == 0) return;
    if (errno != EWOULDBLOCK && errno != EINTR) return;  // the file system has no locks
    if (std::chrono::steady_clock::now() > until) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  struct stat status {};
  const long pid = ::fstat(fd_, &status) == 0 ? holder_of(status.st_ino) : 0;
  ::close(std::exchange(fd_, -1));
  throw Error(Problem{
      "cell-in-use",
      {file.parent_path().parent_path().string()},
      "another polyarm runs this cell" + (pid > 0 ? ": process " + std::to_string(pid) : std::string()),
      "end it first, or run a copy of the folder"});
}

StateLock::~StateLock() {
  if (fd_ >= 0) ::close(fd_);
}

namespace {
/// One lock per folder for all cells of this process, because a dry run may run in parallel to the cell.
std::shared_ptr<const StateLock> lock_of(const fs::path& file, int wait_limit_ms) {
  static std::mutex mutex;
  static std::map<fs::path, std::weak_ptr<const StateLock>> held;
  const std::lock_guard lock(mutex);
  std::weak_ptr<const StateLock>& known = held[resolved(file)];
  std::shared_ptr<const StateLock> out = known.lock();
  if (!out) known = out = std::make_shared<const StateLock>(file, wait_limit_ms);
  return out;
}
}  // namespace

StateFolder::StateFolder(fs::path cell_folder, std::set<std::string> live, bool keep,
                         const fs::path& elsewhere, int wait_limit_ms, const std::string& cell)
    : folder_(std::move(cell_folder)),
      state_(elsewhere.empty() ? folder_ / ".state" / "data" : elsewhere),
      live_(std::move(live)) {
  if (elsewhere.empty()) {
    refuse_links(folder_ / ".state");
    if (wait_limit_ms >= 0) lock_ = lock_of(folder_ / ".state" / ("lock." + cell), wait_limit_ms);
    if (lock_) sweep_temporaries(folder_);
    sweep_temporaries(folder_ / ".state");
    sweep_temporaries(folder_ / ".state" / "recordings");
    sweep_temporaries(state_);
  } else {
    grant_ = reach().grant();
    grant_->allow(elsewhere);
  }
  std::error_code error;
  if (!keep) fs::remove_all(state_, error);
  if (error)
    throw Error(
        "unwritable", state_.string() + ": the data of the run before cannot be removed: " + error.message(),
        "a run begins with copies of the data files of the cell: work on a copy of the cell in a folder "
        "where you may write, or continue with the data that are there (--keep)");
}

fs::path StateFolder::folder_of(const std::string& name) const {
  return live_.contains(name) ? folder_ : state_;
}

void StateFolder::bring(const fs::path& original, bool again) const {
  std::error_code error;
  fs::create_directories(state_, error);
  if (error)
    throw Error("unwritable", state_.string() + ": this folder cannot be created: " + error.message(),
                "a run stores copies of data files there: work on a copy of the cell in a folder where you "
                "may write, or change the permissions (ls -ld shows them)");
  const fs::path ignore = state_.parent_path() / ".gitignore";
  const bool in_cell = state_.parent_path().filename() == ".state";
  if (in_cell && !fs::exists(ignore, error)) write_file_atomically(ignore, "*\n");
  const fs::path copy = state_ / original.filename();
  if (again || !fs::exists(copy, error)) write_file_atomically(copy, read_file(original, bounds::kDataBytes));
}

void StateFolder::renew(const std::string& name, const Location& where) const {
  if (live_.contains(name)) return;
  const data::LoadedFiles originals = data::load_files(name, folder_, where);
  bring(originals.data.file(), true);
  for (const data::ImportFile& points : originals.points) bring(points.file(), true);
}

data::LoadedFiles StateFolder::load(const std::string& name, const Location& where) const {
  if (live_.contains(name)) return data::load_files(name, folder_, where);
  const data::LoadedFiles originals = data::load_files(name, folder_, where);
  bring(originals.data.file());
  for (const data::ImportFile& points : originals.points) bring(points.file());
  if (!originals.script.empty()) bring(originals.script);
  data::LoadedFiles copies = data::load_files(name, state_, where);
  copies.script = originals.script;
  return copies;
}

}  // namespace polyarm::cell
