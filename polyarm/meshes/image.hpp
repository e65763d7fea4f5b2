#pragma once
/// Images that cover meshes. They are passed on as their files have them: only a browser decodes them.
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::meshes {

/// The bytes of a PNG or JPEG file. The parts of a mesh share it.
using Image = std::shared_ptr<const std::string>;

/// Limits of one image; larger ones are left out.
inline constexpr std::size_t kMostImageBytes = bounds::kImageBytes,
                             kMostImagePixels = bounds::kImagePixels;  // pixels in each direction
/// Images of one mesh; further ones are left out.
inline constexpr std::size_t kMostImages = bounds::kImages;

/// "image/png" or "image/jpeg".
const char* media_type(std::string_view image);

/// An empty text if the bytes begin as a PNG or JPEG of acceptable size does; otherwise why they are refused.
/// Reads the header only.
std::string why_no_image(std::string_view bytes);

/// Reads the image `name` that the mesh file `mesh` names. It must lie in the folder of the mesh, or in its
/// package (the nearest folder above with a package.xml), also after links are followed. Null, with a
/// warning, if it does not, is missing, or is no acceptable image.
Image read_image(const std::filesystem::path& mesh, const std::string& name, Problems& problems);

}  // namespace polyarm::meshes
