#pragma once

#include <string>

/// A PLY of a square, with a face of \a indices.
inline std::string ply(const std::string& indices, bool hasNormals = false)
{
    std::string text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float "
                       "y\nproperty float z\n";
    if (hasNormals) text += "property float nx\nproperty float ny\nproperty float nz\n";
    text += "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    for (const char* vertex : {"-0.02 -0.02 0", "0.02 -0.02 0", "0.02 0.02 0", "-0.02 0.02 0"})
        text += std::string(vertex) + (hasNormals ? " 0 0 1\n" : "\n");
    return text + "3 0 1 2\n" + indices + "\n";
}
