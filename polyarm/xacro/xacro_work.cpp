#include "polyarm/xacro/xacro_work.hpp"

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::description {

namespace {
thread_local bool counting = false;
thread_local std::size_t spent = 0;
}  // namespace

XacroWork::XacroWork() : outermost_(!counting) {
  if (!outermost_) return;
  counting = true;
  spent = 0;
}

XacroWork::~XacroWork() {
  if (outermost_) counting = false;
}

void spend(std::size_t units) {
  if (!counting) return;
  if (units <= bounds::kXacroWork && (spent += units) <= bounds::kXacroWork) return;
  spent = bounds::kXacroWork;
  throw Error("bad-expression", "the expansion takes too long",
              "look for macros or includes that multiply each other, or loops over very long lists");
}

}  // namespace polyarm::description
