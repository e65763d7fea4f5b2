#pragma once
/// The kernels of closed_form.hpp, compiled once for each instruction set (branches_*.cpp). Private to this
/// room.
#include "polyarm/closed_form/closed_form.hpp"
#include "polyarm/kinematics/ik_solution.hpp"

namespace polyarm::kinematics {

/// Values of axis 4, `cell` apart.
inline constexpr std::size_t kSearchSamples = 64;
struct SearchSamples {
  double cell;
  alignas(64) double s[kSearchSamples], c[kSearchSamples];
};
extern const SearchSamples kSearchAllRound;
/// Refines the marked cells of `of` with the same number of samples, and no other cells.
void search_closer(const SearchSamples& of, const bool* marked, SearchSamples& out) noexcept;

struct BranchKernels {
  void (*solve)(const BranchJob&, Branches&);
  void (*polish)(const BranchJob&, Branches&);
  bool (*quick)(const QuickJob&, const LaneArm&, const Pose&, const double*, QuickAnswers&);
  std::size_t (*search)(const BranchJob&, Branches*, std::size_t);
  void (*nearest)(const QuickJob&, const LaneArm&, std::span<const Pose>, const double*, QuickAnswers&);
  void (*batch)(const QuickJob&, const LaneArm&, std::span<const Pose>, std::span<const double>, IkSolution*,
                std::uint8_t*);
  void (*motions)(const LaneArm&, const Branches&, bool both, LeastMotions&);
};

namespace lanes_portable {
extern const BranchKernels kBranchKernels;
}
namespace lanes_avx2 {
extern const BranchKernels kBranchKernels;
}
namespace lanes_avx512 {
extern const BranchKernels kBranchKernels;
}

}  // namespace polyarm::kinematics
