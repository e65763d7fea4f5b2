#include "apps/sweep_report.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cstdio>
#include <utility>

#include "apps/client.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/sweeps/page.hpp"

namespace polyarm::apps {

namespace {

using sweeps::Row;
using sweeps::Share;

std::string number(const std::optional<double>& value, double scale, int digits, const char* unit) {
  return value ? fmt::format("{:.{}f}{}", *value * scale, digits, unit) : std::string("-");
}

std::string clearance_text(const Row& row) {
  if (!row.clearance_m) return "far";
  return fmt::format("{:.1f} mm {} - {}", 1e3 * *row.clearance_m, row.clearance_a, row.clearance_b);
}

void print_best(const sweeps::Summary& summary) {
  if (summary.best().empty()) return;
  std::vector<std::vector<std::string>> rows;
  const Row& first = summary.best().front();
  for (const Row& row : summary.best())
    rows.push_back({sweeps::title_of(row), number(row.cycle_s, 1, 3, " s"),
                    number(row.cycle_p95_s, 1, 3, " s"), clearance_text(row),
                    number(row.speed_share, 100, 0, " %"),
                    &row == &first ? "best" : sweeps::why_worse(row, first)});
  fmt::print("\n");
  print_table({"BEST FIRST", "CYCLE", "95 %", "CLEARANCE", "SPEED", "WHY"}, rows);
}

/// One table for each axis that has several values.
void print_axes(const sweeps::Summary& summary) {
  for (const auto& [axis, values] : summary.axes()) {
    constexpr std::size_t kMostShown = 20;
    if (values.size() < 2 || values.size() > kMostShown) continue;
    std::vector<std::vector<std::string>> rows;
    for (const auto& [value, share] : values) {
      const bool any = share.completed > 0;
      rows.push_back({value, std::to_string(share.ran), std::to_string(share.completed),
                      any ? fmt::format("{:.3f} s", share.cycle_best) : "-",
                      any ? fmt::format("{:.3f} s", share.cycle_mean()) : "-", share.main_code()});
    }
    std::string heading = axis;
    for (char& c : heading) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    fmt::print("\n");
    print_table({heading, "RAN", "COMPLETED", "BEST", "MEAN", "MAIN FAILURE"}, rows);
  }
}

void print_failures(const sweeps::Summary& summary) {
  if (!summary.examples().empty()) fmt::print("\nWhat did not complete:\n");
  for (const auto& [code, row] : summary.examples())
    fmt::print("  {} × {}: {}: {}{}\n", summary.total().codes.at(code), code, sweeps::title_of(row),
               row.place.empty() ? "" : row.place + ": ", row.cause);
}

}  // namespace

SweepReport::SweepReport(const sweeps::Sweep& sweep, const description::Catalogue& catalogue,
                         const sweeps::Store& store, std::size_t top)
    : sweep_(sweep), store_(store), variants_(sweep), robots_(catalogue), summary_(top) {
  each([this](const Row& row) { summary_.add(row); });
}

void SweepReport::each(const std::function<void(const Row&)>& take) const {
  for (std::uint64_t i = 0; i < variants_.count(); ++i) {
    const sweeps::Variant variant = variants_.at(i);
    if (const auto row = store_.find(sweeps::key_of(variant, robots_.of(variant.robot)))) take(*row);
  }
}

void SweepReport::print_table() const {
  fmt::print("{} of {} variants have a result, {} completed\n", summary_.rows(), variants_.count(),
             summary_.total().completed);
  print_best(summary_);
  const std::vector<Row> front = summary_.pareto();
  if (front.size() > 1) {
    fmt::print("\nNo variant is both faster and farther from everything than these:\n");
    for (const Row& row : front)
      fmt::print("  {}, {}: {}\n", number(row.cycle_s, 1, 3, " s"), clearance_text(row),
                 sweeps::title_of(row));
  }
  print_axes(summary_);
  print_failures(summary_);
}

void SweepReport::print_json() const {
  fmt::print("[");
  bool first = true;
  each([&](const Row& row) {
    fmt::print("{}{}", std::exchange(first, false) ? "\n" : ",\n", sweeps::to_json(row));
  });
  fmt::print("\n]\n");
}

void SweepReport::write_csv(const std::string& file) const {
  std::FILE* const out = file == "-" ? stdout : std::fopen(file.c_str(), "w");
  if (!out) throw Error("unwritable", file + " cannot be written");
  fmt::print(out, "{}\n", sweeps::csv_head());
  each([&](const Row& row) { fmt::print(out, "{}\n", sweeps::csv_line(row)); });
  if (out == stdout) return;
  const bool failed = std::ferror(out) != 0;
  if (std::fclose(out) != 0 || failed)
    throw Error("unwritable", file + " cannot be written; is the disk full?");
}

void SweepReport::write_html(const std::string& file) const {
  const std::string title = "Sweep of " + sweep_.cell.filename().string();
  write_file_atomically(file, sweeps::page_of(title, summary_, sweep_.clearance));
}

}  // namespace polyarm::apps
