#include "polyarm/shapes/style.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "polyarm/base/text.hpp"
#include "polyarm/description/look.hpp"

namespace polyarm::shapes {

namespace {

constexpr Paint paint(std::uint32_t rgb, float roughness = 0.5f, float metallic = 0) {
  const auto channel = [&](int shift) { return static_cast<float>((rgb >> shift) & 255) / 255; };
  return {{channel(16), channel(8), channel(0)}, roughness, metallic};
}

// Paints that several families share.
constexpr Paint kWhite = paint(0xF2F2F0, 0.38f), kPearl = paint(0xE4E5E3, 0.42f),
                kSilver = paint(0xB9BEC3, 0.34f, 0.55f), kAluminium = paint(0xC9CCD0, 0.3f, 0.8f),
                kGrey = paint(0x8B9299, 0.5f), kSlate = paint(0x4B5157, 0.5f), kDark = paint(0x2A2D31, 0.5f),
                kBlack = paint(0x17181A, 0.45f);

/// A family of robots. The first row that matches the maker and the model's name is used.
struct Row {
  const char* name;
  const char* maker;   ///< as in the catalogue; empty matches no maker
  const char* models;  ///< beginnings of model names, or whole names with '$', separated by '|'; empty: all
  Build build;
  Paint base, body, fore, wrist, joint, cap;
  double edge, tube, corner, cap_size, dome;
  std::optional<Paint> housing = std::nullopt;
};

constexpr Paint kFanucYellow = paint(0xF7C600, 0.42f), kFanucGreen = paint(0x6FA83A, 0.45f),
                kAbbWhite = paint(0xE9E8E4, 0.42f), kAbbOrange = paint(0xF2570F, 0.45f),
                kKukaOrange = paint(0xFF5A0A, 0.42f), kYaskawaBlue = paint(0x0A55A8, 0.42f),
                kUrBody = paint(0xC6CACE, 0.36f, 0.35f), kUrCap = paint(0x6CA9D2, 0.45f),
                kUrHousing = paint(0x47494C, 0.42f), kCrxGreen = paint(0x2EA43A, 0.45f),
                kIiwaOrange = paint(0xFF6A13, 0.45f), kStaubliYellow = paint(0xF0B61E, 0.42f),
                kFilament = paint(0xF5A81C, 0.62f);

// name, maker, models, build, base, body, fore, wrist, joint ring, cover, edge, tube, corner, cover size,
// dome
constexpr std::array kRows{
    Row{"universal_robots_dark", "Universal Robots", "UR3$|UR3e|UR5|UR7|UR10|UR12|UR16", Build::cobot,
        kUrHousing, kUrBody, kUrBody, kUrHousing, kDark, kUrCap, 0.16, 0.70, 1, 0.93, 0.22, kUrHousing},
    Row{"universal_robots", "Universal Robots", "", Build::cobot, kUrBody, kUrBody, kUrBody, kUrBody, kDark,
        kUrCap, 0.16, 0.80, 1, 0.93, 0.16},
    Row{"fanuc_crx", "FANUC", "CRX", Build::cobot, paint(0x3B3F43), kWhite, kWhite, kWhite, kCrxGreen, kWhite,
        0.34, 0.88, 1, 0.84, 0.10},
    Row{"fanuc_cr", "FANUC", "CR-", Build::cast, kFanucGreen, kFanucGreen, kFanucGreen, kFanucGreen, kDark,
        kFanucGreen, 0.22, 0.86, 0.7, 0.8, 0.12},
    Row{"fanuc_lr_mate", "FANUC", "LR Mate|ER-", Build::cast, kSlate, kFanucYellow, kFanucYellow,
        kFanucYellow, kDark, kFanucYellow, 0.22, 0.86, 0.62, 0.80, 0.14},
    Row{"fanuc_paint", "FANUC", "P-", Build::cast, kPearl, kPearl, kPearl, kSlate, kDark, kPearl, 0.16, 0.84,
        0.5, 0.8, 0.1},
    Row{"fanuc", "FANUC", "", Build::cast, kFanucYellow, kFanucYellow, kFanucYellow, kFanucYellow, kDark,
        kDark, 0.14, 0.84, 0.45, 0.66, 0.22},
    Row{"abb_gofa", "ABB", "CRB", Build::soft, kPearl, kWhite, kWhite, kWhite, kSlate, kGrey, 0.4, 0.9, 1,
        0.86, 0.1},
    Row{"abb_orange", "ABB", "IRB 2400|IRB 4400|IRB 6600|IRB 6640|IRB 6650|IRB 7600", Build::cast, kAbbOrange,
        kAbbOrange, kAbbOrange, kAbbOrange, kDark, kDark, 0.12, 0.84, 0.4, 0.62, 0.24},
    Row{"abb_paint", "ABB", "IRB 52|IRB 5400", Build::cast, kAbbWhite, kAbbWhite, kAbbWhite, kAbbWhite, kGrey,
        kAbbWhite, 0.16, 0.84, 0.5, 0.8, 0.12},
    Row{"abb", "ABB", "", Build::cast, kAbbWhite, kAbbWhite, kAbbWhite, kAbbWhite, kSlate, kAbbWhite, 0.18,
        0.85, 0.5, 0.80, 0.14},
    Row{"kuka_lbr", "KUKA", "LBR iiwa|LBR Med", Build::soft, paint(0xC9CCCE, 0.35f, 0.25f),
        paint(0xDADCDD, 0.34f, 0.2f), paint(0xDADCDD, 0.34f, 0.2f), paint(0xDADCDD, 0.34f, 0.2f),
        paint(0xC2C6C9, 0.34f, 0.3f), kIiwaOrange, 0.42, 0.95, 1, 0.78, 0.06},
    Row{"kuka_iisy", "KUKA", "LBR iisy", Build::soft, kWhite, kWhite, kWhite, kWhite, kDark, kKukaOrange, 0.4,
        0.92, 1, 0.8, 0.08},
    Row{"kuka_small", "KUKA", "KR 3 |KR 4 |KR 6 R|KR 7|KR 10 R9|KR 10 R11|KR 13|KR 16 R11", Build::cast,
        kSlate, kKukaOrange, kKukaOrange, kDark, kBlack, kSlate, 0.22, 0.86, 0.6, 0.80, 0.12},
    Row{"kuka", "KUKA", "", Build::cast, kBlack, kKukaOrange, kKukaOrange, kDark, kBlack, kBlack, 0.14, 0.84,
        0.42, 0.64, 0.24},
    Row{"yaskawa_hc", "Yaskawa", "HC", Build::cobot, kYaskawaBlue, kPearl, kPearl, kPearl, kDark,
        kYaskawaBlue, 0.30, 0.88, 0.9, 0.88, 0.12},
    Row{"yaskawa_seven", "Yaskawa", "SIA|SDA", Build::cobot, kYaskawaBlue, kYaskawaBlue, kYaskawaBlue,
        kYaskawaBlue, kPearl, kPearl, 0.24, 0.88, 0.9, 0.8, 0.1},
    Row{"yaskawa", "Yaskawa", "", Build::cast, kYaskawaBlue, kYaskawaBlue, kYaskawaBlue, kYaskawaBlue,
        paint(0xC8CCD0), kYaskawaBlue, 0.20, 0.85, 0.55, 0.74, 0.16},
    Row{"franka", "Franka", "", Build::soft, kWhite, kWhite, kWhite, kWhite, kBlack, paint(0x34373A, 0.4f),
        0.5, 0.96, 1, 0.82, 0.05},
    Row{"ufactory", "UFACTORY", "", Build::cobot, kWhite, kWhite, kWhite, kWhite, kSlate,
        paint(0x5A6066, 0.4f, 0.3f), 0.12, 0.86, 1, 0.9, 0.08},
    Row{"kawasaki_duaro", "Kawasaki", "duAro", Build::scara, kDark, kWhite, kWhite, kDark, kDark, kWhite, 0.2,
        0.8, 0.6, 0.85, 0.1},
    Row{"kawasaki", "Kawasaki", "", Build::cast, kGrey, kWhite, kWhite, kWhite, kSlate, kGrey, 0.2, 0.84, 0.6,
        0.74, 0.14},
    Row{"staubli_tx2", "St\xC3\xA4ubli", "TX2", Build::cast, paint(0xD8D9D6, 0.35f), kPearl, kPearl, kPearl,
        kStaubliYellow, kPearl, 0.34, 0.92, 0.9, 0.86, 0.14},
    Row{"staubli", "St\xC3\xA4ubli", "", Build::cast, kStaubliYellow, kStaubliYellow, kStaubliYellow,
        kStaubliYellow, kGrey, kStaubliYellow, 0.32, 0.92, 0.9, 0.86, 0.14},
    Row{"denso_cobotta", "DENSO", "COBOTTA|Cobotta", Build::soft, kWhite, kWhite, kWhite, kWhite, kPearl,
        kPearl, 0.45, 0.95, 1, 0.85, 0.06},
    Row{"denso_scara", "DENSO", "HSR", Build::scara, kWhite, kWhite, kWhite, kAluminium, kGrey, kWhite, 0.15,
        0.8, 0.7, 0.86, 0.08},
    Row{"denso", "DENSO", "", Build::cast, kPearl, kWhite, kWhite, kWhite, kGrey, kPearl, 0.26, 0.88, 0.7,
        0.82, 0.12},
    Row{"doosan", "Doosan", "", Build::cobot, kWhite, kWhite, kWhite, kWhite, paint(0x2E7FC2),
        paint(0xD5DADF, 0.35f, 0.2f), 0.3, 0.88, 1, 0.88, 0.1},
    Row{"techman", "Techman", "", Build::cobot, paint(0x5A5F64), kWhite, kWhite, kWhite, paint(0x3C4043),
        paint(0x6B7278), 0.28, 0.86, 1, 0.88, 0.1},
    Row{"kinova_gen3", "Kinova", "Gen3", Build::soft, kSlate, kWhite, kWhite, kWhite, kBlack, kSlate, 0.35,
        0.92, 1, 0.9, 0.08},
    Row{"kinova", "Kinova", "", Build::soft, kBlack, kBlack, kBlack, kBlack, kSilver, kSilver, 0.3, 0.8, 1,
        0.92, 0.1},
    Row{"so_arm", "TheRobotStudio", "", Build::servo, kFilament, kFilament, kFilament, kFilament, kBlack,
        kBlack, 0.1, 0.7, 0.25, 0.6, 0.1},
    Row{"trossen", "Trossen Robotics", "", Build::servo, kBlack, kDark, kDark, kDark, kBlack, kBlack, 0.1,
        0.6, 0.25, 0.6, 0.1},
    Row{"robotis", "ROBOTIS", "OMY", Build::cobot, kDark, kWhite, kWhite, kWhite, kDark, kDark, 0.3, 0.86, 1,
        0.86, 0.08},
    Row{"robotis", "ROBOTIS", "", Build::servo, kDark, kDark, kDark, kDark, kBlack, kSlate, 0.1, 0.6, 0.25,
        0.6, 0.1},
    Row{"lynxmotion", "Lynxmotion", "", Build::servo, kBlack, kSlate, kSlate, kSlate, kBlack, kBlack, 0.1,
        0.5, 0.2, 0.6, 0.1},
    Row{"elephant", "Elephant Robotics", "", Build::cobot, kWhite, kWhite, kWhite, kWhite, kGrey,
        paint(0xC8CDD2), 0.32, 0.9, 0.9, 0.86, 0.08},
    Row{"elite", "Elite Robots", "", Build::cobot, kSlate, kPearl, kPearl, kPearl, kDark, paint(0x00A0A8),
        0.25, 0.84, 1, 0.9, 0.12},
    Row{"aubo", "AUBO", "", Build::cobot, kPearl, kPearl, kPearl, kPearl, kDark, paint(0xE07A1F), 0.26, 0.84,
        1, 0.9, 0.12},
    Row{"sawyer", "Rethink Robotics", "", Build::soft, kDark, paint(0xA3202A, 0.4f), paint(0xA3202A, 0.4f),
        paint(0x8B1B24, 0.4f), kDark, kSlate, 0.4, 0.9, 1, 0.84, 0.08},
    Row{"mecademic", "Mecademic", "", Build::cast, kAluminium, kAluminium, kAluminium, kAluminium, kBlack,
        kBlack, 0.2, 0.86, 0.6, 0.7, 0.1},
    Row{"nextage", "Kawada", "", Build::cast, kWhite, kWhite, kWhite, kWhite, kDark, paint(0x3A4C63), 0.3,
        0.86, 0.8, 0.8, 0.1},
    Row{"piper", "AgileX", "", Build::cobot, kDark, kDark, kDark, kDark, kBlack, paint(0xC62828), 0.2, 0.8,
        0.8, 0.8, 0.08},
    Row{"rizon", "Flexiv", "", Build::soft, kSlate, paint(0xD3D6D8, 0.35f, 0.2f),
        paint(0xD3D6D8, 0.35f, 0.2f), paint(0xD3D6D8, 0.35f, 0.2f), kBlack, paint(0x3A3E42), 0.38, 0.92, 1,
        0.86, 0.08},
    Row{"rainbow", "Rainbow Robotics", "", Build::cobot, kPearl, kPearl, kPearl, kPearl, paint(0x39424B),
        paint(0x50585F), 0.26, 0.85, 1, 0.9, 0.1},
    Row{"melfa_scara", "Mitsubishi Electric", "RH-", Build::scara, kWhite, kWhite, kWhite, kAluminium, kGrey,
        kWhite, 0.15, 0.8, 0.7, 0.86, 0.08},
    Row{"melfa_assista", "Mitsubishi Electric", "RV-5AS", Build::cobot, kWhite, kWhite, kWhite, kWhite, kDark,
        kSlate, 0.3, 0.88, 0.9, 0.86, 0.1},
    Row{"melfa", "Mitsubishi Electric", "", Build::cast, kWhite, kWhite, kWhite, kWhite, kSlate, kPearl, 0.22,
        0.86, 0.6, 0.8, 0.12},
    Row{"unitree", "Unitree", "", Build::cobot, kDark, kDark, kDark, kDark, kBlack, kGrey, 0.2, 0.8, 0.8, 0.8,
        0.08},
    Row{"puma", "Unimation", "", Build::cast, kDark, paint(0xE9E6DC), paint(0xE9E6DC), kAluminium, kDark,
        paint(0xE9E6DC), 0.08, 0.84, 0.5, 0.86, 0.1},
    Row{"scara", "", "", Build::scara, kWhite, kWhite, kWhite, kAluminium, kGrey, kWhite, 0.15, 0.8, 0.7,
        0.86, 0.08},
    Row{"plain", "", "", Build::cobot, kSlate, kPearl, kPearl, kPearl, kDark, paint(0x6D8BA8), 0.26, 0.86,
        0.9, 0.86, 0.1}};

bool fits(std::string_view models, std::string_view model) {
  for (std::size_t at = 0; at <= models.size();) {
    const std::size_t end = std::min(models.find('|', at), models.size());
    const std::string_view one = models.substr(at, end - at);
    if (one.ends_with('$') ? model == one.substr(0, one.size() - 1) : model.starts_with(one)) return true;
    at = end + 1;
  }
  return false;
}

/// True if all joint axes are vertical, exactly one joint is prismatic and at least two are revolute.
bool is_scara(const description::RobotModel& model) {
  int upright = 0, sliding = 0;
  for (const int j : model.actuated) {
    const description::Joint& joint = model.joints[static_cast<std::size_t>(j)];
    if (std::abs(joint.axis.z) < 0.99) return false;
    (joint.type == description::JointType::prismatic ? sliding : upright) += 1;
  }
  return sliding == 1 && upright >= 2;
}

const Row& named(std::string_view name) {
  for (const Row& row : kRows)
    if (row.name == name) return row;
  return kRows.back();
}

const Row& row_of(const description::RobotModel& model) {
  const description::Provenance& from = model.provenance;
  for (const Row& row : kRows)
    if (*row.maker && from.maker == row.maker && fits(row.models, from.model)) return row;
  return named(is_scara(model) ? "scara" : "plain");
}

Style style_from(const Row& row) {
  Style out;
  out.name = row.name;
  out.build = row.build;
  out.base = row.base;
  out.body = row.body;
  out.fore = row.fore;
  out.wrist = row.wrist;
  out.joint = row.joint;
  out.cap = row.cap;
  out.edge = row.edge;
  out.tube = row.tube;
  out.corner = row.corner;
  out.cap_size = row.cap_size;
  out.dome = row.dome;
  out.housing = row.housing;
  return out;
}

/// The paint that a key of `look` changes; null for other keys.
Paint* paint_of(Style& style, const std::string& key) {
  if (key == "base") return &style.base;
  if (key == "body") return &style.body;
  if (key == "forearm") return &style.fore;
  if (key == "wrist") return &style.wrist;
  if (key == "joints") return &style.joint;
  if (key == "covers") return &style.cap;
  if (key == "housings") return style.housing ? &*style.housing : &style.housing.emplace(style.body);
  return nullptr;
}

}  // namespace

std::optional<Paint> read_color(const std::string& text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  std::uint32_t rgb = 0;
  for (const char c : text.substr(1)) {
    const auto digit = std::string_view("0123456789abcdef").find(static_cast<char>(c | 32));
    if (digit == std::string_view::npos) return std::nullopt;
    rgb = 16 * rgb + static_cast<std::uint32_t>(digit);
  }
  return paint(rgb);
}

std::vector<std::string> style_names() {
  std::vector<std::string> out;
  for (const Row& row : kRows)
    if (std::find(out.begin(), out.end(), row.name) == out.end()) out.emplace_back(row.name);
  return out;
}

Style style_of(const description::RobotModel& model, Problems& problems) {
  const std::vector<std::string> names = style_names();
  const auto wanted = model.look.find("style");
  const bool known =
      wanted != model.look.end() && std::find(names.begin(), names.end(), wanted->second) != names.end();
  Style out = style_from(known ? named(wanted->second) : row_of(model));
  for (const auto& [key, value] : model.look) {
    const auto warn = [&, key = key](const std::string& what, const std::string& fix) {
      problems.add(
          Problem{"bad-look", {}, model.name + ": look: " + key + ": " + what, fix, Severity::warning});
    };
    if (key == description::kMeasuredLook) continue;
    if (key == "style") {
      if (!known) warn("there is no style '" + value + "'" + did_you_mean(value, names), {});
      continue;
    }
    Paint* const target = paint_of(out, key);
    const auto color = read_color(value);
    if (!target)
      warn("there is no such key", "use style, base, body, forearm, wrist, housings, joints or covers");
    else if (!color)
      warn("'" + value + "' is not a colour", "write #rrggbb");
    else
      target->color = color->color;
  }
  return out;
}

}  // namespace polyarm::shapes
