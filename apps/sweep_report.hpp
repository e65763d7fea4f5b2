#pragma once
/// Shows the results of a sweep: a table for people, CSV, JSON, a page.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "polyarm/sweeps/inputs.hpp"
#include "polyarm/sweeps/store.hpp"
#include "polyarm/sweeps/summary.hpp"
#include "polyarm/sweeps/variants.hpp"

namespace polyarm::apps {

/// Rows of variants that the sweep still has; rows of earlier versions of the file stay in the store unseen.
class SweepReport {
 public:
  SweepReport(const sweeps::Sweep& sweep, const description::Catalogue& catalogue, const sweeps::Store& store,
              std::size_t top);
  const sweeps::Summary& summary() const { return summary_; }
  void print_table() const;
  void print_json() const;
  /// "-" writes to standard output. Throws Error("unwritable").
  void write_csv(const std::string& file) const;
  void write_html(const std::string& file) const;

 private:
  void each(const std::function<void(const sweeps::Row&)>& take) const;

  const sweeps::Sweep& sweep_;
  const sweeps::Store& store_;
  sweeps::Variants variants_;
  mutable sweeps::RobotHashes robots_;
  sweeps::Summary summary_;
};

}  // namespace polyarm::apps
