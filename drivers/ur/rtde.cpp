#include "drivers/ur/rtde.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace polyarm::ur {

namespace {

constexpr FieldType kTypes[] = {
    {"BOOL", 1, 1, FieldType::boolean},
    {"UINT8", 1, 1, FieldType::unsigned_number},
    {"UINT32", 1, 4, FieldType::unsigned_number},
    {"UINT64", 1, 8, FieldType::unsigned_number},
    {"INT32", 1, 4, FieldType::signed_number},
    {"DOUBLE", 1, 8, FieldType::real},
    {"VECTOR3D", 3, 8, FieldType::real},
    {"VECTOR6D", 6, 8, FieldType::real},
    {"VECTOR6INT32", 6, 4, FieldType::signed_number},
    {"VECTOR6UINT32", 6, 4, FieldType::unsigned_number},
};

/// One type, and the variables that have it.
struct Row {
  const char* type;
  const char* names;
};
constexpr Row kOutputs[] = {
    {"VECTOR6D",
     "target_q target_qd target_qdd target_current target_moment actual_q actual_qd actual_current "
     "actual_current_window actual_current_as_torque joint_control_output actual_TCP_pose actual_TCP_speed "
     "actual_TCP_force target_TCP_pose target_TCP_speed tcp_offset actual_TCP_acceleration "
     "target_TCP_acceleration "
     "joint_temperatures actual_joint_voltage ft_raw_wrench wrench_calc_from_currents payload_inertia "
     "target_base_acceleration target_base_wrench"},
    {"VECTOR6INT32", "joint_mode"},
    {"VECTOR3D", "actual_tool_accelerometer elbow_position elbow_velocity payload_cog target_gravity"},
    {"UINT64",
     "actual_digital_input_bits actual_configurable_digital_input_bits actual_digital_output_bits "
     "actual_configurable_digital_output_bits control_step"},
    {"DOUBLE",
     "timestamp actual_execution_time target_execution_time speed_scaling target_speed_fraction "
     "actual_momentum "
     "actual_main_voltage actual_robot_voltage actual_robot_current io_current standard_analog_input0 "
     "standard_analog_input1 standard_analog_output0 standard_analog_output1 tool_analog_input0 "
     "tool_analog_input1 "
     "tool_output_current tool_temperature tcp_force_scalar joint_position_deviation_ratio "
     "collision_detection_ratio payload actual_robot_energy_consumed actual_robot_braking_energy_dissipated "
     "euromap67_24V_voltage euromap67_24V_current"},
    {"INT32",
     "robot_mode safety_mode safety_status tool_output_voltage time_scale_source encoder0_raw encoder1_raw"},
    {"UINT32",
     "runtime_state robot_status_bits safety_status_bits analog_io_types tool_mode tool_analog_input_types "
     "script_control_line output_bit_registers0_to_31 output_bit_registers32_to_63 "
     "input_bit_registers0_to_31 "
     "input_bit_registers32_to_63 euromap67_input_bits euromap67_output_bits"},
    {"UINT8", "tool_output_mode tool_digital_output0_mode tool_digital_output1_mode"},
};
constexpr Row kInputs[] = {
    {"UINT32", "speed_slider_mask input_bit_registers0_to_31 input_bit_registers32_to_63"},
    {"DOUBLE", "speed_slider_fraction standard_analog_output_0 standard_analog_output_1"},
    {"UINT8",
     "standard_digital_output_mask standard_digital_output configurable_digital_output_mask "
     "configurable_digital_output tool_digital_output_mask tool_digital_output standard_analog_output_mask "
     "standard_analog_output_type"},
    {"VECTOR6D", "external_force_torque"},
};

using Table = std::map<std::string, const FieldType*, std::less<>>;
Table table_of(std::span<const Row> rows) {
  Table out;
  for (const Row& row : rows) {
    std::string_view names = row.names;
    while (!names.empty()) {
      const std::size_t end = std::min(names.find(' '), names.size());
      out.emplace(std::string(names.substr(0, end)), find_type(row.type));
      names.remove_prefix(std::min(end + 1, names.size()));
    }
  }
  return out;
}

/// A register such as "input_int_register_24"; null for another name.
const FieldType* find_register(std::string_view name, std::string_view side) noexcept {
  struct Family {
    std::string_view name, type;
    int first, last;
  };
  constexpr Family kFamilies[] = {{"bit_register_", "BOOL", 64, 127},
                                  {"int_register_", "INT32", 0, 47},
                                  {"double_register_", "DOUBLE", 0, 47}};
  if (!name.starts_with(side)) return nullptr;
  name.remove_prefix(side.size());
  for (const Family& family : kFamilies) {
    if (!name.starts_with(family.name)) continue;
    const std::string_view digits = name.substr(family.name.size());
    int number = 0;
    if (digits.empty() || digits.size() > 3) return nullptr;
    for (const char c : digits) {
      if (c < '0' || c > '9') return nullptr;
      number = number * 10 + (c - '0');
    }
    const bool plain = digits.size() == 1 || digits.front() != '0';
    return plain && number >= family.first && number <= family.last ? find_type(family.type) : nullptr;
  }
  return nullptr;
}

const Table& outputs() {
  static const Table table = table_of(kOutputs);
  return table;
}
const Table& inputs() {
  static const Table table = table_of(kInputs);
  return table;
}

double limited(double value, double least, double most) {
  return std::isnan(value) ? 0 : std::clamp(std::round(value), least, most);
}

void encode(const FieldType& type, double value, wire::Writer& out) {
  if (type.kind == FieldType::real)
    out.f64(value);
  else if (type.kind == FieldType::boolean)
    out.u8(value != 0);
  else if (type.kind == FieldType::signed_number)
    out.i32(static_cast<std::int32_t>(limited(value, -2147483648.0, 2147483647.0)));
  else if (type.width == 8)
    out.u64(static_cast<std::uint64_t>(limited(value, 0, 9007199254740992.0)));
  else if (type.width == 4)
    out.u32(static_cast<std::uint64_t>(limited(value, 0, 4294967295.0)));
  else
    out.u8(static_cast<std::uint64_t>(limited(value, 0, 255)));
}

}  // namespace

const FieldType* find_type(std::string_view name) noexcept {
  for (const FieldType& type : kTypes)
    if (type.name == name) return &type;
  return nullptr;
}

const FieldType* find_output(std::string_view name) noexcept {
  const auto found = outputs().find(name);
  if (found != outputs().end()) return found->second;
  // Inputs can be read back, too.
  if (const FieldType* type = find_register(name, "output_")) return type;
  return find_register(name, "input_");
}

const FieldType* find_input(std::string_view name) noexcept {
  const auto found = inputs().find(name);
  return found != inputs().end() ? found->second : find_register(name, "input_");
}

std::vector<std::string> output_names() {
  std::vector<std::string> out;
  for (const auto& [name, type] : outputs()) out.push_back(name);
  return out;
}

bool decode(const Recipe& recipe, Bytes values, std::span<double> out) noexcept {
  if (values.size() != recipe.bytes || out.size() != recipe.elements) return false;
  wire::Reader in(values);
  std::size_t at = 0;
  for (const FieldType* type : recipe.types)
    for (std::size_t i = 0; i < type->elements; ++i) {
      if (type->kind == FieldType::real)
        out[at++] = in.f64();
      else if (type->kind == FieldType::signed_number)
        out[at++] = in.i32();
      else
        out[at++] = static_cast<double>(type->width == 8 ? in.u64() : type->width == 4 ? in.u32() : in.u8());
    }
  return in.ok();
}

void encode(const Recipe& recipe, std::span<const double> values, wire::Writer& out) {
  std::size_t at = 0;
  for (const FieldType* type : recipe.types)
    for (std::size_t i = 0; i < type->elements; ++i, ++at)
      encode(*type, at < values.size() ? values[at] : 0, out);
}

std::vector<std::uint8_t> frame(PackageType type, Bytes payload) {
  wire::Writer out;
  out.u16(payload.size() + kHeader).u8(static_cast<std::uint8_t>(type)).append(payload);
  return out.bytes();
}

std::vector<std::string> split_names(std::string_view text) {
  std::vector<std::string> out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    out.emplace_back(text.substr(0, end));
    if (out.size() > bounds::kRtdeNames) return {};
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

std::optional<RtdeText> read_text(Bytes payload, int protocol) {
  wire::Reader in(payload);
  RtdeText out;
  if (protocol < 2) {
    out.level = in.u8();
    out.text = in.text(in.left());
  } else {
    out.text = in.text(in.u8());
    out.source = in.text(in.u8());
    out.level = in.u8();
  }
  return in.ok() ? std::optional(out) : std::nullopt;
}

}  // namespace polyarm::ur
