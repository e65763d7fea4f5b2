#include "polyarm/moves/move_parts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/moves/tcp_rates.hpp"

namespace polyarm::moves {

using paths::Path;
using PathPtr = std::shared_ptr<const Path>;

namespace {

/// The TCP's way on a joint path with three values.
class NoPath final : public Path {
 public:
  explicit NoPath(PathPtr like) : like_(std::move(like)) {}
  std::size_t joints() const noexcept override { return 3; }
  double length() const noexcept override { return like_->length(); }
  void at(double, const paths::PathDerivatives& out) const noexcept override {
    for (const std::span<double> values : {out.q, out.first, out.second, out.third})
      std::fill(values.begin(), values.end(), 0.0);
  }
  std::span<const double> breaks() const noexcept override { return like_->breaks(); }

 private:
  PathPtr like_;
};

}  // namespace

std::vector<double> joints_at(const Path& path, double s) {
  std::vector<double> q(path.joints());
  path.at(s, {q, {}, {}, {}});
  return q;
}

double norm_of(std::span<const double> v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

bool needs_tcp(const PlanRequest& request, std::size_t first, std::size_t last) {
  if (request.options.tcp_ceiling > 0) return true;
  for (std::size_t i = first; i <= last; ++i)
    if (request.moves[i].tcp_speed > 0 || request.moves[i].tcp_acceleration > 0 ||
        request.moves[i].turn_speed > 0 || request.moves[i].turn_acceleration > 0)
      return true;
  return false;
}
void give_tcp(const PlanRequest& request, MovePart& part, bool bounded) {
  if (bounded) {
    part.translation = std::make_shared<TcpPath>(request.robot.chain, part.joints, TcpPart::translation);
    part.rotation = std::make_shared<TcpPath>(request.robot.chain, part.joints, TcpPart::rotation);
  } else {
    part.translation = part.rotation = std::make_shared<NoPath>(part.joints);
  }
}

}  // namespace polyarm::moves
