#pragma once
/// The parts of the extension module `polyarm._polyarm`. Python code in polyarm/ gives them their shapes and
/// names; nothing else imports the extension.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <string>

#include "polyarm/base/error.hpp"

namespace polyarm::python {

namespace py = pybind11;

/// A contiguous array of doubles; anything else is converted first.
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

[[noreturn]] inline void wrong_shape(const std::string& what) {
  throw Error("wrong-size", what, "see the shapes in docs/python.md");
}

/// Robots and their kinematics; timing; obstacles; a cell in lock-step.
void add_robots(py::module_& module);
void add_motions(py::module_& module);
void add_surroundings(py::module_& module);
void add_cells(py::module_& module);

}  // namespace polyarm::python
