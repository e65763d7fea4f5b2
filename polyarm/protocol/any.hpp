#pragma once
/// A value of free form: a ROS message, the value of a tag, the `id` of a request.
#include <cstddef>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace polyarm::protocol {

/// One JSON value. Immutable; copies share it. Any thread.
class Any {
 public:
  Any() = default;  ///< null
  Any(bool flag);
  Any(int number);
  Any(double number);
  Any(const char* text);
  Any(std::string text);
  Any(nlohmann::json value);
  /// Nothing where the text is no JSON.
  static std::optional<Any> parse(const std::string& text);

  bool is_null() const { return !value_; }
  std::optional<bool> flag() const;
  std::optional<double> number() const;
  std::optional<std::string> text() const;
  /// As JSON without line ends; bytes that are no UTF-8 become U+FFFD, NaN and infinity become null.
  std::string dump() const;
  /// For those who read its inside.
  const nlohmann::json& json() const;
  bool operator==(const Any& other) const;

 private:
  std::shared_ptr<const nlohmann::json> value_;
};

/// The keys of a JSON object and their values.
using Map = std::map<std::string, Any>;

}  // namespace polyarm::protocol
