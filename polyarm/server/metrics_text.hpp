#pragma once
/// Writes metrics in the text format of Prometheus, version 0.0.4. Pure.
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace polyarm::server {

class MetricsText {
 public:
  static constexpr const char* kMediaType = "text/plain; version=0.0.4; charset=utf-8";
  using Labels = std::vector<std::pair<std::string, std::string>>;

  /// Begins a family; its samples follow. `type`: gauge or counter.
  void family(std::string name, const char* type, const char* help);
  /// A sample of the last family. Labels may have any text; bytes that are not UTF-8 are replaced.
  void sample(double value, const Labels& labels = {});
  /// A family with one sample.
  void single(std::string name, const char* type, const char* help, double value) {
    family(std::move(name), type, help);
    sample(value);
  }
  const std::string& text() const { return text_; }

 private:
  std::string name_, text_;
};

/// A label's value: \, " and line ends escaped.
std::string label_text(std::string_view value);

}  // namespace polyarm::server
