#include "apps/terminal.hpp"

#include <stdio.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <span>

#include "polyarm/base/printable.hpp"

namespace polyarm::apps {

namespace {

constexpr char kEscape = '\x1b';

/// Empty if no stream is guarded.
std::string& mark() {
  static std::string text;
  return text;
}

std::string new_mark() {
  std::uint8_t bytes[16] = {};
  if (::getrandom(bytes, sizeof bytes, 0) != static_cast<ssize_t>(sizeof bytes)) return "-";
  std::string out;
  for (const std::uint8_t byte : bytes) {
    out += "0123456789abcdef"[byte >> 4];
    out += "0123456789abcdef"[byte & 15];
  }
  return out;
}

struct Guarded {
  int descriptor;
  TerminalText text;
};

ssize_t write_guarded(void* cookie, const char* data, std::size_t size) {
  auto& to = *static_cast<Guarded*>(cookie);
  const std::string out = to.text.pass({data, size});
  for (std::size_t done = 0; done < out.size();) {
    const ssize_t count = ::write(to.descriptor, out.data() + done, out.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return 0;  // like stdio after a failed write
    done += static_cast<std::size_t>(count);
  }
  return static_cast<ssize_t>(size);
}

void guard(FILE*& stream, int descriptor, int buffering) {
  if (mark().empty()) mark() = new_mark();
  auto* cookie = new Guarded{descriptor, TerminalText(mark())};  // lives until the process ends
  FILE* guarded = ::fopencookie(cookie, "w", {nullptr, write_guarded, nullptr, nullptr});
  if (!guarded) return;
  ::setvbuf(guarded, nullptr, buffering, BUFSIZ);
  ::fflush(stream);
  stream = guarded;
}

}  // namespace

void guard_terminal(bool document) {
  const bool terminal = ::isatty(STDOUT_FILENO) != 0;
  if (terminal || !document) guard(stdout, STDOUT_FILENO, terminal ? _IOLBF : _IOFBF);
  guard(stderr, STDERR_FILENO, _IONBF);
}

bool asks_for_document(int argc, char** argv) {
  const std::span<char*> words(argv, static_cast<std::size_t>(argc));
  constexpr std::string_view kVerbs[] = {"xacro", "fmt", "completion", "language"};
  constexpr std::string_view kWords[] = {"--json", "--urdf", "export"};
  const auto is_one_of = [](std::string_view word, std::span<const std::string_view> list) {
    return std::find(list.begin(), list.end(), word) != list.end();
  };
  if (argc > 1 && is_one_of(words[1], kVerbs)) return true;
  return std::any_of(words.begin() + (argc > 0), words.end(), [&](const char* word) { return is_one_of(word, kWords); });
}

std::string own_escape(std::string_view sequence) {
  return kEscape + mark() + std::string(sequence);
}

std::string own_return() {
  return mark().empty() ? "\r" : kEscape + mark() + "\r";
}

std::string TerminalText::pass(std::string_view piece) {
  std::string text = std::exchange(kept_, {}) + std::string(piece), out;
  const std::string own = kEscape + mark_;
  std::size_t from = 0;
  for (std::size_t at; (at = text.find(kEscape, from)) != std::string::npos;) {
    if (at + own.size() >= text.size() && own.starts_with(text.substr(at, own.size()))) {
      // The text ends inside the mark, or directly after it.
      out += printable(std::string_view(text).substr(from, at - from));
      kept_ = text.substr(at);
      return out;
    }
    const bool ours = std::string_view(text).substr(at).starts_with(own);
    out += printable(std::string_view(text).substr(from, at - from + (ours ? 0 : 1)));
    from = at + 1;
    if (!ours) continue;
    from = at + own.size();
    if (text[from] == '\r')
      out += text[from++];
    else
      out += kEscape;
  }
  const std::string_view rest = std::string_view(text).substr(from);
  const std::size_t whole = whole_characters(rest);
  out += printable(rest.substr(0, whole));
  kept_ = rest.substr(whole);
  return out;
}

}  // namespace polyarm::apps
