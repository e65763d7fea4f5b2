#pragma once
/// Subproblems 5 and 6 without a quartic: both intersect a conic with the unit circle. Pairs of straight
/// lines pass through the up to four intersection points. One pair is always real, and its parameter lies in
/// a known interval, so a safe iteration on real numbers finds its lines. Each line meets the circle in two
/// points, or has one nearest point (the touching solution, which persists at a double root). Eight at a
/// time. Private to this room.
#include "polyarm/closed_form/closed_form.hpp"
#include "polyarm/closed_form/subproblems.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace POLYARM_LANES {

/// cc c^2 + cs c s + ss s^2 + c1 c + s1 s + one = 0 where c^2 + s^2 = 1.
struct LaneConic {
  Lane cc{}, cs{}, ss{}, c1{}, s1{}, one{};
  /// Adds factor * (a + b c + d s)^2.
  POLYARM_INLINE void add_square(Lane a, Lane b, Lane d, double factor) {
    cc += factor * b * b;
    ss += factor * d * d;
    cs += (2 * factor) * b * d;
    c1 += (2 * factor) * a * b;
    s1 += (2 * factor) * a * d;
    one += factor * a * a;
  }
};

/// Two lines n . (c, s) = reach with unit normals.
struct LaneLines {
  LaneAngle normal[2];
  Lane reach[2];
};

/// A root in [0, 1] of t^3 + b t^2 + c t - d, where d >= 0 and 1 + b + c - d >= 0. Newton's method; bisects
/// the bracket when a step leaves it or is not half as long as the one before.
POLYARM_INLINE Lane root_between_0_and_1(Lane b, Lane c, Lane d) {
  constexpr int kSteps = 22;
  Lane low{}, high = splat(1.0), t = splat(0.5), before = splat(1.0);
  for (int i = 0; i < kSteps; ++i) {
    const Lane value = ((t + b) * t + c) * t - d, slope = (3.0 * t + 2.0 * b) * t + c;
    const LaneMask left = below(value, Lane{});
    low = select(left, t, low);
    high = select(left, high, t);
    const Lane step = value / select(below(magnitude(slope), splat(1e-280)), splat(1e-280), slope);
    const Lane next = t - step, half = 0.5 * (high - low);
    const LaneMask there = below(magnitude(step), 1e-13 * t);
    const LaneMask slow =
        ~there & (below(next, low) | below(high, next) | below(before, 2.0 * magnitude(step)));
    t = select(slow, low + half, next);
    before = select(slow, half, magnitude(step));
  }
  return t;
}

/// The lines through the intersection of conic and circle. Coefficients below `least` count as zero.
POLYARM_INLINE LaneLines lines_of(const LaneConic& q, double least) {
  // Rotated so that the conic is k c^2 + 2 d c + 2 e s + g.
  const Lane even = q.cc - q.ss, floor = least + 1e-12 * (magnitude(q.c1) + magnitude(q.s1));
  const Lane length = root(even * even + q.cs * q.cs);
  const LaneMask round = below(length, floor);
  const Lane k = select(round, floor, length), inverse = 1.0 / k;
  const Lane cos2 = select(round, splat(1.0), even * inverse), sin2 = select(round, Lane{}, q.cs * inverse);
  const Lane larger = root(0.5 * (1.0 + magnitude(cos2))), smaller = 0.5 * magnitude(sin2) / larger;
  const LaneMask upright = below(cos2, Lane{});
  const Lane cosine = select(upright, smaller, larger), size = select(upright, larger, smaller);
  const LaneAngle turn{with_sign(size, sin2), cosine};
  const Lane g = (0.5 * (q.cc + q.ss - k) + q.one) * inverse;
  const Lane d = 0.5 * inverse * (q.c1 * turn.c + q.s1 * turn.s);
  const Lane e = 0.5 * inverse * (q.s1 * turn.c - q.c1 * turn.s);
  const Lane d2 = d * d, e2 = e * e;
  Lane t = root_between_0_and_1(g - 1.0, d2 + e2 - g, e2);
  t = select(below(t, Lane{}), Lane{}, select(below(splat(1.0), t), splat(1.0), t));
  const Lane p = root(1.0 - t), r = root(t), product = g + t;
  // (p c - r s + u)(p c + r s + v): u + v, u - v and u v are known; one of the first two is more accurate.
  const LaneMask steep = below(p, r);
  const Lane known = 2.0 * select(steep, e, d) / select(steep, r, p);
  const Lane rest = select(steep, known * known + 4.0 * product, known * known - 4.0 * product);
  const Lane other = with_sign(root(select(below(rest, Lane{}), Lane{}, rest)), select(steep, d, e));
  const Lane sum = select(steep, other, known), difference = select(steep, known, other);
  const LaneMask unlike = of_unlike_sign(sum, difference);
  const Lane big = 0.5 * select(unlike, sum - difference, sum + difference);
  const LaneMask nothing = below(magnitude(big), splat(1e-290));
  const Lane small = select(nothing, Lane{}, product / select(nothing, splat(1.0), big));
  const Lane u = select(unlike, small, big), v = select(unlike, big, small);
  LaneLines out;
  out.normal[0] = turn + LaneAngle{-r, p};
  out.normal[1] = turn + LaneAngle{r, p};
  out.reach[0] = -u;
  out.reach[1] = -v;
  return out;
}

/// One of up to four points: selected by a line and by the side on it (`sign`).
POLYARM_INLINE LaneAngle point_on(const LaneAngle& normal, Lane reach, Lane sign, const Edge& edge,
                                  LaneMask& free) {
  const LaneAngle zero{splat(0.0), splat(1.0)};
  return level(normal, reach, (1.0 - reach) * (1.0 + reach), sign, edge, 1e-3, zero, free);
}

/// The part that the four solutions share.
struct ShoulderAim {
  LaneVec p, f0, fc, fs;  ///< p23 + R3 p34 = f0 + c fc + s fs
  Lane a0, ac, as, b0, bc, bs;
  LaneLines lines;  ///< in (c3, s3); if axes meet or are parallel, only the first line is used
};

POLYARM_INLINE ShoulderAim aim_shoulder(const Shoulder& f, const LaneVec& p, const LaneVec& p34) {
  ShoulderAim out;
  out.p = p;
  const Lane along = dot(f.h3, p34);
  out.fc = p34 - along * f.h3;
  out.fs = cross(f.h3, p34);
  out.f0 = along * f.h3 + f.p23;
  const Lane m0 = dot(out.f0, out.f0) + dot(out.fc, out.fc), mc = 2.0 * dot(out.f0, out.fc),
             ms = 2.0 * dot(out.f0, out.fs);
  const Lane n0 = dot(f.h2, out.f0), nc = dot(f.h2, out.fc), ns = dot(f.h2, out.fs);
  const double d2 = f.distance * f.distance;
  out.a0 = 0.5 * (dot(p, p) - d2 - m0);
  out.ac = -0.5 * mc;
  out.as = -0.5 * ms;
  out.b0 = dot(f.h1, p) - f.cosine * n0;
  out.bc = -f.cosine * nc;
  out.bs = -f.cosine * ns;
  if (f.kind == Shoulder::Kind::any) {
    LaneConic q;
    q.add_square(out.a0, out.ac, out.as, 1);
    q.add_square(out.b0, out.bc, out.bs, d2 / (f.sine * f.sine));
    q.add_square(n0, nc, ns, d2);
    q.c1 -= d2 * mc;
    q.s1 -= d2 * ms;
    q.one -= d2 * m0;
    const double least = f.least_length * f.least_length;
    out.lines = lines_of(q, least * least);
  } else {
    const bool meets = f.kind == Shoulder::Kind::meets;
    const Lane c = meets ? out.ac : out.bc, s = meets ? out.as : out.bs, one = meets ? out.a0 : out.b0;
    const Lane length = root(s * s + c * c);
    const double least = f.least_length * (meets ? f.least_length : 1);
    const LaneMask none = below(length, splat(least));
    const Lane scale = 1.0 / select(none, splat(1.0), length);
    out.lines.normal[0] = {select(none, splat(0.0), s * scale), select(none, splat(1.0), c * scale)};
    out.lines.reach[0] = select(none, Lane{}, -one * scale);
    out.lines.normal[1] = out.lines.normal[0];
    out.lines.reach[1] = out.lines.reach[0];
  }
  return out;
}

/// One of the four solutions, selected by `line` (+1 or -1) and `sign`; for kinds with only two values of q3,
/// `line` selects the second axis.
/// Returns the squared distance of the point from its target.
POLYARM_INLINE Lane solve_shoulder(const Shoulder& f, const ShoulderAim& aim, Lane line, Lane sign,
                                   const Edge& edge, const LaneAngle* offered, LaneAngle* q, LaneMask& free) {
  const LaneMask second = below(line, Lane{});
  const LaneAngle normal = select(second, aim.lines.normal[1], aim.lines.normal[0]);
  q[2] = point_on(normal, select(second, aim.lines.reach[1], aim.lines.reach[0]), sign, edge, free);
  const LaneVec v = aim.f0 + (q[2].c * aim.fc + q[2].s * aim.fs);
  const Lane fx = dot(f.e1, v), fy = dot(f.e2, v);
  const Lane flat2 = fx * fx + fy * fy;
  Lane x{}, y{};
  if (f.kind != Shoulder::Kind::meets) x = (aim.a0 + q[2].c * aim.ac + q[2].s * aim.as) * (1 / f.distance);
  if (f.kind != Shoulder::Kind::parallel) y = (aim.b0 + q[2].c * aim.bc + q[2].s * aim.bs) * (1 / f.sine);
  if (f.kind != Shoulder::Kind::any) {
    const Lane known = f.kind == Shoulder::Kind::meets ? y : x;
    const Lane open = flat2 - known * known;
    const Lane width = edge.part * flat2;
    if (edge.tell) free |= below(magnitude(open), width);
    const Lane rest = line * root(select(below(open, width), width, open));
    x = f.kind == Shoulder::Kind::meets ? rest : x;
    y = f.kind == Shoulder::Kind::meets ? y : rest;
  }
  const double least2 = f.least_length * f.least_length;
  q[1] = toward(fx * y - fy * x, fx * x + fy * y, least2, offered[1], free);
  const LaneVec upper = turned(f.h2, q[1], v) + f.p12;
  q[0] = subproblem_1(upper, aim.p, f.h1, least2, offered[0], free);
  const LaneVec left = turned(f.h1, q[0], upper) - aim.p;
  return dot(left, left);
}

}  // namespace POLYARM_LANES

#pragma GCC diagnostic pop
