#pragma once
#include <cstdarg>
#include <cstdio>
#include <sstream>
#include <string>

#include "diagnostic_msgs/msg/diagnostic_status.hpp"

namespace diagnostic_updater {

/// A status that is filled step by step.
class DiagnosticStatusWrapper : public diagnostic_msgs::msg::DiagnosticStatus {
 public:
  void summary(unsigned char of_level, const std::string& text) { level = of_level, message = text; }
  void summaryf(unsigned char of_level, const char* format, ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    summary(of_level, text);
  }
  void mergeSummary(unsigned char of_level, const std::string& text) {
    if ((of_level > 0) != (level > 0)) {
      if (of_level > level) message = text;
    } else {
      message += message.empty() ? text : "; " + text;
    }
    if (of_level > level) level = of_level;
  }
  void clearSummary() { summary(0, ""); }
  template <class T>
  void add(const std::string& key, const T& value) {
    std::ostringstream text;
    text << value;
    values.emplace_back();
    values.back().key = key;
    values.back().value = text.str();
  }
  void add(const std::string& key, bool value) { add(key, std::string(value ? "True" : "False")); }
  void addf(const std::string& key, const char* format, ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    add(key, std::string(text));
  }
  void clear() { values.clear(); }
};

}  // namespace diagnostic_updater
