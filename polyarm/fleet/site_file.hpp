#pragma once
/// The file of a site: which cells it has, and how they are reached.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::fleet {

inline constexpr std::size_t kMostCells = bounds::kSiteCells;

struct SiteCell {
  std::string name, host;
  std::uint16_t port = 8765;
  bool tls = false;
  std::string token;         ///< content of the token file
  std::string fingerprint;   ///< of the certificate, SHA-256: hexadecimal digits, upper case; empty: none
  double ideal_cycle_s = 0;  ///< of one pass of the program; 0: unknown
  Location where;
};

struct Site {
  std::string name;
  std::vector<SiteCell> cells;
};

/// Throws Error with all problems. Token files must be private (mode 0600).
Site read_site_file(const std::filesystem::path& file);

/// The token in a private file: one line, or a whole link with ?token=. Throws Error("bad-token").
std::string read_token_file(const std::filesystem::path& file);

}  // namespace polyarm::fleet
