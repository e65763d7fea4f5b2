/// The extension module polyarm._polyarm: errors, and where the installation is.
#include "polyarm/base/error.hpp"
#include "polyarm/base/installation.hpp"
#include "python/bindings.hpp"

namespace polyarm::python {

namespace {
py::list problems_of(const Error& error) {
  py::list out;
  for (const Problem& problem : error.problems()) {
    py::dict row;
    row["code"] = problem.code;
    row["what"] = problem.what;
    row["advice"] = problem.advice;
    row["where"] = problem.where.text();
    row["severity"] = problem.severity == Severity::error ? "error" : "warning";
    out.append(row);
  }
  return out;
}

/// polyarm.Error of polyarm/errors.py, with the problems.
void raise(const Error& error) {
  const py::object type = py::module_::import("polyarm.errors").attr("Error");
  const py::object instance = type(problems_of(error), error.what());
  PyErr_SetObject(type.ptr(), instance.ptr());
}
}  // namespace

}  // namespace polyarm::python

PYBIND11_MODULE(_polyarm, module) {
  using namespace polyarm;
  python::py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      python::raise(error);
    }
  });
  module.def("use_installation", [](const std::string& prefix) { installation::use(prefix); });
  module.attr("version") = POLYARM_VERSION;
  python::add_robots(module);
  python::add_motions(module);
  python::add_surroundings(module);
  python::add_cells(module);
}
