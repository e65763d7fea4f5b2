#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "apps/plan_motion.hpp"

namespace polyarm::apps {

namespace {

constexpr double kLeft = 84, kPlotWidth = 700, kHeight = 120, kGap = 24, kTop = 54, kLegend = 170;
constexpr std::size_t kSamples = 6000;
// Colours that colour-blind readers can distinguish (Okabe and Ito, Color Universal Design, 2008), and more.
constexpr const char* kColors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9",
                                   "#7f5539", "#6a4c93", "#444444", "#8ac926", "#c1121f", "#2a9d8f"};
const char* color(std::size_t i) {
  return kColors[i % std::size(kColors)];
}

using Points = std::vector<std::pair<double, double>>;

/// Simplifies a line: keeps the points needed for a vertical error within `tolerance` (Ramer 1972, Douglas
/// and Peucker 1973).
void keep(const Points& all, std::size_t from, std::size_t to, double tolerance, std::vector<char>& kept) {
  double most = tolerance;
  std::size_t at = 0;
  for (std::size_t i = from + 1; i < to; ++i) {
    const double x = all[to].first - all[from].first;
    const double share = x > 0 ? (all[i].first - all[from].first) / x : 0;
    const double off =
        std::abs(all[i].second - all[from].second - share * (all[to].second - all[from].second));
    if (off > most) most = off, at = i;
  }
  if (at == 0) return;
  kept[at] = 1;
  keep(all, from, at, tolerance, kept), keep(all, at, to, tolerance, kept);
}

std::string line_of(const Points& all, const char* stroke) {
  std::vector<char> kept(all.size(), 0);
  kept.front() = kept.back() = 1;
  keep(all, 0, all.size() - 1, 0.2, kept);
  std::string out = "<path fill=\"none\" stroke=\"" + std::string(stroke) + "\" d=\"M";
  for (std::size_t i = 0; i < all.size(); ++i)
    if (kept[i]) out += fmt::format("{}{:.1f} {:.1f}", i > 0 ? "L" : "", all[i].first, all[i].second);
  return out + "\"/>\n";
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<'   ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '&' ? "&amp;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  return out;
}

std::string text_at(double x, double y, const std::string& text, const char* anchor = "start") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
                     escaped(text));
}

/// Grid step: 1, 2 or 5 times a power of ten, about `span` / 5.
double step_for(double span) {
  const double rough = span / 5, power = std::pow(10, std::floor(std::log10(rough)));
  return (rough > 5 * power ? 10 : rough > 2 * power ? 5 : rough > power ? 2 : 1) * power;
}

class Plot {
 public:
  explicit Plot(const PlannedMotion& motion)
      : m_(motion), states_(kSamples + 1, PlanState(motion.joints.size())) {
    for (std::size_t i = 0; i <= kSamples; ++i) m_.at(time(i), states_[i]);
  }

  std::string draw() {
    body_ += text_at(kLeft, 20, fmt::format("{}: {:.3f} s", m_.title, m_.duration));
    legend();
    positions();
    for (std::size_t k = 1; k < 4; ++k) shares(k);
    tcp_speed();
    if (!m_.bands.empty()) bands();
    time_axis();
    const double height = top_ + 34, width = kLeft + kPlotWidth + kLegend;
    return fmt::format(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
               "height=\"{1:.0f}\" font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"{0:.0f}\" "
               "height=\"{1:.0f}\" fill=\"#fff\"/>\n",
               width, height) +
           body_ + "</svg>\n";
  }

 private:
  double time(std::size_t i) const { return m_.duration * double(i) / double(kSamples); }
  double across(double t) const { return kLeft + kPlotWidth * t / m_.duration; }

  /// Starts a panel from `low` to `high` with its grid; up() then maps the values.
  void open(const std::string& title, double low, double high, const std::string& unit, double factor = 1) {
    if (!(high - low > 1e-12)) low -= 0.5, high += 0.5;
    low_ = low, high_ = high;
    body_ += fmt::format(
        "<rect x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\" fill=\"#f8f9fa\" stroke=\"#adb5bd\"/>\n",
        kLeft, top_, kPlotWidth, kHeight);
    const double step = step_for((high - low) * factor) / factor;
    for (double v = std::ceil(low / step - 1e-9) * step; v <= high + 1e-9 * step; v += step) {
      const double y = up(v), shown = std::abs(v) < 1e-9 * step ? 0 : v * factor;
      body_ += fmt::format("<path d=\"M{} {:.1f}h{}\" stroke=\"#0001\"/>\n", kLeft, y, kPlotWidth);
      body_ += text_at(kLeft - 4, y + 4, fmt::format("{:.4g}", shown), "end");
    }
    body_ += text_at(kLeft + kPlotWidth + 8, top_ + 12, title);
    body_ += text_at(kLeft + kPlotWidth + 8, top_ + 26, unit);
    for (std::size_t i = 1; i < m_.sections.size(); ++i)
      body_ += fmt::format("<path d=\"M{:.1f} {:.1f}v{}\" stroke=\"#868e96\" stroke-dasharray=\"2 3\"/>\n",
                           across(m_.sections[i].begin), top_, kHeight);
  }
  void close() { top_ += kHeight + kGap; }
  double up(double v) const {
    const double share = std::clamp((v - low_) / (high_ - low_), -0.02, 1.02);
    return top_ + kHeight * (1 - share);
  }
  void limit(double v, const char* stroke) {
    if (v < low_ || v > high_) return;
    body_ += fmt::format(
        "<path d=\"M{} {:.1f}h{}\" stroke=\"{}\" stroke-width=\"1.2\" stroke-dasharray=\"6 3\"/>\n", kLeft,
        up(v), kPlotWidth, stroke);
  }
  template <typename Value>
  void curve(Value value, const char* stroke) {
    Points points;
    for (std::size_t i = 0; i <= kSamples; ++i) points.emplace_back(across(time(i)), up(value(states_[i])));
    body_ += line_of(points, stroke);
  }

  /// Draws the legend of joint colours, in as many lines as needed; moves the following panels down.
  void legend() {
    double x = kLeft, y = 36;
    for (std::size_t j = 0; j < m_.joints.size(); ++j) {
      const double width = 30 + 6.4 * double(m_.joints[j].name.size());
      if (x > kLeft && x + width > kLeft + kPlotWidth + kLegend) x = kLeft, y += 16;
      body_ += fmt::format("<path d=\"M{:.1f} {}h14\" stroke=\"{}\" stroke-width=\"3\"/>\n", x, y, color(j));
      body_ += text_at(x + 18, y + 4, m_.joints[j].name);
      x += width;
    }
    top_ = y + kTop - 36;
  }
  void positions() {
    double low = INFINITY, high = -INFINITY;
    bool turns = false, slides = false;
    for (std::size_t j = 0; j < m_.joints.size(); ++j) {
      for (const PlanState& s : states_)
        low = std::min(low, s.value[0][j]), high = std::max(high, s.value[0][j]);
      (m_.joints[j].slides ? slides : turns) = true;
    }
    const double room = std::max(0.06 * (high - low), 1e-3);
    open("position", low - room, high + room, turns && slides ? "rad, m" : slides ? "m" : "rad");
    for (std::size_t j = 0; j < m_.joints.size(); ++j) {
      limit(m_.joints[j].lower, color(j)), limit(m_.joints[j].upper, color(j));
      curve([&](const PlanState& s) { return s.value[0][j]; }, color(j));
    }
    close();
  }
  /// Draws a quantity as a share of the limits, because limits differ between joints.
  void shares(std::size_t quantity) {
    const auto share = [&](const PlanState& s, std::size_t j) {
      const trajectory::MotionLimits& l = m_.joints[j].limits;
      const double high[] = {0, l.max_velocity, l.max_acceleration, l.max_jerk};
      const double low[] = {0, l.min_velocity, l.min_acceleration, -l.max_jerk};
      const double v = s.value[quantity][j];
      return v < 0 ? -v / low[quantity] : v / high[quantity];
    };
    double most = 1.1;
    for (const PlanState& s : states_)
      for (std::size_t j = 0; j < m_.joints.size(); ++j) most = std::max(most, 1.05 * std::abs(share(s, j)));
    open(kQuantities[quantity], -most, most, "% of each limit", 100);
    limit(1, "#c1121f"), limit(-1, "#c1121f");
    for (std::size_t j = 0; j < m_.joints.size(); ++j)
      curve([&](const PlanState& s) { return share(s, j); }, color(j));
    limits_of(quantity);
    close();
  }
  /// Prints the value of 100 %: that of all joints, or the smallest and the largest.
  void limits_of(std::size_t quantity) {
    for (const bool slides : {false, true}) {
      double least = INFINITY, most = 0;
      std::string unit;
      for (const PlanJoint& j : m_.joints) {
        if (j.slides != slides) continue;
        const double v = quantity == 1   ? j.limits.max_velocity
                         : quantity == 2 ? j.limits.max_acceleration
                                         : j.limits.max_jerk;
        least = std::min(least, v), most = std::max(most, v), unit = unit_of(j, quantity);
      }
      if (unit.empty()) continue;
      const std::string range = most - least < 1e-9 * most ? fmt::format("{:.4g}", most)
                                                           : fmt::format("{:.4g} to {:.4g}", least, most);
      body_ += text_at(kLeft + kPlotWidth + 8, top_ + (slides ? 54 : 40), range + " " + unit);
    }
  }
  void tcp_speed() {
    double most = std::isfinite(m_.tcp_speed_limit) ? m_.tcp_speed_limit : 0;
    for (const PlanState& s : states_) most = std::max(most, s.tcp_speed);
    open("TCP speed", 0, 1.08 * std::max(most, 1e-6), "m/s");
    limit(m_.tcp_speed_limit, "#c1121f");
    curve([](const PlanState& s) { return s.tcp_speed; }, "#212529");
    close();
  }
  /// Draws the active limits over time: one row per kind of limit, in the joint's colour.
  void bands() {
    constexpr const char* kKinds[] = {"velocity", "acceleration", "jerk"};
    body_ += text_at(kLeft + kPlotWidth + 8, top_ + 12, "what bounds it");
    for (std::size_t k = 0; k < 3; ++k)
      body_ += text_at(kLeft - 4, top_ + 11 + 14 * double(k), kKinds[k], "end");
    for (const PlanBand& b : merged(m_.bands, m_.duration / kPlotWidth)) {
      const char* fill = b.row < m_.joints.size() ? color(b.row) : "#212529";
      body_ += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"12\" fill=\"{}\"/>\n",
                           across(b.from), top_ + 14 * double(b.kind), across(b.to) - across(b.from), fill);
    }
    body_ += fmt::format(
        "<rect x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"42\" fill=\"none\" "
        "stroke=\"#adb5bd\"/>\n",
        kLeft, top_ - 1, kPlotWidth);
    top_ += 42;
  }
  void time_axis() {
    const double step = step_for(m_.duration * 0.6);
    for (double t = 0; t <= m_.duration * (1 + 1e-9); t += step)
      body_ += text_at(across(t), top_ + 14, fmt::format("{:.4g}", t), "middle");
    body_ += text_at(kLeft + kPlotWidth + 8, top_ + 14, "s");
  }

  const PlannedMotion& m_;
  std::vector<PlanState> states_;
  std::string body_;
  double top_ = 0, low_ = 0, high_ = 1;
};

}  // namespace

std::string svg_of(const PlannedMotion& motion) {
  return Plot(motion).draw();
}

}  // namespace polyarm::apps
