#pragma once
/// What a cell's files need outside the cell's folder: native code, hosts, devices, files, secrets. It is
/// shown before the cell runs, and refused unless the user has allowed it (base/reach.hpp).
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
  std::string sha256{};  ///< for a plugin
};

/// Everything that the cell's own files name; accesses by plugins are not known. Loads, opens and connects
/// nothing. Files inside the cell, packages and this machine's loopback are not listed. `unread`: problems in
/// files that could name more.
std::vector<Wanted> required_by(const CellFile& file, Problems* unread = nullptr);
/// Adds everything to the cell's grant that the user has approved for cells in its folder before.
void allow_remembered(const CellFile& file);
/// Stores the permission for cells in this folder; it applies when one is opened next.
void remember_allowed(const CellFile& file, const Wanted& wanted);
/// Adds it to the cell's grant and stores it for cells in this folder. A plugin is approved by its hash.
void allow_and_remember(const CellFile& file, const Wanted& wanted);

/// Call before links are connected: checks their hosts, secrets and certificates. Replaces `secret:NAME` by a
/// file path. Adds Error("host-not-allowed" | "secret-not-allowed" | "outside-cell").
void admit_links(const CellFile& file, signals::Signals& signals, Problems& problems);
/// The same as admit_links for doors that are open to a network.
/// Adds a problem for each host of a stream that the user has not allowed.
void admit_streams(const CellFile& file, Problems& problems);
void admit_doors(const CellFile& file, Problems& problems);
/// Call before real hardware is opened: `secret:NAME` among the parameters of robots may be read from now on, if
/// the user allows it. Adds Error("secret-not-allowed" | "bad-secret").
void admit_robots(const CellFile& file, Problems& problems);

}  // namespace polyarm::cell
