#pragma once
/// Robot and world in the layout of the kernels, in single precision, and the table of kernels. Metres,
/// radians, in the frame of the robot's base. Private to this room.
///
/// Rounding: each obstacle is grown by a bound on the error of single precision, so a kernel never calls a
/// state free that is not (tests/collision judges it in double precision).
#include <cstddef>
#include <cstdint>

namespace polyarm::collision {

/// A rotation about x that leads to a joint's frame; `any`: the whole matrix. `from_base`: the parent is the
/// base.
enum class Twist : std::uint8_t { none, half, quarter, back_quarter, angle, any };

struct CheckStep {
  int parent = -1;
  std::uint32_t variable = 0;
  bool slides = false;
  Twist twist = Twist::any;
  float ratio = 1, offset = 0;
  float cosine = 1, sine = 0;                ///< angle
  float r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< any: its columns
  float t[3] = {0, 0, 0};
};

struct CheckSphere {
  float x, y, z, r;
};

/// A box with rounded edges: also a sphere (no extent) and a capsule (extent along one axis).
struct CheckBox {
  float c[3], h[3], r;
  float axes[9];  ///< rows: the box's axes in the base; unused if aligned
};
struct CheckCylinder {
  float c[3], axis[3], half, radius, r;  ///< r: grown by
};
/// A polyhedron: a box around it, and the planes of its faces.
struct CheckConvex {
  CheckBox box;
  std::uint32_t first, count;  ///< planes
  float r;
};
struct CheckPlane {
  float n[3], d;
};

/// A node of a tree over many boxes (BoxTree::Node).
struct CheckNode {
  CheckBox box;              ///< aligned, around all below it; r: the largest of theirs
  std::uint32_t next, leaf;  ///< leaf: index of a box, or kNoLeaf
};
inline constexpr std::uint32_t kNoLeaf = UINT32_MAX;

enum class ObstacleKind : std::uint8_t { aligned, turned, cylinder, convex, plane };
inline constexpr std::size_t kObstacleKinds = 5;

struct CheckLink {
  int step = -1;
  std::uint32_t first = 0, count = 0;  ///< spheres
  std::uint32_t row = 0;               ///< of the margins
  CheckSphere around;
  /// The obstacles that it can reach: of each kind from begin[kind] to begin[kind + 1] in
  /// CheckModel::reachable.
  std::uint32_t begin[kObstacleKinds + 1] = {};
  /// Of the boxes, aligned and turned, instead if there are many: nodes from tree[kind] to tree_end[kind].
  std::uint32_t tree[2] = {}, tree_end[2] = {};
};

struct CheckPair {
  std::uint32_t a = 0, b = 0;  ///< CheckLink
  float r = 0;                 ///< extra distance
};

struct CheckModel {
  const CheckStep* step = nullptr;
  const CheckLink* link = nullptr;  ///< far ones first
  const CheckSphere* sphere = nullptr;
  const CheckPair* pair = nullptr;
  const std::uint32_t* reachable = nullptr;
  const CheckBox* aligned = nullptr;
  const CheckBox* turned = nullptr;
  const CheckCylinder* cylinder = nullptr;
  const CheckConvex* convex = nullptr;
  const CheckPlane* face = nullptr;   ///< of the polyhedra
  const CheckPlane* plane = nullptr;  ///< half-spaces
  const CheckNode* node = nullptr;
  std::size_t variables = 0, steps = 0, links = 0, spheres = 0, pairs = 0;
};

/// As many states as a vector has lanes. Rows of margins: first one for each link, then one for each pair.
struct CheckJob {
  /// Rows of one value for each lane: value of variable j of state i at q[j * width + i].
  const float* q = nullptr;
  /// m for each row and lane, or null: also report the states in which something is nearer than this.
  const float* margins = nullptr;
  std::uint32_t lanes = 0;       ///< bits of the states that count
  bool first_is_enough = false;  ///< return as soon as one state touches
};
struct CheckAnswer {
  std::uint32_t touching = 0;  ///< bits of states
  std::uint32_t near =
      0;  ///< with margins: nearer than them; includes `touching` (not after an early return)
};

/// Floats of scratch memory, with an alignment of 64 bytes.
inline constexpr std::size_t scratch_floats(const CheckModel& model, std::size_t width) {
  return (12 * model.steps + 3 * model.spheres + 3 * model.links + 64) * width;
}

struct CheckKernels {
  std::size_t width = 0;  ///< states side by side
  CheckAnswer (*check)(const CheckModel&, const CheckJob&, float* scratch) noexcept;
  /// The index of the row of `nodes` nearest to `q`: value j of node i at nodes[j * stride + i]; stride is a
  /// multiple of 16, and unused nodes up to it are far away. `weights`: of squared differences.
  std::size_t (*nearest)(const float* nodes, std::size_t stride, std::size_t count, std::size_t variables,
                         const float* q, const float* weights) noexcept;
};

namespace portable {
extern const CheckKernels kCheckKernels;
}
namespace avx2 {
extern const CheckKernels kCheckKernels;
}
namespace avx512 {
extern const CheckKernels kCheckKernels;
}

}  // namespace polyarm::collision
