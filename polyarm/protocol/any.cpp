#include "polyarm/protocol/any.hpp"

#include <nlohmann/json.hpp>

namespace polyarm::protocol {

using Json = nlohmann::json;

Any::Any(Json value) {
  if (!value.is_null()) value_ = std::make_shared<const Json>(std::move(value));
}
Any::Any(bool flag) : Any(Json(flag)) {}
Any::Any(int number) : Any(Json(number)) {}
Any::Any(double number) : Any(Json(number)) {}
Any::Any(const char* text) : Any(Json(text)) {}
Any::Any(std::string text) : Any(Json(std::move(text))) {}

std::optional<Any> Any::parse(const std::string& text) {
  Json value = Json::parse(text, nullptr, false);
  if (value.is_discarded()) return std::nullopt;
  return Any(std::move(value));
}

const Json& Any::json() const {
  static const Json null;
  return value_ ? *value_ : null;
}

std::optional<bool> Any::flag() const {
  return json().is_boolean() ? std::optional(json().get<bool>()) : std::nullopt;
}
std::optional<double> Any::number() const {
  return json().is_number() ? std::optional(json().get<double>()) : std::nullopt;
}
std::optional<std::string> Any::text() const {
  return json().is_string() ? std::optional(json().get<std::string>()) : std::nullopt;
}

std::string Any::dump() const {
  return json().dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool Any::operator==(const Any& other) const {
  return json() == other.json();
}

}  // namespace polyarm::protocol
