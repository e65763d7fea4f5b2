#include "polyarm/vm/host.hpp"

namespace polyarm::program {

namespace {
[[noreturn]] void refuse_at(const Location& where, const std::string& what) {
  throw Error(Problem{"not-yet", where, what, {}});
}
}  // namespace

void Host::end_move(Handle, const Location& where) {
  refuse_at(where, "this cell cannot end a move on its way");
}

Travel Host::travel(Handle) const {
  refuse_at({}, "this cell does not report the progress of a move");
}

data::Value Host::here(const std::string&, const std::string&, const std::string&) const {
  refuse_at({}, "this cell does not report where its robot is");
}

data::JointState Host::here_joints(const std::string&) const {
  refuse_at({}, "this cell does not tell where its robot is");
}

data::JointState Host::joints_at(const data::Value&, const data::JointState*, const std::string&, const std::string&,
                                 const std::string&) const {
  refuse_at({}, "this cell has no kinematics");
}

data::Value Host::pose_at(const data::JointState&, const std::string&, const std::string&, const std::string&) const {
  refuse_at({}, "this cell has no kinematics");
}

std::array<double, 6> Host::wrench(const std::string&) {
  refuse_at({}, "this cell has no force sensor");
}

void Host::zero_force(const std::string&) {
  refuse_at({}, "this cell has no force sensor");
}

void Host::comply(const std::string&, const Compliance&) {
  refuse_at({}, "this cell has no force sensor");
}

void Host::stiff(const std::string&) {}

namespace {
[[noreturn]] void refuse_belt() {
  refuse_at({}, "this cell has no belts");
}
}  // namespace

bool Host::next_part(const std::string&, const std::string&) {
  refuse_belt();
}

double Host::waiting_parts(const std::string&) {
  refuse_belt();
}

double Host::missed_parts(const std::string&) {
  refuse_belt();
}

void Host::add_part(const std::string&, const Pose&) {
  refuse_belt();
}

data::List Host::rows_of(const std::string& file) {
  refuse_at({}, "this cell has no folder with '" + file + "'");
}

namespace {
[[noreturn]] void refuse_stream() {
  refuse_at({}, "this cell has no streams");
}
}  // namespace

bool Host::is_connected(const std::string&) {
  refuse_stream();
}

bool Host::has_line(const std::string&) {
  refuse_stream();
}

std::string Host::next_line(const std::string&) {
  refuse_stream();
}

void Host::send_text(const std::string&, const std::string&) {
  refuse_stream();
}

void Host::run_program(const std::string&, const Location& where) {
  refuse_at(where, "this is not a test of a cell: no program can be run here");
}

data::Value Host::call(std::string_view function, std::span<const data::Value>, const Location& where) {
  refuse_at(where, std::string(function) + "() exists only in the tests of a cell");
}

void Host::hold(const std::string&, const Location& where) {
  refuse_at(where, "this cell cannot be held by a program");
}

}  // namespace polyarm::program
