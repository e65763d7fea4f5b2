#include "polyarm/base/error.hpp"

#include <algorithm>
#include <filesystem>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"

namespace polyarm {

namespace {
/// Of one exception, in what().
constexpr std::size_t kMostTexts = bounds::kProblemsInText;

std::string all_texts(const std::vector<Problem>& problems) {
  std::string out;
  for (std::size_t i = 0; i < std::min(problems.size(), kMostTexts); ++i)
    out += (out.empty() ? "" : "\n") + problems[i].text();
  if (problems.size() > kMostTexts)
    out += "\nand " + std::to_string(problems.size() - kMostTexts) + " more problems";
  return out;
}
}  // namespace

std::string Location::text() const {
  std::string out = file;
  if (line > 0) out += ":" + std::to_string(line);
  if (line > 0 && column > 0) out += ":" + std::to_string(column);
  return out;
}

namespace {
/// As a part of one line: a file may put a line feed into a name. What else steers a terminal is shown where
/// it is printed on one.
std::string on_one_line(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\n')
      out += "\\x0a";
    else if (c == '\r')
      out += "\\x0d";
    else
      out += c;
  }
  return out;
}

/// A file may put megabytes into a name.
std::string bounded(std::string_view text) {
  if (text.size() <= bounds::kErrorTextBytes) return on_one_line(text);
  return on_one_line(text.substr(0, whole_characters(text.substr(0, bounds::kErrorTextBytes)))) + "…";
}
}  // namespace

std::string Problem::text() const {
  const std::string place = where.text();
  std::string out = place.empty() ? "" : on_one_line(place) + ": ";
  out += severity == Severity::error ? "error: " : "warning: ";
  out += bounded(what);
  if (!advice.empty()) out += " (" + bounded(advice) + ")";
  return out;
}

Error::Error(std::vector<Problem> problems)
    : std::runtime_error(all_texts(problems)), problems_(std::move(problems)) {}

std::string what_was_thrown() {
  try {
    throw;
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "something that is not a std::exception";
  }
}

Error error_thrown() {
  try {
    throw;
  } catch (const Error& e) {
    return e;
  } catch (const std::filesystem::filesystem_error& e) {
    return Error(Problem{"unwritable",
                         {printable_line(e.path1().string())},
                         "cannot be created, changed or read: " + e.code().message(),
                         "check what its name and the folders in it are, and their permissions"});
  } catch (...) {
    return Error("internal", "unexpected: " + what_was_thrown());
  }
}

void rethrow_as_error(std::string code, const std::string& who, std::string advice) {
  try {
    throw;
  } catch (const Error&) {
    throw;
  } catch (...) {
    throw Error(std::move(code), who + " threw: " + what_was_thrown(), std::move(advice));
  }
}

bool Problems::has_errors() const {
  return std::any_of(list_.begin(), list_.end(),
                     [](const Problem& p) { return p.severity == Severity::error; });
}

void Problems::throw_if_errors() const {
  if (has_errors()) throw Error(list_);
}

}  // namespace polyarm
