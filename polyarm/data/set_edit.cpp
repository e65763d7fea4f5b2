#include "polyarm/data/set_edit.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <ctime>
#include <optional>
#include <string_view>
#include <thread>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::data {

namespace {
namespace fs = std::filesystem;

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// A lock on a folder for programs that edit its data sets. One writer holds it at a time; it leaves no file
/// behind.
class FolderLock {
 public:
  FolderLock(const fs::path& path, int wait_limit_ms) {
    fd_ = ::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd_ < 0)
      throw Error(Problem{"no-file",
                          {path.string()},
                          "its folder cannot be opened: " + std::string(std::strerror(errno)),
                          {}});
    const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(wait_limit_ms);
    while (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK && errno != EINTR) return;  // this file system does not support locks
      if (std::chrono::steady_clock::now() > until) {
        ::close(fd_);
        throw Error(Problem{"in-use",
                            {path.string()},
                            "another program is changing data in this folder",
                            "try again when it is done; nothing was changed"});
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  ~FolderLock() { ::close(fd_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int fd_ = -1;
};

fs::path history_folder(const fs::path& path) {
  return folder_of(path) / ".state" / "history" / path.filename();
}

/// Removes incomplete temporary files of writers that were killed.
void remove_leftovers(const fs::path& path) {
  const std::string prefix = "." + path.filename().string() + ".tmp";
  std::error_code error;
  for (fs::directory_iterator at(folder_of(path), error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(prefix)) continue;
    int pid = 0;
    std::from_chars(name.data() + prefix.size(), name.data() + name.size(), pid);
    std::error_code ignored;
    if (pid > 0 && ::kill(pid, 0) != 0 && errno == ESRCH) fs::remove(at->path(), ignored);
  }
}

std::string local_time() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  ::localtime_r(&now, &local);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &local);
  return text;
}

/// "000012": digits only.
std::optional<int> number_of(const fs::path& file) {
  const std::string name = file.filename().string();
  int number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc{} || end != name.data() + name.size()) return std::nullopt;
  return number;
}

std::string padded(int number) {
  std::string out = std::to_string(number);
  return std::string(out.size() < 6 ? 6 - out.size() : 0, '0') + out;
}

void make_history_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(history_folder(path), error);
  const fs::path ignore = folder_of(path) / ".state" / ".gitignore";
  if (!error && !fs::exists(ignore, error)) write_file_atomically(ignore, "*\n");
  if (error)
    throw Error(Problem{"unwritable",
                        {path.string()},
                        "its history cannot be kept: " + error.message(),
                        "the file is as it was; check permissions and free space"});
}

/// Prefix of notes of changes that created their file.
constexpr std::string_view kOfNewFile = "new\t";

/// Keeps the present content of the file; a missing file becomes a version marked as absent.
void keep(const fs::path& path, const std::string& text, bool existed, const std::string& what) {
  make_history_folder(path);
  const std::vector<SetVersion> versions = history(path);
  const int next = versions.empty() ? 1 : versions.back().number + 1;
  const fs::path file = history_folder(path) / padded(next);
  std::string note = local_time() + "\t" + (existed ? "" : std::string(kOfNewFile)) + what;
  std::replace(note.begin(), note.end(), '\n', ' ');
  write_file_atomically(file.string() + ".what", note + "\n");
  write_file_atomically(file, text);
  std::error_code ignored;
  for (std::size_t k = 0; k + kVersionsKept < versions.size() + 1; ++k) {
    fs::remove(versions[k].file, ignored);
    fs::remove(versions[k].file.string() + ".what", ignored);
  }
}
}  // namespace

void edit_text(const fs::path& path, const std::string& what,
               const std::function<std::string(const std::string&)>& change, int wait_limit_ms) {
  const FolderLock lock(path, wait_limit_ms);
  remove_leftovers(path);
  std::error_code ignored;
  const bool existed = fs::exists(path, ignored);
  const std::string before = existed ? read_file(path) : "";
  const std::string after = change(before);
  if (existed && after == before) return;
  keep(path, before, existed, what);
  write_file_atomically(path, after);
}

ImportFile edit_set(const fs::path& path, const std::string& what,
                    const std::function<void(ImportFile&)>& change, int wait_limit_ms) {
  ImportFile set;
  edit_text(
      path, what,
      [&](const std::string& before) {
        Problems problems;
        set = ImportFile::parse(before, path.string(), problems);
        problems.throw_if_errors();
        change(set);
        return set.text();
      },
      wait_limit_ms);
  return set;
}

std::vector<SetVersion> history(const fs::path& path) {
  std::vector<SetVersion> out;
  std::error_code error;
  for (fs::directory_iterator at(history_folder(path), error), end; !error && at != end;
       at.increment(error)) {
    const auto number = number_of(at->path());
    if (!number) continue;
    SetVersion version{*number, {}, {}, at->path(), false};
    const std::string note_file = at->path().string() + ".what";
    std::error_code ignored;
    if (fs::exists(note_file, ignored)) {
      const std::string note(trim(read_file(note_file)));
      const auto tab = note.find('\t');
      version.when = note.substr(0, tab);
      if (tab != std::string::npos) version.what = note.substr(tab + 1);
      if (version.what.starts_with(kOfNewFile)) {
        version.absent = true;
        version.what = version.what.substr(kOfNewFile.size()) + " (which made the file)";
      }
    }
    out.push_back(std::move(version));
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  return out;
}

void require_history(const fs::path& path, std::size_t steps) {
  const std::size_t known = history(path).size();
  if (steps > 0 && steps <= known) return;
  const auto refuse = [&](std::string what, std::string advice) {
    throw Error(Problem{"no-history", {path.string()}, std::move(what), std::move(advice)});
  };
  if (steps == 0) refuse("0 changes cannot be undone", "give the number of changes; 1: only the last one");
  if (known == 0) refuse("there is nothing to undo: no change of this file is known", {});
  refuse((known == 1 ? "1 change of this file is known, "
                     : std::to_string(known) + " changes of this file are known, ") +
             std::to_string(steps) + " were to be taken back",
         "polyarm data history shows them");
}

void undo(const fs::path& path, std::size_t steps, int wait_limit_ms) {
  const FolderLock lock(path, wait_limit_ms);
  require_history(path, steps);
  const std::vector<SetVersion> versions = history(path);
  const SetVersion& wanted = versions[versions.size() - steps];
  const fs::path undone = history_folder(path) / "undone";
  std::error_code error;
  fs::create_directories(undone, error);
  if (fs::exists(path, error))
    write_file_atomically(undone / padded(versions.back().number + 1), read_file(path));
  if (wanted.absent)
    fs::remove(path, error);
  else
    write_file_atomically(path, read_file(wanted.file));
  for (std::size_t k = versions.size() - steps; k < versions.size(); ++k) {
    fs::rename(versions[k].file, undone / versions[k].file.filename(), error);
    fs::remove(versions[k].file.string() + ".what", error);
  }
}

void delete_set(const fs::path& path, int wait_limit_ms) {
  const FolderLock lock(path, wait_limit_ms);
  keep(path, read_file(path), true, "delete the file");
  std::error_code error;
  if (!fs::remove(path, error))
    throw Error(Problem{"unwritable", {path.string()}, "cannot be deleted: " + error.message(), {}});
}

ImportFile without(const ImportFile& set, const std::string& name) {
  if (!set.values().find(name))
    throw Error(Problem{"unknown-name",
                        {set.file()},
                        "there is no '" + name + "'" + did_you_mean(name, set.values().names()),
                        {}});
  std::string out, current;
  const std::string text = set.text();
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    const std::string line = text.substr(at, end - at);
    at = end;
    std::string_view content = trim(line);
    if (content.starts_with("\xEF\xBB\xBF")) content.remove_prefix(3);
    const auto colon = content.find(':');
    const std::string key = colon == std::string_view::npos || content.front() == '#'
                                ? std::string{}
                                : lower(trim(content.substr(0, colon)));
    if (key == "name") current = trim(content.substr(colon + 1));
    const bool of_a_name = !key.empty() && key != "js" && key != "pose";
    if (!(of_a_name && current == name)) out += line;
  }
  Problems problems;
  return ImportFile::parse(out, set.file(), problems);
}

}  // namespace polyarm::data
