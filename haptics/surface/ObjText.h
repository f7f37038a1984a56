#pragma once

#include <array>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Surface of an OBJ file, checked line by line, and its plain text for the OBJ library, which
/// accepts broken files silently and names no line.
struct ObjText
{
    std::vector<double> coordinates; ///< 3 per vertex, as written
    std::vector<int> faceSizes;      ///< number of corners of each face, in the file's order
    /// segments of the file's lines (l) and its points (p), by their vertices from 0; both of a
    /// point are the same
    std::vector<std::array<int, 2>> segments;
    std::string plain; ///< only v and f lines: positive indices, colours if every vertex has one
    std::vector<std::string> warnings;
};

/// Reads and checks a regular file of at most 256 MiB whose faces have at most 4096 corners. Throws
/// InputError "PATH, line N: ...".
ObjText readObjText(const std::string& path);

} // namespace midair::haptics
