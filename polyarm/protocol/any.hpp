#pragma once
/// A JSON value without a fixed type: a ROS message, the value of a tag, the `id` of a request.
#include <cstddef>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace polyarm::protocol {

/// One JSON value. Immutable; copies share the data. Any thread.
class Any {
 public:
  Any() = default;  ///< null
  Any(bool flag);
  Any(int number);
  Any(double number);
  Any(const char* text);
  Any(std::string text);
  Any(nlohmann::json value);
  /// Nothing if the text is not JSON.
  static std::optional<Any> parse(const std::string& text);

  bool is_null() const { return !value_; }
  std::optional<bool> flag() const;
  std::optional<double> number() const;
  std::optional<std::string> text() const;
  /// As JSON on one line. Bytes that are not UTF-8 become U+FFFD; NaN and infinity become null.
  std::string dump() const;
  /// For code that reads the content.
  const nlohmann::json& json() const;
  bool operator==(const Any& other) const;

 private:
  std::shared_ptr<const nlohmann::json> value_;
};

/// The keys of a JSON object and their values.
using Map = std::map<std::string, Any>;

}  // namespace polyarm::protocol
