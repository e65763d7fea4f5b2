#pragma once
/// The approvals of this machine's user, in `config_folder()/approved`: one per line, fields separated by
/// tabs, file private to the user. Any thread; reads and writes disk.
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

/// Returns all approvals, oldest first; none if there is no file. Throws Error("bad-approvals") with file, line and
/// advice if the file could have been written by somebody else (a link, another owner, writable by others), or if any
/// line is not one that approve() writes: then no line counts.
std::vector<Approval> approvals();
/// `what` is not compared for libraries and folders.
bool is_approved(const Approval& approval);
/// Throws Error("unwritable") if the file cannot be written, and Error("bad-name") for texts with control characters.
void approve(const Approval& approval);
/// Removes and returns all whose subject or text equals `named`, or whose hash starts with it (>= 8 digits).
std::vector<Approval> revoke(const std::string& named);

/// Checks a folder whose libraries may be rebuilt and loaded without a new approval: the user must own it,
/// and it must not be writable by everybody. Returns "" if it is suitable, else the reason.
std::string unfit_for_development(const std::filesystem::path& folder);

}  // namespace polyarm
