#pragma once
/// Counts what an expansion of xacro costs, whatever it spends it on: expressions, lists, texts, macros, includes and
/// blocks. A unit takes some 20 ns. Without a common bound, a file of a kilobyte can multiply many small bounded
/// costs. Private to the room.
#include <cstddef>
#include <string_view>

namespace polyarm::description {

/// Work of this thread from here to the end of the scope. Within another one it continues that one's count.
class XacroWork {
 public:
  XacroWork();
  ~XacroWork();
  XacroWork(const XacroWork&) = delete;
  XacroWork& operator=(const XacroWork&) = delete;

 private:
  bool outermost_;
};

/// Adds to the count. Throws Error("bad-expression") without a place beyond bounds::kXacroWork.
void spend(std::size_t units);
/// Looking for a piece in a text, at worst.
inline void spend_on_search(std::string_view text, std::string_view piece) {
  spend(1 + text.size() / 16 + text.size() / 16 * (piece.size() / 16));
}

}  // namespace polyarm::description
