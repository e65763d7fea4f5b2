#include "polyarm/description/shape_yaml.hpp"

#include <string>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::description {

const std::vector<std::string>& shape_keys() {
  static const std::vector<std::string> keys = {"box", "cylinder", "sphere", "capsule"};
  return keys;
}

namespace {
double positive(const Yaml& yaml) {
  const double value = yaml.number(Dimension::length);
  constexpr double kLargest = bounds::kSceneMetres;
  if (!(value > 0 && value <= kLargest))
    throw Error(Problem{"bad-value",
                        yaml.where(),
                        "'" + yaml.text() + "' is no size: it must be above zero and at most " +
                            std::to_string(bounds::kSceneMetres) + " m",
                        {}});
  return value;
}
}  // namespace

Shape read_shape(const Yaml& yaml) {
  std::vector<std::string> said;
  for (const std::string& key : shape_keys())
    if (yaml.has(key)) said.push_back(key);
  if (said.size() != 1)
    throw Error(Problem{
        "missing-key", yaml.where(),
        said.empty() ? "no shape is given here" : "more than one shape is given here: " + join(said, ", "),
        "give one of: " + join(shape_keys(), ", ")});
  Shape out;
  const Yaml value = yaml[said.front()];
  if (said.front() == "box") {
    out.kind = ShapeKind::box;
    out.size = value.vec3();
    for (const Yaml& edge : value.items()) positive(edge);
  } else if (said.front() == "cylinder") {
    out.kind = ShapeKind::cylinder;
    out.radius = positive(value.required("radius"));
    out.length = positive(value.required("height"));
  } else if (said.front() == "sphere") {
    out.kind = ShapeKind::sphere;
    out.radius = positive(value.required("radius"));
  } else {
    out.kind = ShapeKind::capsule;
    out.radius = positive(value.required("radius"));
    out.length = positive(value.required("length"));
  }
  return out;
}

}  // namespace polyarm::description
