#pragma once

#include "tests/referee/Recompute.h"

#include <map>
#include <string>
#include <vector>

namespace midair::referee
{

/// Recomputes the figures of the surface, by the names of figuresOf(), for \a fields (K times m
/// activations) that are played in turn at the pose of \a update: radiation pressures in double
/// with ReferencePropagation, at the places that the kit's sampler chooses on the mesh, and at
/// places off it that are drawn here anew.
std::map<std::string, Truth> surfaceFigures(const Recorded& recorded,
                                            const Update& update,
                                            const std::vector<Eigen::VectorXcd>& fields);

} // namespace midair::referee
