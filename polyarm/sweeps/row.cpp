#include "polyarm/sweeps/row.hpp"

#include <nlohmann/json.hpp>

#include "polyarm/base/text.hpp"
#include "polyarm/sweeps/variants.hpp"

namespace polyarm::sweeps {

namespace {
using Json = nlohmann::ordered_json;

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}
}  // namespace

const std::vector<Column>& columns() {
  static const std::vector<Column> all = {
#define POLYARM_TEXT(name, meaning) {#name, meaning, &Row::name, nullptr},
#define POLYARM_NUMBER(name, meaning) {#name, meaning, nullptr, &Row::name},
      POLYARM_SWEEP_COLUMNS(POLYARM_TEXT, POLYARM_NUMBER)
#undef POLYARM_TEXT
#undef POLYARM_NUMBER
  };
  return all;
}

Row row_of(const Variant& variant, std::string key) {
  Row out;
  out.key = std::move(key);
  out.robot = variant.robot;
  out.x_m = variant.place.x, out.y_m = variant.place.y, out.z_m = variant.place.z;
  out.yaw_rad = variant.place.yaw;
  out.program = variant.program;
  out.speed = variant.speed;
  out.fault = variant.fault->name;
  out.seed = static_cast<double>(variant.seed);
  out.given = values_text(variant);
  return out;
}

std::string to_json(const Row& row) {
  Json out = Json::object();
  for (const Column& column : columns()) {
    if (column.text)
      out[column.name] = row.*column.text;
    else
      out[column.name] = row.*column.number ? Json(*(row.*column.number)) : Json();
  }
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<Row> row_from_json(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  Row out;
  for (const Column& column : columns()) {
    const auto at = json.find(column.name);
    if (at == json.end()) return std::nullopt;
    if (column.text && at->is_string()) out.*column.text = at->get<std::string>();
    if (column.number && at->is_number()) out.*column.number = at->get<double>();
  }
  return out;
}

std::string csv_head() {
  std::vector<std::string> out;
  for (const Column& column : columns()) out.push_back(column.name);
  return join(out, ",");
}

std::string csv_line(const Row& row) {
  std::vector<std::string> out;
  for (const Column& column : columns()) {
    if (column.text)
      out.push_back(csv_field(row.*column.text));
    else
      out.push_back(row.*column.number ? format_number(*(row.*column.number)) : std::string());
  }
  return join(out, ",");
}

std::string reference() {
  std::string out = "| column | meaning |\n|---|---|\n";
  for (const Column& column : columns()) out += "| `" + column.name + "` | " + column.meaning + " |\n";
  return out;
}

}  // namespace polyarm::sweeps
