#include "polyarm/sweeps/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

namespace polyarm::sweeps {

namespace {

constexpr std::size_t kMostMaps = 12;  // robots with a map of their own
constexpr double kCell = 34, kMargin = 64, kHead = 26, kLegend = 70;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

struct Colour {
  double r, g, b;
};
/// From good (0) to bad (1): blue-green over yellow to red-orange; distinct for people who see red and green
/// alike.
std::string colour(double share) {
  constexpr Colour kStops[] = {
      {33, 102, 172}, {146, 197, 222}, {247, 247, 214}, {244, 165, 130}, {178, 24, 43}};
  const double at = std::clamp(share, 0.0, 1.0) * 4;
  const std::size_t i = std::min<std::size_t>(3, static_cast<std::size_t>(at));
  const double t = at - static_cast<double>(i);
  const auto mix = [&](double a, double b) { return static_cast<int>(std::lround(a + t * (b - a))); };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(kStops[i].r, kStops[i + 1].r),
                     mix(kStops[i].g, kStops[i + 1].g), mix(kStops[i].b, kStops[i + 1].b));
}

/// A quantity that a map shows.
struct Quantity {
  std::string title, unit;
  double scale = 1;
  int digits = 2;
  bool large_is_good = false;
  std::function<double(const Row&)> of;
};

struct Range {
  double low = 0, high = 0;
  double share(double value, bool large_is_good) const {
    const double up = high > low ? (value - low) / (high - low) : 0;
    return large_is_good ? 1 - up : up;
  }
};

/// The same for all maps, so that their colours compare.
Range range_of(const std::map<std::string, Summary::Map>& maps, const Quantity& quantity) {
  Range out;
  bool first = true;
  for (const auto& [robot, map] : maps)
    for (const auto& [at, row] : map) {
      if (!row.completed()) continue;
      const double value = quantity.of(row);
      out.low = first ? value : std::min(out.low, value);
      out.high = first ? value : std::max(out.high, value);
      first = false;
    }
  return out;
}

std::string text_at(double x, double y, const std::string& text, const char* anchor = "middle") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>", x, y, anchor,
                     escaped(text));
}

std::string legend(double x, double height, const Quantity& quantity, const Range& range) {
  std::string out;
  constexpr int kSteps = 20;
  const double step = height / kSteps;
  for (int i = 0; i < kSteps; ++i) {  // the high value above
    const double value = range.high + (range.low - range.high) * (i + 0.5) / kSteps;
    out += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"12\" height=\"{:.2f}\" fill=\"{}\"/>", x,
                       kHead + i * step, step + 0.5, colour(range.share(value, quantity.large_is_good)));
  }
  const auto label = [&](double value) {
    return fmt::format("{:.{}f} {}", value * quantity.scale, quantity.digits, quantity.unit);
  };
  out += text_at(x + 16, kHead + 9, label(range.high), "start");
  if (range.high > range.low) out += text_at(x + 16, kHead + height, label(range.low), "start");
  return out;
}

std::string label_of(const Row& row, double value, const Quantity& quantity) {
  const std::string number = fmt::format("{:.{}f}", value * quantity.scale, quantity.digits);
  return quantity.large_is_good && !row.clearance_m ? ">" + number : number;
}

std::string map_of(const Summary::Map& map, const Quantity& quantity, const Range& range) {
  std::set<double> xs, ys;
  for (const auto& [at, row] : map) xs.insert(at.first), ys.insert(at.second);
  const double width = static_cast<double>(xs.size()) * kCell,
               height = static_cast<double>(ys.size()) * kCell;
  std::string out = fmt::format(
      "<svg width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\" "
      "aria-label=\"{2}\">",
      kMargin + width + kLegend + 30, std::max(kHead + height, kHead + 60) + 44, escaped(quantity.title));
  out += text_at(kMargin, 14, quantity.title, "start");
  for (const auto& [at, row] : map) {
    const double x = kMargin + kCell * static_cast<double>(std::distance(xs.begin(), xs.find(at.first))),
                 y = kHead + height -
                     kCell * static_cast<double>(std::distance(ys.begin(), ys.find(at.second)) + 1);
    const bool completed = row.completed();
    const double value = completed ? quantity.of(row) : 0, share = range.share(value, quantity.large_is_good);
    const std::string label = completed ? label_of(row, value, quantity) : std::string("×");
    out += fmt::format(
        "<g><title>{}</title><rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>"
        "<text class=\"v\" x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\">{}</text></g>",
        escaped(title_of(row) + ": " + (completed ? label + " " + quantity.unit : row.cause)), x, y,
        kCell - 1, kCell - 1, completed ? colour(share) : "#dddddd", x + kCell / 2, y + kCell / 2 + 3,
        completed && (share < 0.15 || share > 0.9) ? "#ffffff" : "#222222", label);
  }
  const auto number = [](double value) { return fmt::format("{:.4g}", value); };
  const std::size_t every = xs.size() > 12 ? 2 : 1;
  std::size_t i = 0;
  for (const double x : xs)
    if (i++ % every == 0)
      out += text_at(kMargin + kCell * (static_cast<double>(i) - 0.5), kHead + height + 14, number(x));
  i = 0;
  for (const double y : ys)
    out +=
        text_at(kMargin - 6, kHead + height - kCell * (static_cast<double>(i++) + 0.5) + 3, number(y), "end");
  // A map of few squares is smaller than its legend and its labels.
  out += text_at(kMargin + width / 2, kHead + std::max(height, 60.0) + 30, "x of the base, m");
  const double middle = kHead + std::max(height / 2, 20.0);
  out += fmt::format(
      "<text x=\"14\" y=\"{0:.1f}\" text-anchor=\"middle\" transform=\"rotate(-90 14 {0:.1f})\">y of "
      "the base, m</text>",
      middle);
  return out + legend(kMargin + width + 10, std::max(height - 1, 60.0), quantity, range) + "</svg>";
}

std::string maps_of(const Summary& summary, double measured) {
  std::map<std::string, Summary::Map> maps;
  for (const auto& [robot, map] : summary.maps())
    if (map.size() > 1) maps.insert({robot, map});
  if (maps.empty()) return {};
  const Quantity cycle{
      "cycle time", "s", 1, 2, false, [](const Row& row) { return row.cycle_s.value_or(0); }};
  const Quantity near{"clearance", "mm",
                      1000,        0,
                      true,        [measured](const Row& row) { return row.clearance_m.value_or(measured); }};
  std::vector<std::pair<std::string, const Summary::Map*>> order;  // the robots that are best first
  for (const auto& [robot, map] : maps) order.emplace_back(robot, &map);
  const auto best = [&](const std::string& robot) {
    const auto at = summary.best_of_robot().find(robot);
    return at == summary.best_of_robot().end() ? 1e300 : at->second.cycle_s.value_or(1e300);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](const auto& a, const auto& b) { return best(a.first) < best(b.first); });
  std::string out =
      "<h2>Where the base stands</h2><p>Each square is the best variant with the base there. × : none "
      "completed; the pointer on it shows why. Colours compare between robots.</p>";
  if (order.size() > kMostMaps)
    out += fmt::format("<p>The {} best robots of {}.</p>", kMostMaps, order.size()), order.resize(kMostMaps);
  const Range cycles = range_of(maps, cycle), clearances = range_of(maps, near);
  for (const auto& [robot, map] : order)
    out += "<h3>" + escaped(robot.empty() ? "the robot of the cell" : robot) + "</h3><div class=\"maps\">" +
           map_of(*map, cycle, cycles) + map_of(*map, near, clearances) + "</div>\n";
  return out;
}

/// The best of each robot over cycle time and clearance; filled: no robot is better in both.
std::string robots_of(const Summary& summary, double measured) {
  const auto& best = summary.best_of_robot();
  if (best.size() < 2) return {};
  std::set<std::string> front;
  for (const Row& row : summary.pareto()) front.insert(row.robot);
  double fast = 1e300, slow = 0, far = 1e-3;
  const auto near = [&](const Row& row) { return row.clearance_m.value_or(measured); };
  for (const auto& [robot, row] : best) {
    fast = std::min(fast, *row.cycle_s);
    slow = std::max(slow, *row.cycle_s);
    far = std::max(far, near(row));
  }
  const double pad = slow > fast ? 0.08 * (slow - fast) : 0.1 * slow, left = fast - pad, right = slow + pad;
  constexpr double kWidth = 760, kHeight = 320;
  const auto x_of = [&](double cycle) { return 60 + (kWidth - 220) * (cycle - left) / (right - left); };
  const auto y_of = [&](double m) { return kHeight - 44 - (kHeight - 70) * std::max(0.0, m) / (1.08 * far); };
  std::string out = fmt::format(
      "<h2>Robots</h2><p>The fastest variant of each robot. Filled: no other robot has a variant "
      "that is faster and keeps more clearance.</p>"
      "<svg width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\" "
      "aria-label=\"robots by cycle time and clearance\">",
      kWidth, kHeight);
  out +=
      fmt::format("<path d=\"M60 20V{0}H{1}\" fill=\"none\" stroke=\"#888\"/>", kHeight - 44, kWidth - 140);
  for (int i = 0; i <= 4; ++i) {
    const double cycle = left + (right - left) * i / 4, m = 1.08 * far * i / 4;
    out += text_at(x_of(cycle), kHeight - 28, fmt::format("{:.2f}", cycle));
    out += text_at(54, y_of(m) + 4, fmt::format("{:.0f}", 1e3 * m), "end");
  }
  out += text_at(kWidth / 2 - 60, kHeight - 8, "cycle time, s") + text_at(60, 14, "clearance, mm", "start");
  std::vector<std::pair<double, double>> labels;  // places that are taken
  for (const auto& [robot, row] : best) {
    const bool filled = front.contains(robot);
    const double x = x_of(*row.cycle_s), y = y_of(near(row));
    out += fmt::format(
        "<g><title>{}</title><circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" fill=\"{}\" "
        "stroke=\"#2166ac\" stroke-width=\"1.5\"/></g>",
        escaped(title_of(row)), x, y, filled ? "#2166ac" : "#ffffff");
    double at = y + 4;
    const auto taken = [&] {
      return std::any_of(labels.begin(), labels.end(), [&](const auto& label) {
        return std::abs(label.first - x) < 130 && std::abs(label.second - at) < 12;
      });
    };
    for (int tries = 0; taken() && tries < 20; ++tries) at -= 12;
    labels.emplace_back(x, at);
    if (at > 8) out += text_at(x + 9, at, robot.empty() ? "of the cell" : robot, "start");
  }
  return out + "</svg>\n";
}

std::string row_of_table(const std::vector<std::string>& cells) {
  std::string out = "<tr>";
  for (const std::string& cell : cells) out += "<td>" + escaped(cell) + "</td>";
  return out + "</tr>\n";
}

std::string near_text(const Row& row) {
  if (!row.clearance_m) return "nothing near";
  return fmt::format("{:.0f} mm: {} to {} at {:.1f} s", 1e3 * *row.clearance_m, row.clearance_a,
                     row.clearance_b, row.clearance_at_s.value_or(0));
}

std::string best_of(const Summary& summary) {
  if (summary.best().empty()) return "<p>No variant completed.</p>";
  std::string out =
      "<h2>Best</h2><table><tr><th>variant</th><th>cycle, s</th><th>95 %, "
      "s</th><th>clearance</th><th>highest "
      "speed</th><th>why not first</th></tr>\n";
  const Row& first = summary.best().front();
  for (const Row& row : summary.best())
    out += row_of_table({title_of(row), fmt::format("{:.3f}", row.cycle_s.value_or(0)),
                         fmt::format("{:.3f}", row.cycle_p95_s.value_or(0)), near_text(row),
                         fmt::format("{:.0f} % {}", 100 * row.speed_share.value_or(0), row.speed_joint),
                         &row == &first ? "" : why_worse(row, first)});
  return out + "</table>\n";
}

std::string axes_of(const Summary& summary) {
  std::string out;
  for (const auto& [axis, values] : summary.axes()) {
    if (values.size() < 2 || axis == "base") continue;
    out += "<h3>" + escaped(axis) +
           "</h3><table><tr><th>value</th><th>ran</th><th>completed</th><th>best cycle, s</th>"
           "<th>mean, s</th><th>why not</th></tr>\n";
    for (const auto& [value, share] : values)
      out +=
          row_of_table({value, std::to_string(share.ran), std::to_string(share.completed),
                        share.completed ? fmt::format("{:.3f}", share.cycle_best) : "",
                        share.completed ? fmt::format("{:.3f}", share.cycle_mean()) : "", share.main_code()});
    out += "</table>\n";
  }
  return out.empty() ? out : "<h2>What made others worse</h2>" + out;
}

std::string failures_of(const Summary& summary) {
  if (summary.examples().empty()) return {};
  std::string out =
      "<h2>Why variants did not complete</h2><table><tr><th>code</th><th>variants</th><th>one of "
      "them</th><th>"
      "cause</th></tr>\n";
  for (const auto& [code, row] : summary.examples())
    out += row_of_table({code, std::to_string(summary.total().codes.at(code)), title_of(row),
                         row.place.empty() ? row.cause : row.place + ": " + row.cause});
  return out + "</table>\n";
}

}  // namespace

std::string page_of(const std::string& title, const Summary& summary, double measured) {
  return "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>" + escaped(title) +
         "</title><style>body{font:14px/1.5 system-ui,sans-serif;margin:2em "
         "auto;max-width:70em;color:#222;background:"
         "#fff}table{border-collapse:collapse}td,th{border-bottom:1px solid #ddd;padding:3px "
         "10px;text-align:left;"
         "vertical-align:top}svg text{font:11px system-ui,sans-serif}svg text:not(.v){fill:#222}svg "
         "text.v{font-size:"
         "10px;text-anchor:middle}.maps{display:flex;flex-wrap:wrap;gap:24px}</style></head><body>\n<h1>" +
         escaped(title) + "</h1>\n" +
         fmt::format(
             "<p>{} variants, {} completed. Measured on simulated robots; nothing here was measured on a "
             "real "
             "one.</p>\n",
             summary.rows(), summary.total().completed) +
         best_of(summary) + maps_of(summary, measured) + robots_of(summary, measured) + axes_of(summary) +
         failures_of(summary) + "</body></html>\n";
}

}  // namespace polyarm::sweeps
