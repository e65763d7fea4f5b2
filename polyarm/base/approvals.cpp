#include "polyarm/base/approvals.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"

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
    throw Error("unwritable", "there is no place to remember approvals in", "set HOME or XDG_CONFIG_HOME");
  std::string text;
  for (const Approval& each : list) text += each.kind + '\t' + each.subject + '\t' + each.what + '\n';
  const AsUser user;
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  write_file_atomically(file, text, 0600);
}

bool same(const Approval& a, const Approval& b) {
  const bool by_subject = a.kind == "library" || a.kind == "folder";
  return a.kind == b.kind && a.subject == b.subject && (by_subject || a.what == b.what);
}
}  // namespace

std::vector<Approval> approvals() {
  std::vector<Approval> out;
  Problems ignored;
  collect(ignored, [&] {
    const AsUser user;
    std::error_code error;
    if (config_folder().empty() || !fs::exists(list_file(), error)) return;
    for (const std::string& line : split_fields(read_file(list_file(), kLargestList), '\n')) {
      const std::vector<std::string> fields = split_fields(line, '\t');
      if (fields.size() >= 2) out.push_back({fields[0], fields[1], fields.size() > 2 ? fields[2] : ""});
    }
  });
  return out;
}

bool is_approved(const Approval& approval) {
  const std::vector<Approval> all = approvals();
  return std::any_of(all.begin(), all.end(), [&](const Approval& each) { return same(each, approval); });
}

void approve(const Approval& approval) {
  for (const std::string& text : {approval.subject, approval.what})
    if (text.find_first_of("\t\n\r") != std::string::npos)
      throw Error("bad-name", "a name with tabs or line ends cannot be approved", "rename it");
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
