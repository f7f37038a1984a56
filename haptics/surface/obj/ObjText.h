#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace midair::haptics
{

/// A corner of a face, a line or a point: its vertex, and its texture coordinates and normal, which
/// only drawing needs; all count from 0, -1: none.
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

/// What an OBJ file has, checked line by line.
struct ObjText
{
    std::vector<double> coordinates;   ///< 3 per vertex, as written
    std::vector<double> colours;       ///< r, g, b, a per vertex, 0 .. 1; empty: none
    std::vector<double> textures;      ///< 2 each
    std::vector<double> normals;       ///< 3 each
    std::vector<ObjElement> elements;  ///< in the file's order
    std::vector<ObjCorner> corners;    ///< of the elements, one after the other
    std::vector<std::string> warnings; ///< of what is felt otherwise than it was meant
    std::vector<std::string> notes;    ///< of what is only worth knowing
    std::vector<std::pair<int, std::string>> materials; ///< lines, and the files that they name
    /// lines that say to which object, group or material the elements from that number on belong
    std::vector<std::pair<std::size_t, std::string>> states;
};

/// Reads and checks a regular file of at most 256 MiB whose faces have at most 4096 corners. Throws
/// InputError "PATH, line N: ...".
ObjText readObjText(const std::string& path);

/// \a token for a message, without what would spoil it.
std::string inQuotes(std::string_view token);

} // namespace midair::haptics
