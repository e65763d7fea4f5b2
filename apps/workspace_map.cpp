#include "apps/workspace_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/singularity.hpp"

namespace polyarm::apps {

namespace {

using kinematics::Chain;

/// The plane's axes as indices of x, y, z: across, up, and the third.
std::array<int, 3> axes_of(const std::string& plane) {
  if (plane == "xz") return {0, 2, 1};
  if (plane == "xy") return {0, 1, 2};
  if (plane == "yz") return {1, 2, 0};
  throw Error("bad-value", "'" + plane + "' is not a plane", "xz, xy or yz");
}

Vec3 placed(const std::array<int, 3>& axes, double across, double up, double third) {
  std::array<double, 3> out{};
  out[static_cast<std::size_t>(axes[0])] = across;
  out[static_cast<std::size_t>(axes[1])] = up;
  out[static_cast<std::size_t>(axes[2])] = third;
  return {out[0], out[1], out[2]};
}

class Asker {
 public:
  Asker(const Chain& chain, std::vector<double> home, const std::optional<Quaternion>& rotation)
      : solver_(chain, settings()), home_(std::move(home)), rotation_(rotation) {}
  bool closed_form() const { return solver_ && solver_.complete() && rotation_; }

  /// Joint states for the TCP at these positions; empty where none was found. `above`: results of the row
  /// before.
  std::vector<std::vector<double>> ask(const std::vector<Vec3>& places,
                                       const std::vector<std::vector<double>>& above) const {
    if (closed_form()) return ask_at_once(places);
    std::vector<std::vector<double>> out;
    for (std::size_t k = 0; k < places.size(); ++k) {
      const std::vector<double>& seed = !above[k].empty()              ? above[k]
                                        : k > 0 && !out[k - 1].empty() ? out[k - 1]
                                                                       : home_;
      const ik::IkTask task = rotation_ ? ik::IkTask{} : ik::IkTask::position_only();
      ik::IkSolution found;
      const bool there = solver_.solve({places[k], rotation_.value_or(Quaternion{})}, task, seed, found) ==
                         ik::IkOutcome::solved;
      out.push_back(there ? values_of(found) : std::vector<double>{});
    }
    return out;
  }

 private:
  static ik::IkSettings settings() {
    ik::IkSettings out;
    out.restarts = 6;
    out.descent_tolerance = 1e-5;
    return out;
  }
  std::vector<double> values_of(const ik::IkSolution& one) const {
    return {one.q.begin(), one.q.begin() + static_cast<std::ptrdiff_t>(home_.size())};
  }

  std::vector<std::vector<double>> ask_at_once(const std::vector<Vec3>& places) const {
    std::vector<Pose> targets;
    for (const Vec3& place : places) targets.push_back({place, *rotation_});
    std::vector<ik::IkSolution> found(targets.size());
    std::vector<ik::IkOutcome> outcomes(targets.size());
    solver_.solve_batch(targets, home_, found, outcomes);
    std::vector<std::vector<double>> out(targets.size());
    for (std::size_t k = 0; k < targets.size(); ++k)
      if (outcomes[k] == ik::IkOutcome::solved) out[k] = values_of(found[k]);
    return out;
  }

  ik::InverseKinematics solver_;
  std::vector<double> home_;
  std::optional<Quaternion> rotation_;
};

/// sqrt(det(J J^T)) of the Jacobian's linear rows; lengths in units of the arm's reach.
double manipulability_of(const Chain& chain, const std::vector<double>& q) {
  const std::size_t n = chain.joints();
  std::vector<double> J(6 * n);
  chain.jacobian(q, J);
  double a[3][3] = {};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < n; ++k) {
        const double scale = chain.slides(k) ? 1 : chain.reach();
        a[r][c] += J[r * n + k] * J[c * n + k] / (scale * scale);
      }
  const double det = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
                     a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
                     a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
  return std::sqrt(std::max(0.0, det));
}

/// From dark violet over green to yellow, `t` in [0, 1].
std::array<int, 3> color(double t) {
  constexpr double kStops[5][3] = {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};
  const double at = std::clamp(t, 0.0, 1.0) * 4;
  const int low = std::min(static_cast<int>(at), 3);
  std::array<int, 3> out{};
  for (std::size_t c = 0; c < 3; ++c)
    out[c] =
        static_cast<int>(std::lround(kStops[low][c] + (at - low) * (kStops[low + 1][c] - kStops[low][c])));
  return out;
}

constexpr int kShades = 24;

/// 0 … kShades - 1, or -1 if the arm does not reach the position.
int shade(const WorkspaceMap& map, int column, int row, double best) {
  const WorkspaceCell& cell = map.cells[static_cast<std::size_t>(row * map.columns + column)];
  if (!cell.reached()) return -1;
  return std::min(kShades - 1, static_cast<int>(kShades * cell.manipulability / best));
}

std::string hex(int shade) {
  const auto c = color((shade + 0.5) / kShades);
  return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]);
}

double grid_step(double span) {
  double out = 0.01;
  for (const double factor : {2.0, 2.5, 2.0, 2.0, 2.5, 2.0, 2.0})
    if (out * factor <= span) out *= factor;
  return out;
}

// --- PNG (RFC 2083), the pixels in stored blocks (RFC 1951)

std::string big_endian(std::uint32_t v) {
  return {static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
          static_cast<char>(v)};
}

std::uint32_t crc32(const std::string& data) {
  std::uint32_t crc = 0xffffffffu;
  for (const char c : data) {
    crc ^= static_cast<unsigned char>(c);
    for (int k = 0; k < 8; ++k) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0);
  }
  return ~crc;
}

std::string chunk(const std::string& name, const std::string& data) {
  return big_endian(static_cast<std::uint32_t>(data.size())) + name + data + big_endian(crc32(name + data));
}

std::string stored(const std::string& raw) {
  std::string out = "\x78\x01";
  std::uint32_t a = 1, b = 0;
  for (const char c : raw) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  for (std::size_t at = 0; at < raw.size(); at += 65535) {
    const std::size_t n = std::min<std::size_t>(65535, raw.size() - at);
    out += static_cast<char>(at + n == raw.size());
    for (const std::size_t v : {n, ~n}) {
      out += static_cast<char>(v & 255);
      out += static_cast<char>((v >> 8) & 255);
    }
    out.append(raw, at, n);
  }
  return out + big_endian(b << 16 | a);
}

}  // namespace

double WorkspaceMap::best_manipulability() const {
  double out = 1e-12;
  for (const WorkspaceCell& c : cells) out = std::max(out, c.manipulability);
  return out;
}

std::size_t WorkspaceMap::reached() const {
  return static_cast<std::size_t>(
      std::count_if(cells.begin(), cells.end(), [](const WorkspaceCell& c) { return c.reached(); }));
}

namespace {
/// True if the TCP may be there in the full profile. How the tool tilts there is not known yet.
bool may_be_at(const moves::Workspace& workspace, const Vec3& place) {
  for (std::size_t i = 0; i < workspace.boundaries(); ++i) {
    const moves::ZoneKind kind = workspace.zones()[workspace.zone_of(i)].kind;
    if (kind == moves::ZoneKind::cone || kind == moves::ZoneKind::range || !workspace.counts(i, false))
      continue;
    if (workspace.distance(i, {place, {}}, {}).distance < 0) return false;
  }
  return true;
}
}  // namespace

WorkspaceMap map_workspace(const Chain& chain, const std::vector<double>& home,
                           const WorkspaceQuestion& question, const std::function<void(double)>& progress) {
  const std::array<int, 3> axes = axes_of(question.plane);
  if (question.resolution < 2 || question.resolution > 2000)
    throw Error("bad-value", fmt::format("a resolution of {} is not possible", question.resolution),
                "2 to 2000 cells");
  if (!std::isfinite(chain.reach()))
    throw Error("bad-value", "this arm reaches endlessly far: a prismatic joint has no limits",
                "give it limits");
  const Vec3 c = chain.reach_center();
  const std::array<double, 3> center{c.x, c.y, c.z};
  const Asker asker(chain, home, question.rotation);
  WorkspaceMap out;
  out.closed_form = asker.closed_form();
  out.columns = out.rows = question.resolution;
  out.cell = 2 * chain.reach() / question.resolution;
  out.left = center[static_cast<std::size_t>(axes[0])] - chain.reach();
  out.top = center[static_cast<std::size_t>(axes[1])] + chain.reach();
  const auto columns = static_cast<std::size_t>(out.columns);
  std::vector<std::vector<double>> above(columns);
  for (int row = 0; row < out.rows; ++row) {
    std::vector<std::size_t> asked;
    std::vector<Vec3> places;
    std::vector<std::vector<double>> seeds;
    for (std::size_t column = 0; column < columns; ++column) {
      WorkspaceCell cell;
      cell.position = placed(axes, out.left + (static_cast<double>(column) + 0.5) * out.cell,
                             out.top - (row + 0.5) * out.cell, question.at);
      const bool near = norm(cell.position - chain.reach_center()) <= chain.reach() * 1.001;
      if (near && may_be_at(question.allowed, cell.position)) {
        asked.push_back(out.cells.size());
        places.push_back(cell.position);
        seeds.push_back(above[column]);
      }
      out.cells.push_back(std::move(cell));
    }
    std::vector<std::vector<double>> found = asker.ask(places, seeds);
    above.assign(columns, {});
    for (std::size_t k = 0; k < asked.size(); ++k) {
      if (found[k].empty()) continue;
      WorkspaceCell& cell = out.cells[asked[k]];
      above[asked[k] % columns] = found[k];
      cell.q = std::move(found[k]);
      cell.manipulability = manipulability_of(chain, cell.q);
      cell.smallest_singular_value = kinematics::smallest_singular_value(chain, cell.q);
    }
    progress((row + 1.0) / out.rows);
  }
  return out;
}

std::string csv_of(const WorkspaceMap& map, const Chain& chain) {
  std::string out = "x,y,z,reached,manipulability,smallest_singular_value";
  for (const std::string& name : chain.names()) out += "," + name;
  out += "\n";
  for (const WorkspaceCell& cell : map.cells) {
    out += fmt::format("{:.6g},{:.6g},{:.6g},{},{:.6g},{:.6g}", cell.position.x, cell.position.y,
                       cell.position.z, cell.reached() ? 1 : 0, cell.manipulability,
                       cell.smallest_singular_value);
    for (std::size_t i = 0; i < chain.joints(); ++i)
      out += cell.reached() ? fmt::format(",{:.6f}", cell.q[i]) : std::string(",");
    out += "\n";
  }
  return out;
}

std::string svg_of(const WorkspaceMap& map, const WorkspaceQuestion& question, const std::string& title) {
  const double size = 480, pixel = size / map.columns, left = 46, top = 30;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 {0:.0f}\" width=\"640\" "
      "height=\"{0:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"640\" height=\"{0:.0f}\" fill=\"#fff\"/>\n"
      "<text x=\"{1}\" y=\"18\" font-size=\"13\">{2}</text>\n<rect x=\"{1}\" y=\"{3}\" width=\"{4}\" "
      "height=\"{4}\" "
      "fill=\"#f1f3f5\"/>\n",
      size + top + 40, left, title, top, size);
  const double best = map.best_manipulability();
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns;) {
      const int here = shade(map, column, row, best);
      int end = column + 1;
      while (end < map.columns && shade(map, end, row, best) == here) ++end;
      if (here >= 0)
        out += fmt::format("<path d=\"M{:.1f} {:.1f}h{:.1f}v{:.1f}h-{:.1f}z\" fill=\"{}\"/>\n",
                           left + column * pixel, top + row * pixel, (end - column) * pixel + 0.2,
                           pixel + 0.2, (end - column) * pixel + 0.2, hex(here));
      column = end;
    }
  const double step = grid_step(map.cell * map.columns / 4), span = map.cell * map.columns;
  for (double v = std::ceil(map.left / step) * step; v < map.left + span; v += step)
    out += fmt::format(
        "<path d=\"M{0:.1f} {1}v{2}\" stroke=\"#0003\"/><text x=\"{0:.1f}\" y=\"{3:.0f}\" "
        "text-anchor=\"middle\">{4:.2g}</text>\n",
        left + (v - map.left) / span * size, top, size, top + size + 14, std::abs(v) < 1e-9 ? 0.0 : v);
  for (double v = std::ceil((map.top - span) / step) * step; v < map.top; v += step)
    out += fmt::format(
        "<path d=\"M{0} {1:.1f}h{2}\" stroke=\"#0003\"/><text x=\"{3}\" y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5:.2g}</text>\n",
        left, top + (map.top - v) / span * size, size, left - 4, top + (map.top - v) / span * size + 4,
        std::abs(v) < 1e-9 ? 0.0 : v);
  out += fmt::format(
      "<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"middle\">{}, m</text>\n<text x=\"8\" y=\"{:.0f}\">{}"
      "</text>\n",
      left + size / 2, top + size + 30, question.plane[0], top + 12, question.plane[1]);
  for (int k = 0; k < kShades; ++k)
    out += fmt::format("<rect x=\"548\" y=\"{:.1f}\" width=\"16\" height=\"8.3\" fill=\"{}\"/>\n",
                       top + 20 + 8 * (kShades - 1 - k), hex(k));
  return out + fmt::format(
                   "<text x=\"548\" y=\"{:.0f}\">manipulability</text>\n<text x=\"570\" y=\"{:.0f}\">{:.3f}"
                   "</text>\n<text x=\"570\" y=\"{:.0f}\">0</text>\n</svg>\n",
                   top + 12, top + 28, best, top + 20 + 8 * kShades);
}

std::string png_of(const WorkspaceMap& map) {
  constexpr int kPixels = 8;
  const double best = map.best_manipulability();
  std::string raw;
  for (int y = 0; y < map.rows * kPixels; ++y) {
    raw += '\0';  // no filter
    for (int x = 0; x < map.columns * kPixels; ++x) {
      const int here = shade(map, x / kPixels, y / kPixels, best);
      const auto c = here < 0 ? std::array<int, 3>{241, 243, 245} : color((here + 0.5) / kShades);
      for (const int channel : c) raw += static_cast<char>(channel);
    }
  }
  const std::string header = big_endian(static_cast<std::uint32_t>(map.columns * kPixels)) +
                             big_endian(static_cast<std::uint32_t>(map.rows * kPixels)) +
                             std::string("\x08\x02\x00\x00\x00", 5);
  return std::string("\x89PNG\r\n\x1a\n", 8) + chunk("IHDR", header) + chunk("IDAT", stored(raw)) +
         chunk("IEND", "");
}

}  // namespace polyarm::apps
