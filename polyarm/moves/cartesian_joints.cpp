#include "polyarm/moves/cartesian_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/singularity.hpp"
#include "polyarm/moves/joint_rates.hpp"
#include "polyarm/paths/hermite.hpp"

namespace polyarm::moves {
namespace {

using paths::Jet;
using paths::PolynomialPath;
using paths::PoseDerivatives;

constexpr double kThere = 1e-4;          // m and rad: tolerance for a seed at the start of the path
constexpr double kShare = 0.3;           // fraction of the tolerance, at the checked places between nodes
constexpr double kShortest = 1e-6;       // smallest step, as a fraction of the path's piece
constexpr int kMostFailures = 1000;      // rejected steps of one piece
constexpr double kLeast = 1e-9;          // smallest step that is used at all
constexpr double kMostCorrection = 0.3;  // rad or m, largest correction of a joint's predicted value
constexpr double kBeyond = 1e-9;         // rad or m, tolerance beyond a joint's limits
constexpr int kLooks = 64;               // samples of a piece that may reach a limit
constexpr double kFast = 50;             // rad per metre: a faster joint is near a singularity
constexpr std::size_t kPowers = PolynomialPath::kCoefficients;
constexpr std::array<double, 3> kBetween{0.5, 0.2, 0.8};  // checked places of a piece

/// A place on the path, and the joints there.
struct Node {
  double s = 0;
  std::vector<double> q;  ///< of all joints
  JointRates rates;
};

/// On pieces where the TCP only turns, the parameter of a path is in radians.
bool only_turns(const paths::CartesianPath& path, std::size_t piece) {
  const std::span<const double> ends = path.breaks();
  const double middle = (ends[piece] + ends[piece + 1]) / 2;
  return norm(path.on_piece(piece, middle).linear[0]) <= paths::CartesianPath::kTurning;
}

/// The way of the TCP up to the place `s`, without its turns, m.
double metres(const paths::CartesianPath& path, double s) {
  const std::span<const double> ends = path.breaks();
  double out = 0;
  for (std::size_t i = 0; i < path.pieces() && ends[i] < s; ++i)
    if (!only_turns(path, i)) out += std::min(s, ends[i + 1]) - ends[i];
  return out;
}

class Follower {
 public:
  Follower(const kinematics::Chain& chain, const paths::CartesianPath& path, const FollowOptions& options,
           double offset)
      : chain_(chain),
        path_(path),
        options_(options),
        offset_(offset),
        arm_(chain),
        coefficients_(chain.joints() * kPowers) {}

  std::unique_ptr<const PolynomialPath> run(std::span<const double> seed) {
    Node node{0, start(seed), {}};
    out_ = std::make_unique<PolynomialPath>(node.q);
    check_start(node.q);
    for (std::size_t i = 0; i < path_.pieces(); ++i) follow(i, node);
    return std::move(out_);
  }

 private:
  std::size_t piece_at(double s) const {
    std::size_t piece = 0;
    while (piece + 1 < path_.pieces() && path_.breaks()[piece + 1] <= s) ++piece;
    return piece;
  }
  bool turns_at(double s) const { return path_.pieces() > 0 && only_turns(path_, piece_at(s)); }
  /// "0.1200 m", "67.0 deg of the turn", or both.
  std::string place(double s) const {
    const double way = offset_ + metres(path_, s);
    if (!turns_at(s)) return fmt::format("{:.4f} m", way);
    const double begin = path_.breaks()[piece_at(s)];
    const std::string turn = fmt::format("{:.1f} deg of the turn", (s - begin) * 180 / std::numbers::pi);
    return way > 0 ? turn + fmt::format(" after {:.4f} m", way) : turn;
  }
  const char* per(double s) const { return turns_at(s) ? "radian of the turn" : "metre"; }
  /// The place, with the whole way if the TCP moves along.
  std::string place_of_whole(double s) const {
    const double whole = offset_ + metres(path_, path_.length());
    return whole > 0 ? place(s) + fmt::format(" (of {:.4f} m)", whole) : place(s);
  }
  const char* unit(std::size_t joint) const { return chain_.slides(joint) ? "m" : "rad"; }

  std::vector<double> start(std::span<const double> seed) {
    if (seed.size() != chain_.joints())
      throw Error("wrong-size",
                  fmt::format("the seed has {} joint values, the robot {}", seed.size(), chain_.joints()));
    const Pose first = path_.at(0).pose;
    std::vector<double> q(seed.begin(), seed.end());
    arm_.at(q);
    const auto error = tcp_error(arm_, first);
    const bool there =
        std::all_of(error.begin(), error.end(), [](double e) { return std::abs(e) <= kThere; });
    if (there && settle(arm_, q, first)) return q;
    q = nearest(first, seed);
    if (settle(arm_, q, first)) return q;
    throw Error("singular", "the joint state at " + place(0) + ", where the path begins, is singular",
                "begin elsewhere, or in another configuration");
  }

  std::vector<double> nearest(const Pose& first, std::span<const double> seed) {
    ik::IkSolution found;
    const bool there = (solver().solve(first, seed, found) == ik::IkOutcome::solved && found.exact) ||
                       solver().solve_move(first, seed, seed, found) == ik::IkOutcome::solved;
    if (there) return {found.q.begin(), found.q.begin() + static_cast<std::ptrdiff_t>(chain_.joints())};
    const ik::IkExplanation why = solver().explain(first, seed);
    throw Error(why.outcome == ik::IkOutcome::limits ? "limit" : "unreachable",
                "the path cannot be reached where it begins, at " + place(0) + ": " + why.reason,
                "move the path, or the robot's base");
  }
  const ik::InverseKinematics& solver() {
    if (!solver_) solver_ = std::make_unique<ik::InverseKinematics>(chain_);
    return *solver_;
  }

  void check_start(const std::vector<double>& q) const {
    for (const std::size_t j : arm_.joints())
      if (outside(j, q[j])) throw_limit(j, q[j], 0);
  }
  bool outside(std::size_t joint, double value) const {
    return value < chain_.lower()[joint] - kBeyond || value > chain_.upper()[joint] + kBeyond;
  }

  /// One piece of the path; `node` is at its start, afterwards at its end.
  void follow(std::size_t piece, Node& node) {
    const double begin = path_.breaks()[piece], end = path_.breaks()[piece + 1];
    const double shortest = std::max(kLeast, kShortest * (end - begin));
    node.s = begin;
    arm_.at(node.q);
    if (!find_rates(arm_, path_.on_piece(piece, begin), node.rates)) refuse(node);
    bool first = true;
    int failed = 0;
    double h = end - begin;
    while (node.s < end) {
      const double left = end - node.s;
      const bool to_end = h >= left;
      h = to_end ? left : left / std::ceil(left / h - 1e-9);
      Node next{to_end ? end : node.s + h, node.q, {}};
      const double error = reach(piece, node, next) ? join(piece, node, next) : 1e9;
      if (error <= kShare) {
        check_limits(node.s, next.s - node.s);
        out_->append(next.s - node.s, coefficients_,
                     first ? paths::PieceJoin::third_jumps : paths::PieceJoin::third_continues);
        first = false;
        node = std::move(next);
      } else if (h <= 2 * shortest || ++failed > kMostFailures) {
        refuse(node);
      }
      // The error is proportional to the eighth power of the step.
      h = std::max(shortest,
                   h * std::clamp(0.9 * std::pow(kShare / std::max(error, 1e-12), 0.125), 0.25, 3.0));
    }
  }

  /// Computes the joints at next.s from those at `node`.
  bool reach(std::size_t piece, const Node& node, Node& next) {
    const double h = next.s - node.s;
    const PoseDerivatives there = path_.on_piece(piece, next.s);
    for (std::size_t k = 0; k < arm_.columns(); ++k)
      next.q[arm_.joints()[k]] +=
          h * (node.rates.d[0][k] + h / 2 * (node.rates.d[1][k] + h / 3 * node.rates.d[2][k]));
    const std::vector<double> expected = next.q;
    if (!arrive(there, expected, next)) return false;
    if (arm_.columns() <= 6) return true;
    // Of all joint states for this pose, chooses the one closest to the prediction from the rates at both
    // ends.
    for (std::size_t k = 0; k < arm_.columns(); ++k) {
      const auto &a = node.rates.d, &b = next.rates.d;
      next.q[arm_.joints()[k]] =
          node.q[arm_.joints()[k]] +
          h * ((a[0][k] + b[0][k]) / 2 + h * ((a[1][k] - b[1][k]) / 10 + h / 120 * (a[2][k] + b[2][k])));
    }
    return arrive(there, expected, next);
  }
  bool arrive(const PoseDerivatives& there, const std::vector<double>& expected, Node& next) {
    if (!settle(arm_, next.q, there.pose)) return false;
    for (const std::size_t j : arm_.joints())
      if (!(std::abs(next.q[j] - expected[j]) <= kMostCorrection)) return false;
    return find_rates(arm_, there, next.rates);
  }

  /// Writes the piece between two nodes. Returns its deviation from the path, in tolerances.
  double join(std::size_t piece, const Node& a, const Node& b) {
    const double h = b.s - a.s;
    for (std::size_t j = 0; j < chain_.joints(); ++j) {
      std::fill_n(coefficients_.begin() + static_cast<std::ptrdiff_t>(j * kPowers), kPowers, 0.0);
      coefficients_[j * kPowers] = a.q[j];
    }
    for (std::size_t k = 0; k < arm_.columns(); ++k) {
      const std::size_t j = arm_.joints()[k];
      const auto jet = [&](const Node& n) {
        return Jet<double>{n.q[j], n.rates.d[0][k], n.rates.d[1][k], n.rates.d[2][k]};
      };
      const auto c = paths::hermite7(jet(a), jet(b), h);
      std::copy(c.begin(), c.end(), coefficients_.begin() + static_cast<std::ptrdiff_t>(j * kPowers));
    }
    double most = 0;
    for (const double share : kBetween) {
      const Pose is = chain_.forward(joints_at(share)), should = path_.on_piece(piece, a.s + share * h).pose;
      const Quaternion off = inverse(should.rotation) * is.rotation;
      most = std::max({most, norm(is.position - should.position) / options_.position_tolerance,
                       2 * norm({off.x, off.y, off.z}) / options_.orientation_tolerance});
      if (!(most <= 1)) break;
    }
    return most;
  }
  const std::vector<double>& joints_at(double share) {
    looked_.resize(chain_.joints());
    for (std::size_t j = 0; j < chain_.joints(); ++j) looked_[j] = joint_at(j, share);
    return looked_;
  }
  double joint_at(std::size_t joint, double share) const {
    const double* c = coefficients_.data() + joint * kPowers;
    double value = c[kPowers - 1];
    for (std::size_t k = kPowers - 1; k-- > 0;) value = share * value + c[k];
    return value;
  }

  void check_limits(double s, double h) const {
    for (const std::size_t j : arm_.joints()) {
      const double* c = coefficients_.data() + j * kPowers;
      double reach = 0;  // largest possible distance from c[0]
      for (std::size_t k = 1; k < kPowers; ++k) reach += std::abs(c[k]);
      if (!outside(j, c[0] - reach) && !outside(j, c[0] + reach)) continue;
      for (int look = 1; look <= kLooks; ++look) {
        const double share = static_cast<double>(look) / kLooks;
        if (outside(j, joint_at(j, share)))
          throw_limit(j, joint_at(j, share), s + h * first_outside(j, share));
      }
    }
  }
  double first_outside(std::size_t joint, double share) const {
    double low = share - 1.0 / kLooks, high = share;
    for (int k = 0; k < 40; ++k) {
      const double middle = (low + high) / 2;
      (outside(joint, joint_at(joint, middle)) ? high : low) = middle;
    }
    return high;
  }

  [[noreturn]] void throw_limit(std::size_t joint, double value, double s) const {
    const bool upper = value > chain_.upper()[joint];
    throw Error(
        "limit",
        fmt::format("at {}{}, {} reaches its {} limit of {:.4f} {}", place(s),
                    turns_at(s) ? "" : " of the path", chain_.names()[joint], upper ? "upper" : "lower",
                    upper ? chain_.upper()[joint] : chain_.lower()[joint], unit(joint)),
        "begin in another configuration, or a turn of that joint further back, or move the path");
  }

  /// Throws the reason why the path cannot be followed beyond `node`.
  [[noreturn]] void refuse(const Node& node) {
    for (const double ahead : {1e-2, 1e-3, 1e-5}) {
      const double s = std::min(node.s + ahead, path_.length());
      const ik::IkExplanation found = solver().explain(path_.at(s).pose, node.q);
      if (found.outcome == ik::IkOutcome::solved || found.outcome == ik::IkOutcome::limits) continue;
      if (arm_.columns() < 6)
        throw Error("unreachable",
                    fmt::format("the arm's {} joints cannot follow the path at {}: {}", arm_.columns(),
                                place_of_whole(node.s), found.reason),
                    "with fewer than six joints not every orientation can be kept: choose one that can");
      throw Error(
          "unreachable",
          fmt::format("the path leaves the robot's reach at {}: {}", place_of_whole(node.s), found.reason),
          "move the path nearer, or let the TCP turn along the way");
    }
    arm_.at(node.q);
    const FastestJoint fastest = fastest_joint(arm_, path_.at(node.s));
    const double gap = kinematics::smallest_singular_value(chain_, node.q);
    if (fastest.rate > kFast || !(gap > kinematics::kSingular)) throw_singular(node, fastest, gap);
    throw Error("branch",
                "the path continues at " + place(node.s) + " only in another configuration of the arm",
                "begin in that configuration, or move there by joints");
  }

  [[noreturn]] void throw_singular(const Node& node, const FastestJoint& fastest, double gap) const {
    const std::size_t joint = arm_.joints()[fastest.column];
    const std::string rate = std::isfinite(fastest.rate)
                                 ? fmt::format("by {:.3g} {} per {}", fastest.rate, unit(joint), per(node.s))
                                 : std::string("without bound");
    throw Error("singular",
                fmt::format("the path meets a singularity at {}: {} would turn {} there (smallest singular "
                            "value {:.1e})",
                            place(node.s), chain_.names()[joint], rate, gap),
                "move the path aside, turn the TCP along the way, or move there by joints");
  }

  const kinematics::Chain& chain_;
  const paths::CartesianPath& path_;
  const FollowOptions& options_;
  double offset_;  // m: of the sections before, in errors
  ArmDerivatives arm_;
  std::unique_ptr<ik::InverseKinematics> solver_;  // created on demand
  std::vector<double> coefficients_;               // of the piece under construction
  std::vector<double> looked_;
  std::unique_ptr<PolynomialPath> out_;
};

}  // namespace

std::unique_ptr<const PolynomialPath> joints_along(const kinematics::Chain& chain,
                                                   const paths::CartesianPath& path,
                                                   std::span<const double> seed,
                                                   const FollowOptions& options) {
  return Follower(chain, path, options, 0).run(seed);
}

paths::PathSections joints_along(const kinematics::Chain& chain, const paths::CartesianSections& path,
                                 std::span<const double> seed, const FollowOptions& options) {
  paths::PathSections out;
  out.warnings = path.warnings;
  std::vector<double> at(seed.begin(), seed.end());
  double offset = 0;
  for (const paths::CartesianPath& section : path.sections) {
    auto joints = Follower(chain, section, options, offset).run(at);
    offset += metres(section, section.length());
    joints->at(joints->length(), {at, {}, {}, {}});
    out.sections.push_back(std::move(joints));
  }
  return out;
}

paths::TcpDistance tcp_distance(const kinematics::Chain& chain) {
  return [&chain](std::span<const double> a, std::span<const double> b) {
    return norm(chain.forward(a).position - chain.forward(b).position);
  };
}

}  // namespace polyarm::moves
