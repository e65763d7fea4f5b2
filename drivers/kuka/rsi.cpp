#include "drivers/kuka/rsi.hpp"

#include <fmt/format.h>

#include "drivers/wire/xml.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::kuka {

namespace {

using wire::XmlDocument;

constexpr std::array<const char*, 6> kRsiAxes{"A1", "A2", "A3", "A4", "A5", "A6"};
constexpr std::array<const char*, 6> kPose{"X", "Y", "Z", "A", "B", "C"};

std::string six_in(const char* element, const std::array<const char*, 6>& names, const Six& values) {
  std::string out = fmt::format("<{}", element);
  for (std::size_t i = 0; i < 6; ++i) out += fmt::format(" {}=\"{:.6f}\"", names[i], values[i] + 0.0);
  return out + "/>";
}

std::optional<Six> six_of(const XmlDocument& document, const char* element,
                          const std::array<const char*, 6>& names) noexcept {
  const auto* found = document.find(element);
  if (!found) return std::nullopt;
  Six out;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto value = document.number(*found, names[i]);
    if (!value) return std::nullopt;
    out[i] = *value;
  }
  return out;
}

std::optional<std::uint64_t> ipoc_of(const XmlDocument& document) noexcept {
  const auto* found = document.find("IPOC");
  const auto value = found ? wire::xml_integer(found->text) : std::nullopt;
  return value && *value >= 0 ? std::optional(static_cast<std::uint64_t>(*value)) : std::nullopt;
}

bool read_datagram(XmlDocument& document, std::string_view text) noexcept {
  return text.size() <= bounds::kRsiDatagramBytes && document.read(text) == XmlDocument::Result::whole;
}

}  // namespace

std::string encode(const RsiRobot& robot) {
  std::string out = "<Rob Type=\"KUKA\">";
  if (robot.pose) out += six_in("RIst", kPose, *robot.pose);
  if (robot.target) out += six_in("RSol", kPose, *robot.target);
  out += six_in("AIPos", kRsiAxes, robot.axes);
  if (robot.setpoint) out += six_in("ASPos", kRsiAxes, *robot.setpoint);
  if (robot.delay) out += fmt::format("<Delay D=\"{}\"/>", *robot.delay);
  return out + fmt::format("<DiL>{}</DiL><IPOC>{}</IPOC></Rob>", robot.inputs, robot.ipoc);
}

std::string encode(const RsiSensor& sensor, const std::string& type) {
  return fmt::format("<Sen Type=\"{}\"><Stop>{}</Stop>{}<IPOC>{}</IPOC></Sen>", type, sensor.stop ? 1 : 0,
                     six_in("AK", kRsiAxes, sensor.correction), sensor.ipoc);
}

std::optional<RsiRobot> decode_robot(std::string_view text) noexcept {
  XmlDocument document;
  if (!read_datagram(document, text) || document.root().name != "Rob") return std::nullopt;
  RsiRobot out;
  const auto ipoc = ipoc_of(document);
  const auto axes = six_of(document, "AIPos", kRsiAxes);
  if (!ipoc || !axes) return std::nullopt;
  out.ipoc = *ipoc;
  out.axes = *axes;
  out.setpoint = six_of(document, "ASPos", kRsiAxes);
  out.pose = six_of(document, "RIst", kPose);
  out.target = six_of(document, "RSol", kPose);
  if (const auto* delay = document.find("Delay"))
    if (const auto count = document.integer(*delay, "D"); count && *count >= 0 && *count <= 1'000'000)
      out.delay = static_cast<int>(*count);
  if (const auto* inputs = document.find("DiL"))
    if (const auto bits = wire::xml_integer(inputs->text)) out.inputs = static_cast<std::uint32_t>(*bits);
  return out;
}

std::optional<RsiSensor> decode_sensor(std::string_view text, std::string_view type) noexcept {
  XmlDocument document;
  if (!read_datagram(document, text) || document.root().name != "Sen") return std::nullopt;
  if (document.attribute(document.root(), "Type") != type) return std::nullopt;
  RsiSensor out;
  const auto ipoc = ipoc_of(document);
  const auto correction = six_of(document, "AK", kRsiAxes);
  if (!ipoc || !correction) return std::nullopt;
  out.ipoc = *ipoc;
  out.correction = *correction;
  const auto* stop = document.find("Stop");
  out.stop = stop && wire::xml_integer(stop->text).value_or(0) != 0;
  return out;
}

}  // namespace polyarm::kuka
