#pragma once
/// The measured surfaces of a robot, kept beside its robot file as MODEL.look: lofts through convex sections.
/// Lengths in m, in the frames of the links. fitting/fit_look.hpp makes them from meshes. No side effects but
/// reading the file; any thread.
#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/shapes/solid.hpp"

namespace polyarm::shapes {

/// The outline of a convex section is described by its tangents in this many directions.
inline constexpr std::size_t kTangents = 32;

/// A convex section across a loft. In direction k, at 2π k / kTangents from x towards y of the loft's frame,
/// the outline reaches `extent[k]` from the z axis.
struct MeasuredSection {
  double at = 0;  ///< along z of the loft's frame
  std::array<double, kTangents> extent{};
};

struct MeasuredLoft {
  std::string link;   ///< the link that carries it
  std::string paint;  ///< "#rrggbb"; empty: the paint that the maker's style gives this link
  Pose frame;         ///< in the frame of the link; z points along the loft
  std::vector<MeasuredSection> sections;  ///< at least two, in ascending order
};

struct MeasuredLook {
  std::string source;  ///< the description that was measured
  std::vector<MeasuredLoft> lofts;
};

/// The outline that the tangents in every (kTangents / numbers.size())th direction enclose; one number: a
/// circle. numbers.size() is one of kTangentCounts.
std::array<double, kTangents> outline_of(std::span<const double> numbers);
inline constexpr std::array<std::size_t, 5> kTangentCounts{1, 4, 8, 16, kTangents};
/// The fewest tangents whose outline differs nowhere by more than `tolerance` from these extents.
std::vector<double> fewest_tangents(const std::array<double, kTangents>& extent, double tolerance);

/// Reads a file with the first line `polyarm: look/1`: at most 400 lofts of at most 64 sections. Throws Error
/// that names file and line.
MeasuredLook read_measured_look(const std::filesystem::path& path);

/// The file's content. Lengths are rounded to 0.1 mm, directions to 1e-4.
std::string text_of(const MeasuredLook& look);
/// The characters that these lofts need in the file.
std::size_t text_size(const std::vector<MeasuredLoft>& lofts);

/// Adds the surface of a loft, with flat ends.
void add_loft(Solid& solid, const MeasuredLoft& loft, const Paint& paint);

}  // namespace polyarm::shapes
