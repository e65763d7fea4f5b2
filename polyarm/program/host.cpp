#include "polyarm/program/host.hpp"

namespace polyarm::program {

namespace {
[[noreturn]] void refuse(const Location& where, const std::string& what) {
  throw Error(Problem{"not-yet", where, what, {}});
}
}  // namespace

void Host::end_move(Handle, const Location& where) {
  refuse(where, "this cell cannot end a move on its way");
}

Travel Host::travel(Handle) const {
  refuse({}, "this cell does not tell how far a move has come");
}

data::Value Host::here(const std::string&, const std::string&, const std::string&) const {
  refuse({}, "this cell does not tell where its robot is");
}

void Host::hold(const std::string&, const Location& where) {
  refuse(where, "this cell cannot be held by a program");
}

}  // namespace polyarm::program
