// Arms that have two axes that meet and no closed form of their own: one for each value of axis 4.
#include <cmath>
#include <numbers>

#include "polyarm/kinematics/families.hpp"
#include "polyarm/kinematics/lane_polish.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace polyarm::kinematics {

namespace {

constexpr std::size_t kSamples = 64;
constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kNearby = 0.15;    // rad: how far the first step from a sample may lead
constexpr double kNotFar = 0.4;     // the same where samples are close to each other
constexpr double kOffset = 0.0123;  // rad: so that no sample is at a right angle

/// Values of axis 4, a `cell` apart from each other.
struct Samples {
  double cell;
  alignas(64) double s[kSamples], c[kSamples];
};
Samples all_round() {
  Samples out;
  out.cell = kTurn / kSamples;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double at = -std::numbers::pi + kOffset + static_cast<double>(i) * out.cell;
    out.s[i] = std::sin(at);
    out.c[i] = std::cos(at);
  }
  return out;
}
const Samples kAllRound = all_round();

/// All samples in the cells around these of all round.
POLYARM_INLINE void spread(const bool* marked, Samples& out) {
  std::size_t cells[kSamples], count = 0;
  for (std::size_t i = 0; i < kSamples; ++i)
    if (marked[i]) cells[count++] = i;
  const double part = static_cast<double>(count) / kSamples;
  out.cell = kAllRound.cell * part;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double at = (static_cast<double>(i) + 0.5) * part;
    const auto cell = static_cast<std::size_t>(at);
    const double x = (at - static_cast<double>(cell) - 0.5) * kAllRound.cell, x2 = x * x;
    const double s = x * (1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42))),
                 c = 1 - x2 / 2 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56)));
    const double s0 = kAllRound.s[cells[cell]], c0 = kAllRound.c[cells[cell]];
    out.s[i] = s0 * c + c0 * s;
    out.c[i] = c0 * c - s0 * s;
  }
}

/// Joint states waiting for descent, as many as a block takes.
struct Waiting {
  alignas(64) double s[kMost][kLanes], c[kMost][kLanes];
  std::size_t count = 0;
};

POLYARM_INLINE void finish(const BranchJob& job, const bool* moves, Waiting& waiting, Branches& out) {
  const std::size_t n = job.arm->count;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = waiting.count; k < kLanes; ++k) {
      waiting.s[i][k] = waiting.s[i][0];
      waiting.c[i][k] = waiting.c[i][0];
    }
  LaneAngle q[kMost];
  for (std::size_t i = 0; i < n; ++i) q[i] = {load(waiting.s[i]), load(waiting.c[i])};
  check_and_polish(job, q, moves, out);
  write_values(job, q, out);
  out.free = 0;
  waiting.count = 0;
}

/// Angles 5 and 6 that come nearest to the orientation, the others known.
POLYARM_INLINE void end_of(const SixAxisForm& f, const Aim& aim, const LaneAngle* offered, LaneAngle* q,
                           LaneMask& free) {
  const auto seen = [&](const Vec3& world) __attribute__((always_inline)) {
    LaneVec v = splat(aim.r * world);
    for (std::size_t i = 0; i < 4; ++i) v = turned(f.h[i], -q[i], v);
    return v;
  };
  const LaneVec u = seen(f.h[5]), w = seen(f.beside_6);
  q[4] = subproblem_1(splat(f.h[5]), u, f.h[4], squared(f.least_sine), offered[4], free);
  q[5] = subproblem_1(splat(f.beside_6), turned(f.h[4], -q[4], w), f.h[5], f.least_sine, offered[5], free);
}

POLYARM_INLINE ShoulderAim aim_at(const SixAxisForm& f, const Aim& aim, const LaneAngle& four) {
  return aim_shoulder(f.shoulder, splat(aim.p), turned(f.h[3], four, splat(f.to_56)) + f.p34);
}

/// One of the four ways of the first three axes.
POLYARM_INLINE Lane reach(const SixAxisForm& f, const ShoulderAim& aim, int way, const Edge& edge,
                          const LaneAngle* offered, LaneAngle* six, LaneMask& free) {
  return solve_shoulder(f.shoulder, aim, splat(way & 1 ? -1.0 : 1.0), splat(way & 2 ? -1.0 : 1.0), edge,
                        offered, six, free);
}

/// Where the first three axes reach, or nearly, what axis 4 leaves them: all round, or closer where it is
/// only in places.
POLYARM_INLINE const Samples& where_to_look(const SixAxisForm& f, const Aim& aim, const Edge& edge,
                                            const LaneAngle* offered, double lever, Samples& resampled) {
  const double near2 = squared(1.3 * kAllRound.cell * lever);
  bool near[kSamples];
  for (std::size_t first = 0; first < kSamples; first += kLanes) {
    LaneAngle six[6];
    six[3] = {load(kAllRound.s + first), load(kAllRound.c + first)};
    const ShoulderAim shoulder = aim_at(f, aim, six[3]);
    LaneMask any{};
    for (int way = 0; way < 4; ++way) {
      LaneMask free{};
      any |= below(reach(f, shoulder, way, edge, offered, six, free), splat(near2));
    }
    for (std::size_t k = 0; k < kLanes; ++k) near[first + k] = any[k] != 0;
  }
  bool marked[kSamples];
  std::size_t count = 0;
  for (std::size_t i = 0; i < kSamples; ++i) {
    marked[i] = near[i] || near[(i + 1) % kSamples] || near[(i + kSamples - 1) % kSamples];
    count += marked[i];
  }
  if (count == 0 || count > kSamples * 3 / 4) return kAllRound;
  spread(marked, resampled);
  return resampled;
}

POLYARM_INLINE std::size_t search(const BranchJob& job, Branches* out, std::size_t room) {
  const SixAxisForm& f = *job.form;
  PoseTarget target = job.target;
  if (f.from_tool) {
    target.rotation = transposed(target.rotation);
    target.position = -(target.rotation * target.position);
  }
  const Aim aim = aim_of(f, target);
  const Edge edge{f.edge, __builtin_sqrt(f.edge / (1 - f.edge)), false};
  const std::size_t n = job.arm->count;
  LaneAngle offered[6], q[kMost];
  bool moves[kMost]{};
  for (std::size_t i = 0; i < n; ++i) q[i] = angle_at(*job.arm, i, job.seed[i]);
  for (std::size_t k = 0; k < 6; ++k) {
    offered[k] = {splat(0.0), splat(1.0)};
    if (job.to_arm[k] < 0) continue;
    offered[k] = q[job.to_arm[k]];
    moves[job.to_arm[k]] = true;
  }
  const std::size_t watched = job.to_arm[3] >= 0 ? static_cast<std::size_t>(job.to_arm[3]) : kMost;
  const double lever = norm(cross(f.h[3], f.to_56));
  Samples resampled;
  const Samples& samples = where_to_look(f, aim, edge, offered, lever, resampled);
  BranchJob patient = job;
  if (&samples != &kAllRound) patient.patience = 9;  // narrow places have ends near everything
  const double near2 = squared(1.3 * samples.cell * lever);
  const double nearby = &samples == &kAllRound ? kNearby : kNotFar;
  Waiting waiting;
  std::size_t blocks = 0;
  for (std::size_t first = 0; first < kSamples; first += kLanes) {
    LaneAngle six[6];
    six[3] = {load(samples.s + first), load(samples.c + first)};
    const ShoulderAim shoulder = aim_at(f, aim, six[3]);
    for (int way = 0; way < 4; ++way) {
      LaneMask free{};
      const Lane left = reach(f, shoulder, way, edge, offered, six, free);
      const LaneMask near = below(left, splat(near2));
      if (bits_of(near) == 0) continue;
      end_of(f, aim, offered, six, free);
      for (std::size_t k = 0; k < 6; ++k)
        if (job.to_arm[k] >= 0) q[job.to_arm[k]] = six[k];
      const Lane moved = descend(*job.arm, moves, job.target, q, watched);
      const std::uint32_t chosen = bits_of(near & below(magnitude(moved), splat(nearby)));
      for (std::size_t k = 0; k < kLanes; ++k) {
        if ((chosen >> k & 1u) == 0) continue;
        for (std::size_t i = 0; i < n; ++i) {
          waiting.s[i][waiting.count] = q[i].s[k];
          waiting.c[i][waiting.count] = q[i].c[k];
        }
        if (++waiting.count == kLanes) finish(patient, moves, waiting, out[blocks++]);
        if (blocks == room) return blocks;
      }
    }
  }
  if (waiting.count > 0) finish(patient, moves, waiting, out[blocks++]);
  return blocks;
}

using Kernel = std::size_t (*)(const BranchJob&, Branches*, std::size_t);

std::size_t search_anywhere(const BranchJob& job, Branches* out, std::size_t room) {
  return search(job, out, room);
}
#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) std::size_t search_avx2(const BranchJob& job, Branches* out,
                                                            std::size_t room) {
  return search(job, out, room);
}
__attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))) std::size_t search_avx512(const BranchJob& job,
                                                                                        Branches* out,
                                                                                        std::size_t room) {
  return search(job, out, room);
}
#endif

Kernel kernel_here() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) return search_avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return search_avx2;
#endif
  return search_anywhere;
}

const Kernel kKernel = kernel_here();

}  // namespace

std::size_t search_branches(const BranchJob& job, std::span<Branches> out) noexcept {
  return kKernel(job, out.data(), out.size());
}

}  // namespace polyarm::kinematics
