#pragma once
/// Messages as YAML text, in the form of ROS 2, and what generic code asks of their types. For messages that
/// `polyarm plugin` made from their files. Text is for logs: it allocates. A `byte` is a decimal number here.
#include <array>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

namespace rosidl_generator_traits {

template <typename T, typename = void>
struct is_message : std::false_type {};
template <typename T>
struct is_message<T, std::void_t<decltype(T::polyarm_names())>> : std::true_type {};
template <typename T, typename = void>
struct is_service : std::false_type {};
template <typename T>
struct is_service<T, std::void_t<typename T::Request, typename T::Response>> : std::true_type {};
template <typename T, typename = void>
struct is_action : std::false_type {};
template <typename T>
struct is_action<T, std::void_t<typename T::Goal, typename T::Result, typename T::Feedback>>
    : std::true_type {};

/// "std_msgs/msg/Header"
template <typename T>
constexpr const char* name() {
  return T::polyarm_type();
}
/// "std_msgs::msg::Header"
template <typename T>
const char* data_type() {
  static const std::string text = [] {
    std::string out;
    for (const char* c = T::polyarm_type(); *c; ++c)
      if (*c == '/')
        out += "::";
      else
        out += *c;
    return out;
  }();
  return text.c_str();
}

inline void value_to_yaml(bool value, std::ostream& out) {
  out << (value ? "true" : "false");
}
template <typename T, std::enable_if_t<std::is_arithmetic_v<T> && !std::is_same_v<T, bool>, int> = 0>
void value_to_yaml(T value, std::ostream& out) {
  const auto flags = out.flags();
  out << std::showpoint << +value;  // a number, also of one byte
  out.flags(flags);
}
inline void value_to_yaml(const std::string& text, std::ostream& out) {
  out << '"';
  for (const char c : text) {
    if (c == '"' || c == '\\') out << '\\';
    out << c;
  }
  out << '"';
}
inline void value_to_yaml(const std::u16string& text, std::ostream& out) {
  const char* digits = "0123456789abcdef";
  out << '"';
  for (const char16_t c : text) {
    if (c < 0x80)
      out << static_cast<char>(c);
    else if (c < 0x100)
      out << "\\x" << digits[c >> 4] << digits[c & 15];
    else
      out << "\\u" << digits[c >> 12] << digits[c >> 8 & 15] << digits[c >> 4 & 15] << digits[c & 15];
  }
  out << '"';
}

template <typename T>
std::enable_if_t<is_message<T>::value> to_flow_style_yaml(const T& message, std::ostream& out);
template <typename T>
std::enable_if_t<is_message<T>::value> to_block_style_yaml(const T& message, std::ostream& out,
                                                           std::size_t indentation = 0);

/// Gets the fields of a message in their order, and writes each with its name.
class YamlFields {
 public:
  YamlFields(const char* names, std::ostream& out, std::size_t indentation, bool flow)
      : names_(names), out_(out), indentation_(indentation, ' '), flow_(flow) {}

  template <typename T>
  void operator()(const T& value) {
    if (flow_) return one_of_flow(value);
    out_ << indentation_;
    name();
    if constexpr (is_message<T>::value) {
      out_ << ":\n";
      to_block_style_yaml(value, out_, indentation_.size() + 2);
    } else {
      out_ << ": ";
      value_to_yaml(value, out_);
      out_ << '\n';
    }
  }
  template <typename T>
  void operator()(const std::vector<T>& values) {
    list<T>(values);
  }
  template <typename T, std::size_t kSize>
  void operator()(const std::array<T, kSize>& values) {
    list<T>(values);
  }

 private:
  void name() {
    while (*names_ && *names_ != ' ') out_ << *names_++;
    if (*names_) ++names_;
  }
  template <typename T>
  void one_of_flow(const T& value) {
    name();
    out_ << ": ";
    flow(value);
    if (*names_) out_ << ", ";
  }
  template <typename T>
  void flow(const T& value) {
    if constexpr (is_message<T>::value)
      to_flow_style_yaml(value, out_);
    else
      value_to_yaml(value, out_);
  }
  template <typename T, typename List>
  void list(const List& values) {
    if (flow_) return list_of_flow<T>(values);
    out_ << indentation_;
    name();
    out_ << (values.empty() ? ": []\n" : ":\n");
    for (const T& value : values) {
      out_ << indentation_ << "-";
      if constexpr (is_message<T>::value) {
        out_ << '\n';
        to_block_style_yaml(value, out_, indentation_.size() + 2);
      } else {
        out_ << ' ';
        value_to_yaml(value, out_);
        out_ << '\n';
      }
    }
  }
  template <typename T, typename List>
  void list_of_flow(const List& values) {
    name();
    out_ << ": [";
    const char* between = "";
    for (const T& value : values) {
      out_ << between;
      flow(value);
      between = ", ";
    }
    out_ << ']';
    if (*names_) out_ << ", ";
  }

  const char* names_;
  std::ostream& out_;
  std::string indentation_;
  bool flow_;
};

template <typename T>
std::enable_if_t<is_message<T>::value> to_flow_style_yaml(const T& message, std::ostream& out) {
  if (*T::polyarm_names() == 0) {
    out << "null";
    return;
  }
  out << '{';
  YamlFields fields(T::polyarm_names(), out, 0, true);
  message.polyarm_fields(fields);
  out << '}';
}
template <typename T>
std::enable_if_t<is_message<T>::value> to_block_style_yaml(const T& message, std::ostream& out,
                                                           std::size_t indentation) {
  if (*T::polyarm_names() == 0) {
    out << "null\n";
    return;
  }
  YamlFields fields(T::polyarm_names(), out, indentation, false);
  message.polyarm_fields(fields);
}
template <typename T>
std::enable_if_t<is_message<T>::value, std::string> to_yaml(const T& message, bool use_flow_style = false) {
  std::ostringstream out;
  if (use_flow_style)
    to_flow_style_yaml(message, out);
  else
    to_block_style_yaml(message, out);
  return out.str();
}

}  // namespace rosidl_generator_traits
