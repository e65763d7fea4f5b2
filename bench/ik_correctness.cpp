// Whether inverse kinematics finds what it should, of every robot of the catalogue:
//
//   build/release/bench/ik_correctness KIND POSES [PART OF A NAME | =WAY | ==WAY] [FIRST]
//
// KIND says which joint states are drawn, POSES of each robot, within limits:
//   random   anywhere, with a random seed
//   grid     each joint at a multiple of 90 degrees where limits allow; the seed is the state itself
//   near     the same, all joints or three of four at such values, off by 1e-7 to 0.1 rad; random seed, and
//            the state itself where the smallest singular value is below 1e-6
//   numeric  anywhere, a random seed, by NumericIk
// The solutions of the state's pose have to hold the state itself (numeric, and where more axes move than a
// pose needs, spare axis or iteration: one solution at all), each within 2e-9 m and rad by the chain's
// forward kinematics, within limits, nearest to the seed first. Each miss is printed as a case to repeat
// (`FIRST`: from which state on), each robot with misses in a line; the last lines are sums by way. =WAY:
// those alone whose way begins so (closed form, search, spare axis, iteration; "=closed form, not" for those
// that are not quite ideal), ==WAY those whose way is that. POLYARM_SHARE=1/2 asks the second robot of each
// two (0/2 the first), so that long runs use all cores.
//
// POLYARM_ROBOTS=FOLDER asks the robots of a folder instead (polyarm robots add FILE --folder FOLDER).
// Joints that do not move the tool (a gripper's, another arm's) are left out of what is compared.
//
// What it cannot show: solutions that no state drawn is one of; tests/kinematics asks descents for those.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "bench/ik_words.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/random.hpp"
#include "polyarm/kinematics/singularity.hpp"

namespace {

using namespace polyarm;
using namespace polyarm::ik;

enum class Kind { random, grid, near, numeric };
using State = std::array<double, Chain::kMaxJoints>;

constexpr double kFamily = 1e-6;  // of the smallest singular value

struct Tally {
  long arms = 0, asked = 0, missed = 0, inexact = 0, outside = 0, unsorted = 0;
  Tally& operator+=(const Tally& b) {
    arms += b.arms, asked += b.asked, missed += b.missed;
    inexact += b.inexact, outside += b.outside, unsorted += b.unsorted;
    return *this;
  }
  bool clean() const { return missed + inexact + outside + unsorted == 0; }
};

State draw(const Chain& chain, Kind kind, Random& random) {
  State q{};
  for (std::size_t j = 0; j < chain.joints(); ++j) q[j] = random_value(chain, j, random);
  if (kind == Kind::random || kind == Kind::numeric) return q;
  const double off = kind == Kind::near ? std::pow(10, random.between(-7, -1)) : 0.0;
  const double kept = kind == Kind::near && random.unit() < 0.7 ? 0.25 : 0.0;
  for (std::size_t j = 0; j < chain.joints(); ++j) {
    const double value = std::numbers::pi / 2 * std::floor(random.between(-1, 3)) + random.between(-off, off);
    if (random.unit() >= kept && value >= chain.lower()[j] && value <= chain.upper()[j]) q[j] = value;
  }
  return q;
}

double error_of(const Chain& chain, std::span<const double> q, const Pose& target) {
  const Pose pose = chain.forward(q);
  const Quaternion &a = pose.rotation, &b = target.rotation;
  const double side = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w < 0 ? -1 : 1;
  const double x = a.x - side * b.x, y = a.y - side * b.y, z = a.z - side * b.z, w = a.w - side * b.w;
  return std::max(norm(pose.position - target.position), 2 * std::sqrt(x * x + y * y + z * z + w * w));
}

/// The largest of all joints; of joints that turn less whole turns. Stops where it is more than `most_asked`.
double difference(const Chain& chain, const double* a, const State& b, double most_asked) {
  double most = 0;
  for (std::size_t j = 0; j < chain.joints() && most <= most_asked; ++j) {
    if (!chain.moves_tcp(j)) continue;
    const double period = chain.period(j);
    double d = std::abs(a[j] - b[j]);
    if (period > 0) d -= period * static_cast<double>(static_cast<long>(d / period + 0.5));
    most = std::max(most, std::abs(d));
  }
  return most;
}

/// Checks what was found; whether `q` is among it, or enough of it.
bool holds(const Chain& chain, const IkSolutions& found, const Pose& target, const State& q, bool any,
           Tally& tally) {
  double nearest = 1e9;
  for (const IkSolution& one : found) {
    nearest = std::min(nearest, difference(chain, one.q.data(), q, nearest));
    tally.inexact += !one.exact || error_of(chain, {one.q.data(), chain.joints()}, target) > 2e-9;
    for (std::size_t j = 0; j < chain.joints(); ++j)
      tally.outside += chain.moves_tcp(j) && (one.q[j] < chain.lower()[j] || one.q[j] > chain.upper()[j]);
    if (&one != found.begin()) tally.unsorted += one.distance < (&one - 1)->distance;
  }
  if (any) return found.count > 0;
  // At a singularity two solutions become one, or endlessly many; q is then known to fewer digits.
  if (nearest < 1e-6) return true;
  return nearest < 1e-2 && smallest_singular_value(chain, {q.data(), chain.joints()}) < 1e-4;
}

Tally ask(const std::string& robot, const Chain& chain, const InverseKinematics& arm, Kind kind, long first,
          long poses) {
  Tally out;
  const bool numeric = kind == Kind::numeric;
  NumericSettings settings;
  settings.steps = 5000;
  const NumericIk descent(chain, settings);
  const std::size_t n = chain.joints();
  const bool endless = arm.way() == IkWay::spare_axis || (arm.way() == IkWay::descent && n > 6);
  Random random(std::hash<std::string>{}(robot) + static_cast<std::size_t>(kind));
  IkSolutions found;
  for (long i = 0; i < first + poses; ++i) {
    const State q = draw(chain, kind, random);
    State seed = q;
    if (kind != Kind::grid)
      for (std::size_t j = 0; j < n; ++j) seed[j] = random_value(chain, j, random);
    if (i < first) continue;
    const Pose target = chain.forward({q.data(), n});
    ++out.asked;
    IkOutcome outcome = IkOutcome::solved;
    bool good = false;
    if (numeric) {
      IkSolution one;
      outcome = descent.solve(target, {seed.data(), n}, one);
      good = outcome == IkOutcome::solved;
      out.inexact += good && error_of(chain, {one.q.data(), n}, target) > 3e-6;
      for (std::size_t j = 0; j < n; ++j)
        out.outside += chain.moves_tcp(j) && (one.q[j] < chain.lower()[j] || one.q[j] > chain.upper()[j]);
    } else {
      const Tally before = out;
      outcome = arm.solve_all(target, {seed.data(), n}, found);
      good = holds(chain, found, target, q, endless && kind != Kind::grid, out);
      // Where hardly anything tells the members of a family apart, it is the seed's that has to be there.
      if (!good && smallest_singular_value(chain, {q.data(), n}) < kFamily) {
        arm.solve_all(target, {q.data(), n}, found);
        good = holds(chain, found, target, q, false, out);
      }
      good = good && before.inexact == out.inexact && before.outside == out.outside;
    }
    if (good) continue;
    if (++out.missed <= 20)
      fmt::print(
          "missed by {} (state {}, {}, {} solutions, smallest singular value {:.2g}): q = {:.17g} seed = "
          "{:.17g}\n",
          robot, i, name(outcome), numeric ? 0 : found.count, smallest_singular_value(chain, {q.data(), n}),
          fmt::join(q.data(), q.data() + n, ", "), fmt::join(seed.data(), seed.data() + n, ", "));
  }
  return out;
}

int report(const std::map<std::string, Tally>& by_way) {
  bool clean = true;
  for (const auto& [way, t] : by_way) {
    fmt::print("{}: {} robots, {} poses, {} missed, {} inexact, {} outside limits, {} out of order\n", way,
               t.arms, t.asked, t.missed, t.inexact, t.outside, t.unsorted);
    clean &= t.clean();
  }
  return clean ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "", part = argc > 3 ? argv[3] : "";
  const long poses = argc > 2 ? std::atol(argv[2]) : 0, first = argc > 4 ? std::atol(argv[4]) : 0;
  const std::map<std::string, Kind> kinds{
      {"random", Kind::random}, {"grid", Kind::grid}, {"near", Kind::near}, {"numeric", Kind::numeric}};
  if (!kinds.contains(word) || poses <= 0) {
    fmt::print(
        "usage: ik_correctness random|grid|near|numeric POSES [PART OF A NAME | =WAY | ==WAY] [FIRST]\n");
    return 2;
  }
  const char* own = std::getenv("POLYARM_ROBOTS");
  const description::Catalogue catalogue(
      {own ? std::string(own) : std::string(POLYARM_SOURCE_DIR "/robots")});
  std::map<std::string, Tally> by_way;
  unsigned share = 0, shares = 1, turn = 0;
  const char* asked = std::getenv("POLYARM_SHARE");
  if (asked && (std::sscanf(asked, "%u/%u", &share, &shares) != 2 || share >= shares)) {
    fmt::print("POLYARM_SHARE is to be K/N with K below N, not '{}'\n", asked);
    return 2;
  }
  for (const std::string& robot : catalogue.names()) {
    if (!part.starts_with('=') && robot.find(part) == std::string::npos) continue;
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    std::string way = words(arm.way());
    if (arm.report().find("true within") != std::string::npos) way += ", not quite ideal";
    if (part.starts_with("==") ? way != part.substr(2)
                               : part.starts_with('=') && !way.starts_with(part.substr(1)))
      continue;
    if (turn++ % shares != share) continue;
    if (kinds.at(word) == Kind::numeric) way = fmt::format("{} joints", chain.joints());
    const auto begin = std::chrono::steady_clock::now();
    Tally tally = ask(robot, chain, arm, kinds.at(word), first, poses);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (!tally.clean())
      fmt::print("{}: {} of {} missed, {} inexact, {} outside limits, {} out of order\n", robot, tally.missed,
                 tally.asked, tally.inexact, tally.outside, tally.unsorted);
    fmt::print(stderr, "{} {:.1f} s\n", robot, seconds);
    std::fflush(stdout);
    tally.arms = 1;
    by_way[way] += tally;
  }
  return report(by_way);
}
