#pragma once
/// Builds the surfaces of one rigid body of a robot in a style.
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/shapes/skeleton.hpp"
#include "polyarm/shapes/style.hpp"

namespace polyarm::shapes {

/// Where a body is in its arm: how many moving joints lead to it, and how many to the arm's tip.
struct Rank {
  int depth = 0, most = 0;
};

/// `travel`: rad or m that the body's joint moves; matters for sliding ones.
meshes::Mesh build_link(const RigidBody& body, const Style& style, const Rank& rank, double travel);

}  // namespace polyarm::shapes
