#include "apps/journal.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cstdlib>

namespace polyarm::apps {

bool leads_to_journal(int descriptor) {
  const char* named = std::getenv("JOURNAL_STREAM");
  struct stat here {};
  return named && ::fstat(descriptor, &here) == 0 && named == fmt::format("{}:{}", here.st_dev, here.st_ino);
}

std::string for_journal(std::string_view text, Priority priority) {
  const std::string mark = fmt::format("<{}>", static_cast<int>(priority));
  std::string out;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end == std::string_view::npos ? end : end + 1);
    out += mark;
    out += line;
    text.remove_prefix(line.size());
  }
  return out;
}

}  // namespace polyarm::apps
