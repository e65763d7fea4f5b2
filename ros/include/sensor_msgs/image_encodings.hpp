#pragma once
/// Names of pixel formats in sensor_msgs/msg/Image, and their channels and bits.
#include <stdexcept>
#include <string>

namespace sensor_msgs::image_encodings {
inline const std::string RGB8 = "rgb8", RGBA8 = "rgba8", RGB16 = "rgb16", RGBA16 = "rgba16", BGR8 = "bgr8",
                         BGRA8 = "bgra8", BGR16 = "bgr16", BGRA16 = "bgra16", MONO8 = "mono8",
                         MONO16 = "mono16";
inline const std::string TYPE_8UC1 = "8UC1", TYPE_8UC2 = "8UC2", TYPE_8UC3 = "8UC3", TYPE_8UC4 = "8UC4";
inline const std::string TYPE_8SC1 = "8SC1", TYPE_8SC2 = "8SC2", TYPE_8SC3 = "8SC3", TYPE_8SC4 = "8SC4";
inline const std::string TYPE_16UC1 = "16UC1", TYPE_16UC2 = "16UC2", TYPE_16UC3 = "16UC3",
                         TYPE_16UC4 = "16UC4";
inline const std::string TYPE_16SC1 = "16SC1", TYPE_16SC2 = "16SC2", TYPE_16SC3 = "16SC3",
                         TYPE_16SC4 = "16SC4";
inline const std::string TYPE_32SC1 = "32SC1", TYPE_32SC2 = "32SC2", TYPE_32SC3 = "32SC3",
                         TYPE_32SC4 = "32SC4";
inline const std::string TYPE_32FC1 = "32FC1", TYPE_32FC2 = "32FC2", TYPE_32FC3 = "32FC3",
                         TYPE_32FC4 = "32FC4";
inline const std::string TYPE_64FC1 = "64FC1", TYPE_64FC2 = "64FC2", TYPE_64FC3 = "64FC3",
                         TYPE_64FC4 = "64FC4";
inline const std::string BAYER_RGGB8 = "bayer_rggb8", BAYER_BGGR8 = "bayer_bggr8",
                         BAYER_GBRG8 = "bayer_gbrg8", BAYER_GRBG8 = "bayer_grbg8",
                         BAYER_RGGB16 = "bayer_rggb16", BAYER_BGGR16 = "bayer_bggr16",
                         BAYER_GBRG16 = "bayer_gbrg16", BAYER_GRBG16 = "bayer_grbg16";
inline const std::string UYVY = "uyvy", YUYV = "yuyv", YUV422 = "yuv422", YUV422_YUY2 = "yuv422_yuy2",
                         NV21 = "nv21", NV24 = "nv24";

inline bool isColor(const std::string& name) {
  for (const std::string* each : {&RGB8, &RGBA8, &RGB16, &RGBA16, &BGR8, &BGRA8, &BGR16, &BGRA16})
    if (*each == name) return true;
  return false;
}
inline bool isMono(const std::string& name) {
  return name == MONO8 || name == MONO16;
}
inline bool isBayer(const std::string& name) {
  return name.compare(0, 6, "bayer_") == 0;
}
inline bool hasAlpha(const std::string& name) {
  return name == RGBA8 || name == RGBA16 || name == BGRA8 || name == BGRA16;
}
inline int numChannels(const std::string& name) {
  if (isMono(name) || isBayer(name)) return 1;
  if (isColor(name)) return hasAlpha(name) ? 4 : 3;
  for (const std::string* each : {&UYVY, &YUYV, &YUV422, &YUV422_YUY2, &NV21, &NV24})
    if (*each == name) return 2;
  const auto at = name.find('C');  // "8UC3"; without a number there is one channel
  if (at == std::string::npos || at == 0) throw std::runtime_error("Unknown encoding " + name);
  return at + 1 < name.size() ? name[at + 1] - '0' : 1;
}
inline int bitDepth(const std::string& name) {
  if (isColor(name) || isMono(name) || isBayer(name)) return name.find("16") == std::string::npos ? 8 : 16;
  const auto at = name.find_first_of("USF");
  if (at == std::string::npos || at == 0 || name[0] < '0' || name[0] > '9') return 8;
  return std::stoi(name.substr(0, at));
}
}  // namespace sensor_msgs::image_encodings
