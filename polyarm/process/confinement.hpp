#pragma once
/// Confines a process that parses untrusted input. An attacker who takes over the process runs as the cell's
/// user, and could otherwise kill the cell, read the user's files and start programs. If the kernel lacks the
/// features (Landlock needs 5.13, and may be disabled), the process runs without them.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace polyarm::process {

/// Blocks system calls (EPERM) that start programs, access or signal other processes, open files for writing,
/// change the file system, or connect to sockets of this machine (AF_UNIX). Threads, memory, reading and
/// networks stay available. Call it before the first thread is created and after PR_SET_NO_NEW_PRIVS.
/// `local_sockets` allows AF_UNIX, which is needed to resolve names of the local network (.local). Returns
/// false if the system has no filters, or under a sanitizer.
bool filter_calls(bool local_sockets = false);

struct Confinement {
  std::vector<std::string> readable;  ///< files and folders, in addition to those of the system that
                                      ///< libraries read
  /// TCP ports; nullopt: any. Kernels before 6.7 ignore them.
  std::optional<std::vector<std::uint16_t>> connects, listens;
};
/// Blocks all other files and ports. Call it under the same conditions. Returns false if the kernel has no
/// Landlock.
bool confine(const Confinement& to);

}  // namespace polyarm::process
