#pragma once
/// Reads sweep files (`polyarm: sweep/1`). Not for the control cycle.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/sweeps/sweep.hpp"

namespace polyarm::sweeps {

/// Throws Error with all problems of the file, each with its line.
Sweep read_sweep_file(const std::filesystem::path& path, const description::Catalogue& catalogue);
/// The same from a text. `path` names it and is where relative names begin; it need not exist.
Sweep read_sweep(const std::string& text, const std::filesystem::path& path,
                 const description::Catalogue& catalogue);

/// What the command line says instead of a file; empty texts say nothing.
struct Words {
  std::string cell, robots, base, programs, speeds, seeds, hardware;
};
/// The text of a sweep file that says the same. `base`: "x=-0.1:0.1:5,y=0|0.1,yaw=0|90deg".
/// Throws Error("bad-value").
std::string text_of(const Words& words);

}  // namespace polyarm::sweeps
