#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::samples
{

/// One of the paper's scenes: control points of equal pressure.
struct PaperScene
{
    std::string name;
    std::string caption;     ///< what it is, and the paper's number where it has one
    Eigen::Matrix3Xd points; ///< 3 x n, metres, array frame
};

/// Returns all scenes: the focus, the line, the flat star, the star of \a model (the vertices of an
/// OBJ file), and the lines of the two experiments at the paper's thresholds.
std::vector<PaperScene> paperScenes(const std::string& model);

} // namespace midair::samples
