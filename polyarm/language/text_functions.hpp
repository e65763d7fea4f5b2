#pragma once
/// Functions of texts and lists, and the fields of format(). Part of the list in functions.hpp. Any thread.
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/language/functions.hpp"

namespace polyarm::program {

/// One field `{}` or `{:SPEC}` of the text of format(). SPEC is [<|>|^][0][WIDTH][.DIGITS][f|e][UNIT].
struct FormatField {
  std::size_t begin = 0, end = 0;  ///< of the field in the text
  char align = 0;                  ///< < > ^; 0: numbers to the right, others to the left
  bool zeros = false;              ///< fills with zeros in front of the digits
  int width = 0;
  int digits = -1;                ///< -1: as many as needed
  char style = 0;                 ///< f or e; 0: not said
  std::string_view unit;          ///< of a number; empty: its SI unit
  bool of_number() const { return zeros || digits >= 0 || style != 0 || !unit.empty(); }
};
/// The fields in `text`. Throws OperationError with the faulty field. The units refer to `text`.
std::vector<FormatField> format_fields(std::string_view text);
/// What is wrong if a format has not one value for each field.
std::string wrong_values(std::size_t fields, std::size_t values);

/// The text of a value as a program shows it: numbers have at most nine significant digits.
std::string shown_text(const Value& value);

/// length, format, number, text, split, join, …
void add_text_functions(std::vector<Function>& out);

}  // namespace polyarm::program
