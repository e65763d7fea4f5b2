#pragma once
/// What a process may still do that parses what strangers send. Who takes it over shares the user of the cell: without this
/// it could kill the cell, read the user's files, and start programs. Where the kernel knows neither (Landlock before 5.13, or
/// switched off), the process runs without.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace polyarm::process {

/// From now on calls fail (EPERM) that start programs, reach into other processes or signal them, open files for
/// writing, change the file system, or connect to sockets of this machine (AF_UNIX). Threads, memory, reading and
/// networks stay. Before the first thread is made, after PR_SET_NO_NEW_PRIVS. `local_sockets`: AF_UNIX stays, too, by which names
/// of a plant (.local) are found. False where the system has no filters, or a sanitizer watches.
bool filter_calls(bool local_sockets = false);

struct Confinement {
  std::vector<std::string> readable;  ///< files and folders beside those of the system that libraries read
  /// TCP ports; nothing: any. Kernels before 6.7 do not look at them.
  std::optional<std::vector<std::uint16_t>> connects, listens;
};
/// From now on other files cannot be opened, nor other ports. Under the same conditions; false where the kernel has no
/// Landlock.
bool confine(const Confinement& to);

}  // namespace polyarm::process
