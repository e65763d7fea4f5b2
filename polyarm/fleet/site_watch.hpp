#pragma once
/// Asks all cells of a site for their state, each on a thread of its own, so that a silent cell delays no
/// other.
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "polyarm/fleet/oee.hpp"
#include "polyarm/fleet/site_file.hpp"

namespace polyarm::fleet {

struct CellReport {
  std::string name, address;
  bool asked = false, answers = false;
  std::string trouble;     ///< why it does not answer
  double age_s = 0;        ///< of `summary`
  nlohmann::json summary;  ///< the last one; null: there was none
  Oee oee;
};

class SiteWatch {
 public:
  /// Asks each cell every `every_s` seconds until the end; 0: once.
  SiteWatch(const Site& site, double every_s, double timeout_s);
  ~SiteWatch();
  /// Any thread.
  std::vector<CellReport> reports() const;
  /// Waits until each cell was asked once.
  void wait_for_first() const;

 private:
  void ask(std::size_t cell);
  std::string trouble_of(std::size_t cell, nlohmann::json& summary) const;

  const Site site_;
  const double every_s_, timeout_s_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  bool over_ = false;
  std::vector<CellReport> reports_;
  std::vector<double> answered_;  ///< time of the last answer, s, steady
  std::vector<std::thread> threads_;
};

/// A table for a terminal, and the same as JSON. A cell's words are those of the cell: print them through
/// printable().
std::string table_of(const std::vector<CellReport>& reports);
nlohmann::json json_of(const std::vector<CellReport>& reports);

}  // namespace polyarm::fleet
