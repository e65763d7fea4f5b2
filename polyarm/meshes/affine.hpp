#pragma once
/// Affine maps of mesh files: three rows of four numbers, the last one a length.
#include <array>
#include <cstddef>

namespace polyarm::meshes {

using Affine = std::array<std::array<double, 4>, 3>;
inline constexpr Affine kIdentity{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

inline Affine operator*(const Affine& a, const Affine& b) {
  Affine out{};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 4; ++c)
      out[r][c] = a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c] + (c == 3 ? a[r][3] : 0);
  return out;
}

/// Below zero for a map that mirrors.
inline double determinant(const Affine& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

}  // namespace polyarm::meshes
