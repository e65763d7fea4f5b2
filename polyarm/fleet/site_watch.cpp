#include "polyarm/fleet/site_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/fleet/cell_client.hpp"

namespace polyarm::fleet {

using Json = nlohmann::json;

namespace {

constexpr std::size_t kMostSummary =
    bounds::kSiteSummaryBytes;  // the page shows those of all cells again and again

double steady_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string address_of(const SiteCell& cell) {
  return fmt::format("{}://{}:{}", cell.tls ? "https" : "http", cell.host, cell.port);
}

/// A text of a stranger's JSON, printable and short.
std::string short_text_at(const Json& map, const char* key) {
  if (!map.is_object()) return {};
  const auto found = map.find(key);
  if (found == map.end() || !found->is_string()) return {};
  return printable_line(found->get<std::string>().substr(0, 300));
}

Json part_of(const Json& map, const char* key) {
  return map.is_object() && map.contains(key) && map[key].is_object() ? map[key] : Json::object();
}

std::string percent(const std::optional<double>& share) {
  return share ? fmt::format("{:.1f}", 100 * *share) : "–";
}

/// What a person needs to know: why it does not answer, or why it does not run.
std::string words_of(const CellReport& report) {
  if (!report.answers) return report.trouble;
  if (const std::string failure = short_text_at(report.summary, "failure"); !failure.empty()) return failure;
  const std::string cause = short_text_at(part_of(report.summary, "cause"), "what");
  const std::string problem = short_text_at(part_of(report.summary, "program"), "problem");
  return !cause.empty() ? cause : problem;
}

}  // namespace

SiteWatch::SiteWatch(const Site& site, double every_s, double timeout_s)
    : site_(site),
      every_s_(every_s),
      timeout_s_(timeout_s),
      reports_(site.cells.size()),
      answered_(site.cells.size(), 0) {
  for (std::size_t i = 0; i < site_.cells.size(); ++i) {
    reports_[i].name = site_.cells[i].name;
    reports_[i].address = address_of(site_.cells[i]);
  }
  for (std::size_t i = 0; i < site_.cells.size(); ++i) threads_.emplace_back([this, i] { ask(i); });
}

SiteWatch::~SiteWatch() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  for (std::thread& each : threads_) each.join();
}

std::string SiteWatch::trouble_of(std::size_t cell, Json& summary) const {
  try {
    const std::string text = CellClient(site_.cells[cell], timeout_s_).get("/api/summary");
    if (text.size() > kMostSummary)
      return "its answer is longer than " + std::to_string(kMostSummary) + " bytes";
    summary = parse_answer(text);
    return summary.is_object() ? "" : "its answer is no JSON object: is it a cell of this version?";
  } catch (const Error& e) {
    return e.problems().front().what;
  } catch (const std::exception& e) {
    return e.what();
  }
}

void SiteWatch::ask(std::size_t cell) {
  for (;;) {
    Json summary;
    std::string trouble = trouble_of(cell, summary);
    std::unique_lock lock(mutex_);
    CellReport& report = reports_[cell];
    report.asked = true;
    report.answers = trouble.empty();
    report.trouble = printable_line(trouble);
    if (report.answers) {
      report.oee = oee_of(summary, site_.cells[cell].ideal_cycle_s);
      report.summary = std::move(summary);
      answered_[cell] = steady_now();
    }
    changed_.notify_all();
    if (every_s_ <= 0 ||
        changed_.wait_for(lock, std::chrono::duration<double>(every_s_), [&] { return over_; }))
      return;
  }
}

std::vector<CellReport> SiteWatch::reports() const {
  const std::lock_guard lock(mutex_);
  std::vector<CellReport> out = reports_;
  for (std::size_t i = 0; i < out.size(); ++i)
    if (answered_[i] > 0) out[i].age_s = steady_now() - answered_[i];
  return out;
}

void SiteWatch::wait_for_first() const {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    return std::all_of(reports_.begin(), reports_.end(), [](const CellReport& each) { return each.asked; });
  });
}

std::string table_of(const std::vector<CellReport>& reports) {
  std::string out = fmt::format("{:<20} {:<9} {:<10} {:>7} {:>6} {:>6} {:>6} {:>6}  {:<10} {}\n", "cell",
                                "state", "program", "passes", "avail", "perf", "qual", "OEE", "version", "");
  std::size_t answer = 0;
  for (const CellReport& each : reports) {
    answer += each.answers ? 1 : 0;
    const Json program = part_of(each.summary, "program");
    const auto passes = each.summary.is_object() && each.summary.contains("passes") &&
                                each.summary["passes"].is_number_unsigned()
                            ? each.summary["passes"].get<std::uint64_t>()
                            : 0;
    out +=
        fmt::format("{:<20} {:<9} {:<10} {:>7} {:>6} {:>6} {:>6} {:>6}  {:<10} {}\n", each.name,
                    each.answers ? short_text_at(each.summary, "state") : "silent",
                    each.answers ? short_text_at(program, "state") : "", passes,
                    percent(each.oee.availability), percent(each.oee.performance), percent(each.oee.quality),
                    percent(each.oee.whole), short_text_at(each.summary, "version"), words_of(each));
  }
  return out + fmt::format("{} of {} cells answer\n", answer, reports.size());
}

Json json_of(const std::vector<CellReport>& reports) {
  Json out = Json::array();
  for (const CellReport& each : reports) {
    const auto share = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
    out.push_back({{"name", each.name},
                   {"address", each.address},
                   {"answers", each.answers},
                   {"trouble", each.trouble},
                   {"words", words_of(each)},
                   {"age_s", each.age_s},
                   {"summary", each.summary},
                   {"oee",
                    {{"availability", share(each.oee.availability)},
                     {"performance", share(each.oee.performance)},
                     {"quality", share(each.oee.quality)},
                     {"oee", share(each.oee.whole)}}}});
  }
  return out;
}

}  // namespace polyarm::fleet
