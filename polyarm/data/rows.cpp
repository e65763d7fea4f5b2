#include "polyarm/data/rows.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/literal.hpp"

namespace polyarm::data {

namespace {
using Fields = std::vector<std::string>;

class RowReader {
 public:
  RowReader(std::string_view text, const std::string& file) : text_(text), file_(file) {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
  }

  List read() {
    if (text_.size() > kMostRowBytes) refuse("the file has more than 1 MiB", "divide it into several files");
    while (!text_.empty()) line();
    if (rows_.empty()) return {};
    const bool named = names_columns(rows_.front());
    List out;
    for (std::size_t i = named ? 1 : 0; i < rows_.size(); ++i) out.push_back(row(rows_[i], named));
    return out;
  }

 private:
  [[noreturn]] void refuse(const std::string& what, const std::string& advice) const {
    throw Error(Problem{"bad-value", {file_, line_}, what, advice});
  }

  void line() {
    ++line_;
    const std::size_t end = std::min(text_.find('\n'), text_.size());
    const std::string_view start = trim(text_.substr(0, end));
    if (start.empty() || start.front() == '#') {
      text_.remove_prefix(std::min(end + 1, text_.size()));
      return;
    }
    if (separator_ == 0)
      for (const char c : {';', '\t', ','})
        if (separator_ == 0 && start.find(c) != std::string_view::npos) separator_ = c;
    if (separator_ == 0) separator_ = ',';
    Fields fields = take_fields();
    if (fields.size() > kMostColumns) refuse("this line has more than 64 columns", "leave some of them out");
    if (!rows_.empty() && fields.size() != rows_.front().size())
      refuse("this line has " + std::to_string(fields.size()) + " columns, the first one has " +
                 std::to_string(rows_.front().size()),
             "give every line the same columns; quote a text that contains the separator");
    if (rows_.size() > kMostRows) refuse("the file has more than 10000 rows", "divide it into several files");
    rows_.push_back(std::move(fields));
  }

  /// The fields of a line; a quoted field may contain line breaks.
  Fields take_fields() {
    Fields out(1);
    bool quoted = false;
    const int first = line_;
    std::size_t i = 0;
    for (; i < text_.size(); ++i) {
      const char c = text_[i];
      if (quoted && c == '"' && i + 1 < text_.size() && text_[i + 1] == '"')
        out.back() += text_[++i];
      else if (c == '"')
        quoted = !quoted;
      else if (!quoted && c == separator_)
        out.emplace_back();
      else if (!quoted && c == '\n')
        break;
      else if (quoted || c != '\r')
        out.back() += c;
      line_ += quoted && c == '\n';
      if (out.size() > kMostColumns) break;
    }
    if (quoted) {
      line_ = first;
      refuse("a quoted text that begins in this line has no end",
             "write \" at its end, and \"\" for a quote in it");
    }
    text_.remove_prefix(std::min(i + 1, text_.size()));
    for (std::string& field : out) field = std::string(trim(field));
    return out;
  }

  static Value value(const std::string& field) {
    if (const auto number = parse_number(field); number && std::isfinite(*number)) return *number;
    const std::string word = lower(field);
    if (word == "true" || word == "false") return word == "true";
    const char c = field.empty() ? ' ' : field.front();
    if ((c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.') {
      std::string why;
      const auto read = parse_literal(field, why);
      if (read && read->as_number()) return *read;
    }
    return field;
  }

  static bool names_columns(const Fields& first) {
    std::set<std::string> names;
    return std::all_of(first.begin(), first.end(), [&](const std::string& field) {
      return !field.empty() && value(field).as_text() && names.insert(field).second;
    });
  }

  Value row(const Fields& fields, bool named) const {
    List values;
    for (const std::string& field : fields) values.push_back(value(field));
    if (!named) return values;
    return Record{rows_.front(), std::move(values)};
  }

  std::string_view text_;
  const std::string& file_;
  std::vector<Fields> rows_;
  char separator_ = 0;
  int line_ = 0;
};
}  // namespace

List read_rows(std::string_view text, const std::string& file) {
  return RowReader(text, file).read();
}

}  // namespace polyarm::data
