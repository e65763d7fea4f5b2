/// Requests about the project's files: read them, keep drafts across restarts, save without overwriting other
/// people's changes, and list earlier versions.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_later.hpp"
#include "polyarm/protocol/projects.hpp"
#include "polyarm/requests/families.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {

using namespace protocol;

/// The parts of the cell that requests about files read.
struct FileOwners {
  const CellSetup& setup;
  const Programs& programs;
  Worker& worker;
};

constexpr std::size_t kLargestText = bounds::kFileBytes, kMostFiles = bounds::kProjectFiles,
                      kMostVersions = bounds::kVersionsOfFile;

const std::vector<std::string>& endings() {
  static const std::vector<std::string> list = {".script", ".points", ".data",  ".yaml",  ".yml",
                                                ".txt",    ".md",     ".urdf",  ".xacro", ".srdf",
                                                ".csv",    ".json",   ".launch"};
  return list;
}

bool has_ending(const fs::path& path) {
  return std::find(endings().begin(), endings().end(), lower(path.extension().string())) != endings().end();
}

std::string kind_of(const fs::path& path) {
  const std::string ending = lower(path.extension().string()), stem = path.stem().string();
  if (ending == ".script") return "program";
  if (ending == ".points") return "points";
  if (ending == ".data") return "data";
  if (ending == ".yaml" || ending == ".yml")
    return stem == "cell" || stem == "scene" || stem == "signals" ? stem : "settings";
  return ending == ".md" ? "text" : "other";
}

double changed_at(const fs::path& path) {
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  if (error) return 0;
  const auto ago = fs::file_time_type::clock::now() - time;
  const auto at =
      std::chrono::system_clock::now() - std::chrono::duration_cast<std::chrono::system_clock::duration>(ago);
  return std::chrono::duration<double>(at.time_since_epoch()).count();
}

std::string flat(const std::string& path) {
  std::string out;
  for (const char c : path)
    out += c == '/' ? std::string("%2F") : c == '%' ? std::string("%25") : std::string(1, c);
  return out;
}

fs::path draft_file(const fs::path& folder, const std::string& path) {
  return folder / ".state" / "drafts" / (flat(path) + ".json");
}

fs::path versions_folder(const fs::path& folder, const std::string& path) {
  return folder / ".state" / "versions" / flat(path);
}

std::string read_if_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error) ? read_file(path) : std::string{};
}

OrNull<FileDraft> draft_of(const fs::path& folder, const std::string& path) {
  OrNull<FileDraft> out;
  const std::optional<Any> kept = Any::parse(read_if_there(draft_file(folder, path)));
  if (!kept) return out;
  if (auto draft = value_of<FileDraft>(*kept)) out.emplace(std::move(*draft));
  return out;
}

/// The version numbers in the folder, oldest first.
std::vector<int> version_numbers(const fs::path& folder) {
  std::vector<int> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (const auto number = parse_number(entry.path().filename().string()))
      out.push_back(static_cast<int>(*number));
  std::sort(out.begin(), out.end());
  return out;
}

void keep_version(const fs::path& folder, const std::string& path, const std::string& text) {
  const fs::path where = versions_folder(folder, path);
  fs::create_directories(where);
  std::vector<int> numbers = version_numbers(where);
  write_file_atomically(where / std::to_string(numbers.empty() ? 1 : numbers.back() + 1), text);
  numbers = version_numbers(where);
  std::uintmax_t bytes = 0;
  std::size_t kept = 0;
  std::error_code error;
  for (auto each = numbers.rbegin(); each != numbers.rend(); ++each) {
    const fs::path file = where / std::to_string(*each);
    bytes += fs::file_size(file, error);
    if (++kept > kMostVersions || (kept > 1 && bytes > bounds::kVersionsBytes)) fs::remove(file, error);
  }
}

/// Number of files in a folder and their total bytes, including hidden temporary files.
std::pair<std::size_t, std::uintmax_t> held_in(const fs::path& folder) {
  std::pair<std::size_t, std::uintmax_t> out{};
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    ++out.first;
    if (entry.is_regular_file(error)) out.second += entry.file_size(error);
  }
  return out;
}

/// Throws unless there is room for one more draft of `bytes` bytes in addition to those of other files.
void require_room_for_draft(const fs::path& file, std::size_t bytes) {
  std::error_code error;
  auto [count, held] = held_in(file.parent_path());
  if (fs::exists(file, error)) --count, held -= std::min(held, fs::file_size(file, error));
  if (count >= kMostFiles)
    throw Error("too-many", fmt::format("the project has {} drafts", count), "save or drop some of them");
  if (held + bytes > bounds::kDraftsBytes)
    throw Error("too-large",
                fmt::format("the project's drafts would have {} bytes, of at most {}", held + bytes,
                            bounds::kDraftsBytes),
                "save or drop some of them");
}

/// Throws unless there is room for one more file.
void require_room_for_file(const fs::path& folder) {
  std::error_code error;
  std::size_t count = 0;
  fs::recursive_directory_iterator each(folder, fs::directory_options::skip_permission_denied, error), end;
  for (; !error && each != end && count <= kMostFiles; each.increment(error)) {
    if (each->path().filename().string().starts_with('.')) {
      each.disable_recursion_pending();
      continue;
    }
    ++count;
  }
  if (count >= kMostFiles)
    throw Error("too-many", fmt::format("the project has {} files", count), "delete some of them");
}

const std::string& bounded(const std::string& text) {
  if (text.size() > kLargestText)
    throw Error("too-large", fmt::format("the text has {} bytes", text.size()), "a file may have 900 kB");
  return text;
}

/// The files of the running program, as paths in the form of the file list.
std::vector<fs::path> running_files(const FileOwners& cell) {
  std::vector<fs::path> out;
  for (const Task* task : {cell.programs.program(), cell.programs.plc()}) {
    if (!task || task->ended()) continue;
    const program::Program& program = task->interpreter().program();
    out.emplace_back(program.file);
    for (const auto& included : program.included) out.emplace_back(included.file);
  }
  return out;
}

bool among(const fs::path& file, const std::vector<fs::path>& files) {
  std::error_code error;
  return std::any_of(files.begin(), files.end(),
                     [&](const fs::path& each) { return fs::equivalent(file, each, error); });
}

std::vector<ListedFile> listed(const fs::path& folder, const std::vector<fs::path>& running) {
  std::vector<ListedFile> out;
  std::error_code error;
  fs::recursive_directory_iterator each(folder, fs::directory_options::skip_permission_denied, error), end;
  for (; !error && each != end && out.size() < kMostFiles; each.increment(error)) {
    const std::string file = each->path().filename().string();
    if (file.starts_with('.')) {
      if (each->is_directory(error)) each.disable_recursion_pending();
      continue;
    }
    if (!each->is_regular_file(error) || !has_ending(each->path()) || each->file_size(error) > kLargestText)
      continue;
    const std::string path = fs::relative(each->path(), folder, error).generic_string();
    out.push_back({path, kind_of(each->path()), each->file_size(error), changed_at(each->path()),
                   content_hash(read_file(each->path())), among(each->path(), running),
                   fs::exists(draft_file(folder, path), error)});
  }
  std::sort(out.begin(), out.end(), [](const ListedFile& a, const ListedFile& b) { return a.name < b.name; });
  return out;
}

FilesWrite::Answer written(const fs::path& folder, const std::string& path, const std::string& text,
                           const std::string& base, bool force) {
  const fs::path file = project_file(folder, path);
  std::error_code error;
  const bool exists = fs::exists(file, error);
  const std::string there = exists ? read_file(file) : std::string{};
  if ((exists ? content_hash(there) : "") != base && !force && !(exists && there == text))
    throw Error("changed-meanwhile",
                "'" + path + "' " +
                    (base.empty() ? "exists already"
                     : exists     ? "was changed meanwhile"
                                  : "was deleted meanwhile"),
                "read it again and choose, or set 'force'");
  if (!exists) require_room_for_file(folder);
  if (exists && there != text) keep_version(folder, path, there);
  fs::create_directories(file.parent_path());
  if (!exists || there != text) write_file_atomically(file, text);
  fs::remove(draft_file(folder, path), error);
  return {path, content_hash(text)};
}

}  // namespace

fs::path project_file(const fs::path& folder, const std::string& path) {
  const auto refuse = [&](const std::string& why) -> Error {
    return Error("bad-path", "'" + path + "' is not a file of the project: " + why,
                 "a path in its folder, for example pick.script");
  };
  if (printable_line(path) != path)
    throw Error(
        "bad-path",
        "'" + printable_line(path) + "' is not a file of the project: its name has control characters",
        "give it a name of letters, digits, spaces and - _ .");
  if (path.empty() || path.size() > 200 || path.find('\\') != std::string::npos)
    throw refuse("that is not a path");
  const fs::path wanted(path);
  if (wanted.is_absolute()) throw refuse("it is not in the folder");
  for (const fs::path& part : wanted)
    if (part.string().starts_with('.') || part.empty())
      throw refuse("it leads out of the folder, or is hidden");
  if (!has_ending(wanted)) throw refuse("its kind is not one of " + join(endings(), ", "));
  // No link on the path may lead outside either.
  std::error_code error;
  const fs::path root = resolved(folder), whole = resolved(folder / wanted);
  if (!inside(whole, root)) throw refuse("it leads out of the folder");
  for (fs::path at = whole; at != root && at.has_relative_path(); at = at.parent_path())
    if (fs::is_symlink(at, error)) throw refuse("a link on its path points to itself");
  if (fs::exists(whole, error) && !fs::is_regular_file(whole, error)) throw refuse("it is not a file");
  return whole;
}

void keep_out_of_git(const fs::path& folder) {
  const fs::path ignore = folder / ".state" / ".gitignore";
  std::error_code error;
  fs::create_directories(ignore.parent_path(), error);
  if (!fs::exists(ignore, error)) write_file_atomically(ignore, "*\n");
}

void write_project_file(const fs::path& folder, const std::string& path, const std::string& text) {
  keep_out_of_git(folder);
  written(folder, path, text, {}, true);
}

std::string content_hash(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return fmt::format("{:016x}", hash);
}

namespace {

Poll<FilesList::Answer> files(const FileOwners& cell, const FilesList&) {
  FilesList::Answer out;
  out.folder = cell.setup.file.folder.string();
  if (cell.programs.program())
    out.main = fs::path(cell.programs.program()->interpreter().program().file).filename().string();
  if (out.main && out.main->empty()) out.main.reset();
  return later(cell.worker, [folder = cell.setup.file.folder, running = running_files(cell), out]() mutable {
    out.files = listed(folder, running);
    return out;
  });
}

Poll<FilesRead::Answer> files_read(const FileOwners& cell, const FilesRead& request) {
  return later(cell.worker, [folder = cell.setup.file.folder, running = running_files(cell),
                             path = request.name] {
    const fs::path file = project_file(folder, path);
    std::error_code error;
    const OrNull<FileDraft> draft = draft_of(folder, path);
    const bool exists = fs::exists(file, error);
    if (!exists && !draft) throw Error("no-file", "there is no file '" + path + "' in the project");
    if (exists && fs::file_size(file, error) > kLargestText)
      throw Error("too-large", "'" + path + "' has more than 900 kB");
    const std::string text = exists ? read_file(file) : std::string{};
    return FilesRead::Answer{path, text, exists ? content_hash(text) : "", exists && among(file, running), draft};
  });
}

FilesDraft::Answer keep_draft(const fs::path& folder, const FilesDraft& request) {
  project_file(folder, request.name);
  const fs::path file = draft_file(folder, request.name);
  const auto now = static_cast<double>(std::time(nullptr));
  std::error_code error;
  if (!request.text) {
    fs::remove(file, error);
    return {now};
  }
  keep_out_of_git(folder);
  fs::create_directories(file.parent_path());
  const FileDraft draft{*request.text, request.base.value_or(""), request.by.value_or(""), now};
  require_room_for_draft(file, request.text->size());
  write_file_atomically(file, any_of(draft).dump());
  return {now};
}

Poll<FilesDraft::Answer> files_draft(const FileOwners& cell, const FilesDraft& request) {
  if (request.text) bounded(*request.text);
  return later(cell.worker,
               [folder = cell.setup.file.folder, request] { return keep_draft(folder, request); });
}

Poll<FilesWrite::Answer> files_write(const FileOwners& cell, const FilesWrite& request) {
  bounded(request.text);
  return later(cell.worker, [folder = cell.setup.file.folder, request] {
    keep_out_of_git(folder);
    return written(folder, request.name, request.text, request.base.value_or(""), request.force);
  });
}

Poll<FilesVersions::Answer> files_versions(const FileOwners& cell, const FilesVersions& request) {
  return later(cell.worker, [folder = cell.setup.file.folder, path = request.name] {
    project_file(folder, path);
    const fs::path where = versions_folder(folder, path);
    const std::vector<int> numbers = version_numbers(where);
    FilesVersions::Answer out{path, {}};
    std::error_code error;
    for (auto each = numbers.rbegin(); each != numbers.rend(); ++each) {
      const fs::path file = where / std::to_string(*each);
      const auto at = static_cast<std::time_t>(changed_at(file));
      char when[32] = "";
      std::tm local{};
      if (::localtime_r(&at, &local)) std::strftime(when, sizeof when, "%Y-%m-%d %H:%M:%S", &local);
      out.versions.push_back({*each, when, "replaced", fs::file_size(file, error)});
    }
    return out;
  });
}

Poll<FilesVersion::Answer> files_version(const FileOwners& cell, const FilesVersion& request) {
  const int wanted = static_cast<int>(std::clamp(request.number, 0.0, 1e9));
  return later(cell.worker, [folder = cell.setup.file.folder, path = request.name, wanted] {
    project_file(folder, path);
    const fs::path file = versions_folder(folder, path) / std::to_string(wanted);
    std::error_code error;
    if (!fs::exists(file, error))
      throw Error("no-file", fmt::format("there is no version {} of '{}'", wanted, path));
    return FilesVersion::Answer{path, wanted, read_file(file)};
  });
}

Poll<JustName> files_delete(const FileOwners& cell, const FilesDelete& request) {
  return later(cell.worker, [folder = cell.setup.file.folder, path = request.name] {
    const fs::path file = project_file(folder, path);
    std::error_code error;
    if (!fs::exists(file, error)) throw Error("no-file", "there is no file '" + path + "' in the project");
    keep_out_of_git(folder);
    keep_version(folder, path, read_file(file));
    fs::remove(file, error);
    fs::remove(draft_file(folder, path), error);
    return JustName{path};
  });
}

Poll<JustName> files_rename(const FileOwners& cell, const FilesRename& request) {
  return later(cell.worker, [folder = cell.setup.file.folder, path = request.name, to = request.to] {
    const fs::path from = project_file(folder, path), target = project_file(folder, to);
    std::error_code error;
    if (!fs::exists(from, error)) throw Error("no-file", "there is no file '" + path + "' in the project");
    if (fs::exists(target, error))
      throw Error("exists", "there is a file '" + to + "' already", "give another name");
    keep_out_of_git(folder);
    keep_version(folder, path, read_file(from));
    fs::create_directories(target.parent_path());
    fs::rename(from, target, error);
    if (error) throw Error("unwritable", "'" + path + "' cannot become '" + to + "': " + error.message());
    if (fs::exists(draft_file(folder, path), error))
      fs::rename(draft_file(folder, path), draft_file(folder, to), error);
    return JustName{to};
  });
}

}  // namespace

std::vector<Handler> file_handlers() {
  return handlers<files, files_read, files_draft, files_write, files_versions, files_version, files_delete,
                  files_rename>();
}

}  // namespace polyarm::cell
