#pragma once
/// What the results of a sweep depend on beside the values of a variant: the files of the cell, how a variant
/// is run, and the version of Polyarm. Reads the disk.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/sweeps/sweep.hpp"

namespace polyarm::sweeps {

/// Name → hash: each file of the cell by its path in the cell's folder, "how it is run", "version".
using Inputs = std::map<std::string, std::string>;

/// Leaves out hidden files and folders (.state), records of faults, sweep files, and what a cell does not
/// read: .md .html .csv .json .svg .log .sqlite. Throws Error("too-many") for a cell of more than 20,000
/// files.
Inputs inputs_of(const Sweep& sweep, const std::string& version);
/// The names that differ; empty if nothing has changed.
std::vector<std::string> changes(const Inputs& before, const Inputs& now);

/// Hashes of the descriptions of robots, each read once. One thread.
class RobotHashes {
 public:
  explicit RobotHashes(const description::Catalogue& catalogue) : catalogue_(catalogue) {}
  /// Empty for the cell's own robot, whose name is empty.
  const std::string& of(const std::string& robot);

 private:
  const description::Catalogue& catalogue_;
  std::map<std::string, std::string> known_;
};

}  // namespace polyarm::sweeps
