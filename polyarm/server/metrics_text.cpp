#include "polyarm/server/metrics_text.hpp"

#include <cmath>

#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::server {

std::string label_text(std::string_view value) {
  std::string out;
  for (const char c : printable_line(std::string(value.substr(0, 200)))) {
    if (c == '\\' || c == '"') out += '\\';
    out += c;
  }
  return out;
}

void MetricsText::family(std::string name, const char* type, const char* help) {
  name_ = std::move(name);
  text_ += "# HELP " + name_ + " " + help + "\n# TYPE " + name_ + " " + type + "\n";
}

void MetricsText::sample(double value, const Labels& labels) {
  text_ += name_;
  for (std::size_t i = 0; i < labels.size(); ++i)
    text_ += (i == 0 ? "{" : ",") + labels[i].first + "=\"" + label_text(labels[i].second) + "\"";
  if (!labels.empty()) text_ += "}";
  text_ += " " +
           (std::isnan(value)   ? "NaN"
            : std::isinf(value) ? (value > 0 ? "+Inf" : "-Inf")
                                : format_number(value)) +
           "\n";
}

}  // namespace polyarm::server
