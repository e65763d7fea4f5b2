#include "polyarm/base/approvals.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/shell_word.hpp"

namespace polyarm {

namespace {
namespace fs = std::filesystem;

constexpr std::size_t kLargestList = 4 << 20;

fs::path list_file() {
  return config_folder() / "approved";
}

void write_list(const std::vector<Approval>& list) {
  const fs::path file = list_file();
  if (config_folder().empty())
    throw Error("unwritable", "there is no folder for approvals", "set HOME or XDG_CONFIG_HOME");
  std::string text;
  for (const Approval& each : list) text += each.kind + '\t' + each.subject + '\t' + each.what + '\n';
  const AsUser user;
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  write_file_atomically(file, text, 0600);
}

[[noreturn]] void refuse(const fs::path& file, int line, const std::string& what, const std::string& advice) {
  throw Error(Problem{"bad-approvals", {file.string(), line}, "this list of approvals is not used: " + what, advice});
}

/// As they are; split_fields() would take blanks away.
std::vector<std::string> parts_of(std::string_view text, char separator) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    out.emplace_back(text.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

/// Only the user can have written it. False if there is none.
bool require_own(const fs::path& file) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0) {
    // A list that this user cannot reach (HOME of somebody else) approves nothing.
    if (errno == ENOENT || errno == ENOTDIR || errno == EACCES) return false;
    refuse(file, 0, std::string("it cannot be read: ") + std::strerror(errno), "check its permissions");
  }
  if (S_ISLNK(status.st_mode))
    refuse(file, 0, "it is a link to another file", "put the file itself there, or delete the link");
  if (!S_ISREG(status.st_mode)) refuse(file, 0, "it is not an ordinary file", "delete it");
  if (status.st_uid != ::geteuid())
    refuse(file, 0, "it belongs to another user", "delete it; then approve again");
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    refuse(file, 0, "other users may write to it",
           "check its entries (polyarm plugins approved), then type chmod 600 " + shell_word(file.string()));
  return true;
}

/// "" for an approval as this program writes it.
std::string wrong_with(const Approval& each) {
  constexpr std::array kKinds = {"library", "folder", "host", "path", "secret"};
  const bool digits = each.subject.size() == 64 &&
                      each.subject.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (std::find(kKinds.begin(), kKinds.end(), each.kind) == kKinds.end())
    return "'" + printable_line(shortened(each.kind)) + "' is not a kind of approval";
  if (each.kind == "library" ? !digits : !each.subject.starts_with('/'))
    return each.kind == "library" ? "a library needs its SHA-256" : "a " + each.kind + " needs an absolute folder";
  if (printable_line(each.subject) != each.subject || printable_line(each.what) != each.what)
    return "it has control characters, or is not UTF-8";
  return {};
}

bool same(const Approval& a, const Approval& b) {
  const bool by_subject = a.kind == "library" || a.kind == "folder";
  return a.kind == b.kind && a.subject == b.subject && (by_subject || a.what == b.what);
}
}  // namespace

std::vector<Approval> approvals() {
  std::vector<Approval> out;
  if (config_folder().empty()) return out;
  const AsUser user;
  const fs::path file = list_file();
  if (!require_own(file)) return out;
  int number = 0;
  std::vector<std::string> lines = parts_of(read_file(file, kLargestList), '\n');
  if (lines.back().empty()) lines.pop_back();  // after the last line's end
  for (const std::string& line : lines) {
    ++number;
    std::vector<std::string> fields = parts_of(line, '\t');
    fields.resize(std::max<std::size_t>(fields.size(), 3));
    Approval each{fields[0], fields[1], fields[2]};
    if (fields.size() > 3 || !wrong_with(each).empty())
      refuse(file, number, fields.size() > 3 ? "it has more than three fields" : wrong_with(each),
             "the whole file is ignored; find out what wrote to it, then delete it and approve again");
    out.push_back(std::move(each));
  }
  return out;
}

bool is_approved(const Approval& approval) {
  const std::vector<Approval> all = approvals();
  return std::any_of(all.begin(), all.end(), [&](const Approval& each) { return same(each, approval); });
}

void approve(const Approval& approval) {
  if (const std::string wrong = wrong_with(approval); !wrong.empty())
    throw Error("bad-name", "this cannot be approved: " + wrong, "rename it");
  std::vector<Approval> all = approvals();
  std::erase_if(all, [&](const Approval& each) { return same(each, approval); });
  all.push_back(approval);
  write_list(all);
}

std::vector<Approval> revoke(const std::string& named) {
  std::vector<Approval> kept, taken;
  for (const Approval& each : approvals()) {
    const bool by_hash = each.kind == "library" && named.size() >= 8 && each.subject.starts_with(named);
    const bool below = each.kind == "library" && inside(each.what, named);
    (by_hash || below || each.subject == named || each.what == named ? taken : kept).push_back(each);
  }
  if (!taken.empty()) write_list(kept);
  return taken;
}

std::string unfit_for_development(const std::filesystem::path& folder) {
  fs::path there = resolved(folder);
  std::error_code error;
  while (there.has_relative_path() && !fs::exists(there, error)) there = there.parent_path();
  struct stat status {};
  if (::stat(there.c_str(), &status) != 0) return "it cannot be read";
  if (status.st_uid != ::geteuid()) return there.string() + " belongs to another user";
  if ((status.st_mode & S_IWOTH) != 0) return "everybody may write to " + there.string();
  return {};
}

}  // namespace polyarm
