#include "polyarm/participant/dds_types.hpp"

namespace polyarm::ros2 {

std::string text_of(const Guid& guid) {
  std::string out;
  for (const std::uint8_t byte : guid) {
    if (!out.empty()) out += '.';
    out += "0123456789abcdef"[byte >> 4];
    out += "0123456789abcdef"[byte & 15];
  }
  return out;
}

Vendor vendor_of(const Guid& guid) {
  if (guid[0] == 1 && guid[1] == 0x0f) return Vendor::fast_dds;
  if (guid[0] == 1 && guid[1] == 0x10) return Vendor::cyclone;
  return Vendor::other;
}

}  // namespace polyarm::ros2
