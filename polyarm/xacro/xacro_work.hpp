#pragma once
/// Counts the work of an xacro expansion: expressions, lists, texts, macros, includes and blocks. One unit
/// takes about 20 ns. A common limit is needed because a file of one kilobyte can multiply many costs that
/// are small and limited by themselves. Private to the room.
#include <cstddef>
#include <string_view>

namespace polyarm::description {

/// Counts the work of this thread until the end of the scope. Inside another XacroWork it continues that
/// count.
class XacroWork {
 public:
  XacroWork();
  ~XacroWork();
  XacroWork(const XacroWork&) = delete;
  XacroWork& operator=(const XacroWork&) = delete;

 private:
  bool outermost_;
};

/// Adds units to the count. Throws Error("bad-expression") without a place above bounds::kXacroWork.
void spend(std::size_t units);
/// Adds the worst-case cost of searching for a piece in a text.
inline void spend_on_search(std::string_view text, std::string_view piece) {
  spend(1 + text.size() / 16 + text.size() / 16 * (piece.size() / 16));
}

}  // namespace polyarm::description
