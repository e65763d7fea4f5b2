#pragma once
/// The page of a site: one table of all cells, which a browser on this machine shows.
#include <cstdint>
#include <memory>

#include "polyarm/fleet/site_watch.hpp"

namespace polyarm::fleet {

/// Serves the page on the loopback interface until the end. It only shows; it takes no requests.
class SitePage {
 public:
  /// `port` 0: any free port. The watch must outlive this. Throws Error("no-port").
  SitePage(const SiteWatch& watch, std::string site, std::uint16_t port);
  ~SitePage();
  std::uint16_t port() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::fleet
