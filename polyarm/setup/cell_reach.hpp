#pragma once
/// What a cell's files want to reach outside the cell's folder: native code, hosts, devices, files, secrets.
/// It is told before the cell runs, and refused as long as the user has not allowed it (base/reach.hpp).
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/signals/tags.hpp"

namespace polyarm::cell {

struct Wanted {
  std::string kind;  ///< plugin | host | device | file | secret
  std::string what;  ///< a file, a host, the name of a secret
  std::string why;   ///< "the link 'plc'"
  Location where;
  bool allowed = false;
  std::string sha256{};  ///< of a plugin
};

/// What the cell names, as far as its own files say; what a plugin does is the plugin's. Nothing is loaded,
/// opened or connected. Files inside the cell, packages and this machine's loopback are not listed.
/// `unread`: what is wrong in files that could name more.
std::vector<Wanted> wanted_by(const CellFile& file, Problems* unread = nullptr);
/// Adds to the cell's grant what the user has approved for cells in its folder earlier.
void allow_remembered(const CellFile& file);
/// Remembers that cells in this folder may reach it, from when one is opened next.
void remember_allowed(const CellFile& file, const Wanted& wanted);
/// Adds it to the cell's grant, and remembers it for cells in this folder. A plugin is approved by its hash.
void allow_and_remember(const CellFile& file, const Wanted& wanted);

/// Before links are connected: their hosts, secrets and certificates. `secret:NAME` becomes a file's path.
/// Adds Error("host-not-allowed" | "secret-not-allowed" | "outside-cell").
void admit_links(const CellFile& file, signals::Signals& signals, Problems& problems);
/// The same for doors into the cell that are open to a network.
void admit_doors(const CellFile& file, Problems& problems);

}  // namespace polyarm::cell
