/// sensor_msgs/PointCloud2 as CDR (XCDR1), as MCAP files and rosbags store it. Source: OMG DDSI-RTPS 10 and
/// the message's definition in common_interfaces.
#include <bit>
#include <cstring>
#include <optional>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/clouds/cloud_file.hpp"

namespace polyarm::clouds {

namespace {

constexpr std::uint32_t kMostFields2 = bounds::kCloudFields;

/// Reads values of CDR in order. After the end everything is zero and `whole` is false.
class CdrWords {
 public:
  explicit CdrWords(std::string_view bytes) : bytes_(bytes.substr(std::min<std::size_t>(4, bytes.size()))) {
    whole_ = bytes.size() >= 4 && bytes[0] == 0 && (bytes[1] == 0 || bytes[1] == 1);
    big_ = bytes.size() >= 2 && bytes[1] == 0;
  }
  bool whole() const { return whole_; }
  std::uint8_t byte() {
    const std::string_view at = take(1);
    return at.empty() ? 0 : static_cast<std::uint8_t>(at[0]);
  }
  std::uint32_t word() {
    at_ = (at_ + 3) / 4 * 4;
    const std::string_view bytes = take(4);
    std::uint32_t out = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      out |= std::uint32_t{static_cast<std::uint8_t>(bytes[big_ ? 3 - i : i])} << (8 * i);
    return out;
  }
  std::string_view text() {
    const std::string_view all = take(word());
    return all.empty() ? all : all.substr(0, all.size() - 1);
  }
  std::string_view take(std::size_t size) {
    if (at_ > bytes_.size() || size > bytes_.size() - at_) {
      whole_ = false;
      return {};
    }
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool whole_ = true, big_ = false;
};

/// sensor_msgs/PointField: INT8 is 1, FLOAT64 is 8.
std::optional<NumberType> type_of_field(std::uint8_t datatype) {
  if (datatype < 1 || datatype > 8) return std::nullopt;
  return static_cast<NumberType>(datatype - 1);
}

[[noreturn]] void refuse_message(const std::string& name, const std::string& what) {
  throw Error("bad-cloud", "the point cloud " + name + " is not a whole sensor_msgs/PointCloud2: " + what,
              "record it again");
}

}  // namespace

void read_point_cloud2(std::string_view bytes, const std::string& name, double scale, CloudGrid& grid) {
  CdrWords words(bytes);
  words.word(), words.word();  // stamp
  words.text();                // frame_id
  const std::size_t height = words.word(), width = words.word();
  const std::uint32_t fields = words.word();
  if (!words.whole() || fields > kMostFields2) refuse_message(name, "its header is damaged");
  PointLayout layout;
  std::optional<NumberType> types[3];
  std::size_t offsets[3] = {};
  for (std::uint32_t i = 0; i < fields && words.whole(); ++i) {
    const std::string_view field = words.text();
    const std::size_t offset = words.word();
    const std::uint8_t datatype = words.byte();
    words.word();  // count
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (field.size() == 1 && field[0] == "xyz"[axis])
        types[axis] = type_of_field(datatype), offsets[axis] = offset;
  }
  layout.big_endian = words.byte() != 0;
  const std::size_t step = words.word(), row = words.word();
  const std::string_view data = words.take(words.word());
  if (!words.whole()) refuse_message(name, "it ends too early");
  if (height > kMostPoints || width > kMostPoints || height * width > kMostPoints)
    throw Error("large-cloud",
                "the point cloud " + name + " has more than " + std::to_string(kMostPoints) + " points",
                "thin it out");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!types[axis]) refuse_message(name, std::string("it has no usable field ") + "xyz"[axis]);
    layout.coordinate[axis] = {offsets[axis], step, *types[axis]};
  }
  layout.points = width;
  for (std::size_t i = 0; i < height; ++i) {
    if (i * row > data.size()) refuse_message(name, "its data is too short");
    add_points(data.substr(i * row), layout, scale, grid);
  }
}

}  // namespace polyarm::clouds
