#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/plan_motion.hpp"

namespace polyarm::apps {

using nlohmann::json;

namespace {

/// The largest magnitude and its share of the limit.
struct Use {
  double value, share;
};
Use use_of(const PlanJoint& joint, const PlanPeaks& peaks, std::size_t quantity) {
  const trajectory::MotionLimits& l = joint.limits;
  const double upper[] = {0, l.max_velocity, l.max_acceleration, l.max_jerk};
  const double lower[] = {0, l.min_velocity, l.min_acceleration, -l.max_jerk};
  const double high = peaks.high[quantity], low = peaks.low[quantity];
  return {std::max(high, -low), std::max(high / upper[quantity], low / lower[quantity])};
}

/// How long each limit is active, longest first: "elbow_joint velocity 42 %".
std::string shares(const PlannedMotion& motion, const PlanSection& section) {
  struct Share {
    std::size_t row;
    timing::LimitKind kind;
    double time;
  };
  std::vector<Share> all;
  for (const PlanBand& b : motion.bands) {
    const double time = std::min(b.to, section.end) - std::max(b.from, section.begin);
    if (!(time > 0)) continue;
    const auto same = std::find_if(all.begin(), all.end(),
                                   [&](const Share& s) { return s.row == b.row && s.kind == b.kind; });
    if (same == all.end())
      all.push_back({b.row, b.kind, time});
    else
      same->time += time;
  }
  std::stable_sort(all.begin(), all.end(), [](const Share& a, const Share& b) { return a.time > b.time; });
  std::string out;
  for (const Share& s : all) {
    const double share = s.time / (section.end - section.begin);
    if (share < 0.05 && !out.empty()) break;
    out += fmt::format("{}{} of {} {:.0f} %", out.empty() ? "" : ", ", name(s.kind), motion.row_name(s.row),
                       100 * share);
  }
  return out;
}

std::string text_of(const PlanClearance& c) {
  const std::string where = fmt::format("{} and {} at {:.3f} s, at ({:.3f}, {:.3f}, {:.3f})", c.first,
                                        c.second, c.time, c.point.x, c.point.y, c.point.z);
  return c.distance > 0 ? fmt::format("clearance: at least {:.1f} mm, between {}", 1000 * c.distance, where)
                        : fmt::format("contact: {:.1f} mm deep, between {}", -1000 * c.distance, where);
}

json json_of(const PlanClearance& c) {
  return {{"distance", c.distance},
          {"first", c.first},
          {"second", c.second},
          {"time", c.time},
          {"point", {c.point.x, c.point.y, c.point.z}}};
}

}  // namespace

std::string report_of(const PlannedMotion& motion) {
  std::string out = fmt::format("{}: {:.3f} s\n", motion.title, motion.duration);
  for (const PlanSection& s : motion.sections) {
    out += fmt::format("\n{}, {:.3f} to {:.3f} s\n", s.name, s.begin, s.end);
    if (s.clearance) out += "  " + text_of(*s.clearance) + "\n";
    if (motion.bands.empty()) continue;
    out += fmt::format("  bounded by {}\n", shares(motion, s));
    std::vector<PlanBand> own;
    for (const PlanBand& b : motion.bands)
      if (b.from >= s.begin - 1e-12 && b.to <= s.end + 1e-12) own.push_back(b);
    for (const PlanBand& b : merged(own, (s.end - s.begin) / 50))
      out += fmt::format("  {:8.3f} {:8.3f}  {} of {}\n", b.from, b.to, name(b.kind), motion.row_name(b.row));
  }
  double tcp = 0;
  const std::vector<PlanPeaks> peaks = peaks_of(motion, &tcp);
  std::size_t width = 5;
  for (const PlanJoint& joint : motion.joints) width = std::max(width, joint.name.size());
  out += fmt::format("\n{:<{}}  {:>8} {:>8}  {:>16} {:>16} {:>16}\n", "joint", width, "lowest", "highest",
                     "velocity", "acceleration", "jerk");
  for (std::size_t j = 0; j < peaks.size(); ++j) {
    const PlanJoint& joint = motion.joints[j];
    out += fmt::format("{:<{}}  {:8.3f} {:8.3f} ", joint.name, width, peaks[j].low[0], peaks[j].high[0]);
    for (std::size_t k = 1; k < 4; ++k) {
      const Use use = use_of(joint, peaks[j], k);
      out += fmt::format(" {:>9.4g} {:>4.0f} %", use.value, 100 * use.share);
    }
    out += "\n";
  }
  out += fmt::format("TCP: up to {:.4g} m/s", tcp);
  if (std::isfinite(motion.tcp_speed_limit)) out += fmt::format(" of {:.4g}", motion.tcp_speed_limit);
  out += "\n";
  if (const auto& c = motion.clearance; c && c->distance > 0) out += text_of(*c) + "\n";
  return out;
}

std::string json_of(const PlannedMotion& motion) {
  json sections = json::array(), joints = json::array(), problems = json::array();
  for (const PlanSection& s : motion.sections) {
    json bounds = json::array();
    for (const PlanBand& b : motion.bands)
      if (b.from >= s.begin - 1e-12 && b.to <= s.end + 1e-12)
        bounds.push_back(
            {{"from", b.from}, {"to", b.to}, {"row", motion.row_name(b.row)}, {"limit", name(b.kind)}});
    sections.push_back({{"name", s.name}, {"begin", s.begin}, {"end", s.end}, {"bounded_by", bounds}});
    if (s.clearance) sections.back()["clearance"] = json_of(*s.clearance);
  }
  double tcp = 0;
  const std::vector<PlanPeaks> peaks = motion.at ? peaks_of(motion, &tcp) : std::vector<PlanPeaks>{};
  for (std::size_t j = 0; j < peaks.size(); ++j) {
    const PlanJoint& joint = motion.joints[j];
    json one = {{"name", joint.name}, {"lowest", peaks[j].low[0]}, {"highest", peaks[j].high[0]}};
    for (std::size_t k = 1; k < 4; ++k) {
      const Use use = use_of(joint, peaks[j], k);
      one[kQuantities[k]] = {{"peak", use.value}, {"share", use.share}};
    }
    joints.push_back(one);
  }
  for (const Problem& p : motion.problems)
    problems.push_back({{"code", p.code},
                        {"file", p.where.file},
                        {"line", p.where.line},
                        {"text", p.what},
                        {"advice", p.advice},
                        {"severity", p.severity == Severity::error ? "error" : "warning"}});
  json out = {{"result", motion.has_errors() ? "failed" : "ok"},
              {"duration", motion.duration},
              {"sections", sections},
              {"joints", joints},
              {"tcp_speed", tcp},
              {"problems", problems}};
  if (motion.clearance) out["clearance"] = json_of(*motion.clearance);
  return out.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string csv_of(const PlannedMotion& motion, double rate) {
  std::string out = "time";
  for (const char* quantity : kQuantities)
    for (const PlanJoint& joint : motion.joints) out += fmt::format(",{} {}", joint.name, quantity);
  out += ",tcp x,tcp y,tcp z,tcp speed\n";
  PlanState state(motion.joints.size());
  const auto whole = std::size_t(motion.duration * rate * (1 - 1e-9));
  for (std::size_t i = 0; i <= whole + 1; ++i) {
    const double t = i <= whole ? double(i) / rate : motion.duration;
    motion.at(t, state);
    out += fmt::format("{:.9g}", t);
    for (const std::vector<double>& list : state.value)
      for (const double v : list) out += fmt::format(",{:.9g}", v);
    out +=
        fmt::format(",{:.9g},{:.9g},{:.9g},{:.9g}\n", state.tcp.x, state.tcp.y, state.tcp.z, state.tcp_speed);
  }
  return out;
}

}  // namespace polyarm::apps
