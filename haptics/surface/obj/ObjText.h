#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace midair::haptics
{

/// Corner of a face, line or point: indices from 0 of its vertex, and of texture coordinates and
/// normal, which are only for drawing; -1: none.
struct ObjCorner
{
    long long vertex;
    int texture;
    int normal;
};

/// A face (3 corners or more), a segment of a line (2) or a point (1).
struct ObjElement
{
    int line; ///< in the file, from 1
    int corners;
};

/// Content of an OBJ file, checked line by line.
struct ObjText
{
    std::vector<double> coordinates;   ///< 3 per vertex, as written
    std::vector<double> colours;       ///< r, g, b, a per vertex, 0 .. 1; empty: none
    std::vector<double> textures;      ///< 2 each
    std::vector<double> normals;       ///< 3 each
    std::vector<ObjElement> elements;  ///< in the file's order
    std::vector<ObjCorner> corners;    ///< of the elements, one after the other
    std::vector<std::string> warnings; ///< for shapes that will feel different from what was
                                       ///< intended
    std::vector<std::string> notes;    ///< for information only
    std::vector<std::pair<int, std::string>> materials; ///< lines, and the material files they name
    /// lines that name the object, group or material of the elements from that number on
    std::vector<std::pair<std::size_t, std::string>> states;
};

/// Reads and checks a regular file of at most 256 MiB whose faces have at most 4096 corners. Throws
/// InputError "PATH, line N: ...".
ObjText readObjText(const std::string& path);

/// Returns \a token in quotes for a message, without characters that would spoil it.
std::string inQuotes(std::string_view token);

} // namespace midair::haptics
