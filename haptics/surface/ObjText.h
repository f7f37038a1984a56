#pragma once

#include <string>
#include <vector>

namespace midair::haptics
{

/// The part of an OBJ file that makes its surface, checked line by line, and the same again as
/// plain text for the OBJ library. The library accepts broken files in silence and tells no line.
struct ObjText
{
    std::vector<double> coordinates; ///< 3 a vertex, as written
    std::vector<int> faceSizes;      ///< corners of each face, in the file's order
    std::string plain; ///< only v and f lines: positive indices, colours if every vertex has one
    std::vector<std::string> warnings;
};

/// Reads and checks the file, a regular one of at most 256 MiB whose faces have at most 4096
/// corners; the OBJ library takes in silence what is broken and tells no line. Throws InputError
/// "PATH, line N: ...".
ObjText readObjText(const std::string& path);

} // namespace midair::haptics
