#include "polyarm/recording/lz4.hpp"

#include <lz4frame.h>

#include <stdexcept>
#include <string>

namespace polyarm::recording {

void add_lz4_frame(std::span<const std::byte> data, std::vector<std::byte>& out) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = LZ4F_max4MB;
  preferences.frameInfo.blockMode = LZ4F_blockIndependent;
  const std::size_t begin = out.size();
  out.resize(begin + LZ4F_compressFrameBound(data.size(), &preferences));
  const std::size_t size =
      LZ4F_compressFrame(out.data() + begin, out.size() - begin, data.data(), data.size(), &preferences);
  out.resize(begin + (LZ4F_isError(size) ? 0 : size));
  if (LZ4F_isError(size)) throw std::runtime_error(std::string("LZ4: ") + LZ4F_getErrorName(size));
}

}  // namespace polyarm::recording
