#pragma once
/// What the user of this machine has approved once, in `config_folder()/approved`: one line for each, fields
/// between tabs, private to the user. Any thread; reads and writes disk.
#include <filesystem>
#include <string>
#include <vector>

namespace polyarm {

struct Approval {
  std::string kind;     ///< library | folder | host | path | secret
  std::string subject;  ///< SHA-256 of a library; a folder of plugins; else the project's folder
  std::string what;     ///< the library's file when it was approved; else the host, path or secret
  bool operator==(const Approval&) const = default;
};

/// All, oldest first. A file that cannot be read has none.
std::vector<Approval> approvals();
/// `what` is not compared for libraries and folders.
bool is_approved(const Approval& approval);
/// Throws Error("unwritable") and for texts with tabs or line ends.
void approve(const Approval& approval);
/// Takes back all whose subject or text is `named`, or whose hash begins so (8 digits at least). Returns them.
std::vector<Approval> revoke(const std::string& named);

/// A folder whose libraries are rebuilt and loaded without being asked about again: the user's own, not
/// writable by everybody. Empty if it may be one, else the reason.
std::string unfit_for_development(const std::filesystem::path& folder);

}  // namespace polyarm
