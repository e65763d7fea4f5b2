#pragma once
/// Deploys a program to several cells: compares, checks on each cell, then writes. Nothing moves, and no
/// program is started.
#include <string>
#include <vector>

#include "polyarm/fleet/site_file.hpp"

namespace polyarm::fleet {

/// Lines that differ, each with '-' or '+' in front; at most `most` of them, then their number.
std::vector<std::string> difference(const std::string& before, const std::string& after,
                                    std::size_t most = 200);

struct Deployed {
  enum class State {
    same,   ///< the cell has this text already
    ready,  ///< checked, and not written yet
    written,
    faulty,  ///< the cell's check found errors
    refused  ///< the cell does not answer, or refuses
  };
  std::string cell;
  State state = State::refused;
  std::string why;                    ///< of a refusal
  std::vector<std::string> diff;      ///< to what the cell has now
  std::vector<std::string> problems;  ///< that its check found
  std::string base;                   ///< hash of what the cell has now; empty: it has no such file
};
const char* name(Deployed::State state);

/// Asks each cell, all at the same time; writes nothing.
std::vector<Deployed> plan(const std::vector<SiteCell>& cells, const std::string& file,
                           const std::string& text, double timeout_s);
/// Writes the file to the cells that are `ready`, or `faulty` if `faulty_too`. A cell whose file has changed
/// since the plan refuses, and so does one where somebody has control.
void write(const std::vector<SiteCell>& cells, std::vector<Deployed>& planned, const std::string& file,
           const std::string& text, bool faulty_too, double timeout_s);

}  // namespace polyarm::fleet
