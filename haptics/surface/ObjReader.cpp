#include "haptics/surface/ObjReader.h"

#include "haptics/base/InputError.h"
#include "haptics/surface/obj/EarClipping.h"
#include "haptics/surface/obj/ObjText.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Writes a PlainObj.
class PlainWriter
{
public:
    PlainWriter(const ObjText& text, const std::string& path, PlainObj& plain) :
        _text(text),
        _path(path),
        _plain(plain)
    {
    }

    void write();

    std::vector<Eigen::Vector3i> triangles; ///< of the faces that were written, by their vertices

private:
    void writeMaterials();
    void writeNumbers(std::string_view word, const double* numbers, std::size_t count);
    void writeVertices();
    void writeCorner(const ObjCorner& corner);
    void writeFace(const ObjElement& face, const ObjCorner* corners);
    Eigen::Vector3d place(const ObjCorner& corner) const
    {
        return Eigen::Vector3d(&_text.coordinates[3 * static_cast<std::size_t>(corner.vertex)]);
    }

    const ObjText& _text;
    const std::string& _path;
    PlainObj& _plain;
    int _crossing = 0; ///< faces that cross themselves
    int _crossingLine = 0;
};

// Only looks whether the files exist and opens none, as a name may be that of a pipe or a device.
void PlainWriter::writeMaterials()
{
    const std::filesystem::path folder(_path.substr(0, _path.find_last_of('/') + 1));
    const auto take = [&](const std::string& name)
    {
        std::error_code ignored;
        const std::filesystem::path given(name);
        const std::filesystem::path file = given.is_absolute() ? given : folder / given;
        if (name.size() > 1000 || !std::filesystem::is_regular_file(file, ignored)) return false;
        _plain.text += "mtllib " + file.string() + "\n";
        return true;
    };
    for (const auto& [line, names] : _text.materials)
    {
        if (take(names)) continue; // one name with blanks, or several
        std::istringstream words(names);
        for (std::string name; words >> name;)
            if (!take(name))
                _plain.notes.push_back(fmt::format("{}, line {}: the material file {} is not "
                                                   "there; materials are not needed",
                                                   _path,
                                                   line,
                                                   inQuotes(name)));
    }
}

// In the shortest way that reads as the same number, whatever the locale.
void PlainWriter::writeNumbers(std::string_view word, const double* numbers, std::size_t count)
{
    _plain.text += word;
    for (std::size_t i = 0; i < count; ++i)
    {
        std::array<char, 40> buffer{};
        const auto end =
            std::to_chars(buffer.data(), buffer.data() + buffer.size(), numbers[i]).ptr;
        _plain.text += ' ';
        _plain.text.append(buffer.data(), end);
    }
    _plain.text += '\n';
}

void PlainWriter::writeVertices()
{
    const Eigen::Map<const Eigen::Matrix3Xd> all(
        _text.coordinates.data(), 3, static_cast<Eigen::Index>(_text.coordinates.size() / 3));
    // A float far from the origin has the digits of large numbers, and small shapes lose theirs.
    constexpr double kFloat = 6e-8;
    constexpr double kShare = 1e-5;
    const Eigen::Vector3d low = all.rowwise().minCoeff();
    const Eigen::Vector3d high = all.rowwise().maxCoeff();
    const double far = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
    if (far * kFloat > kShare * (high - low).maxCoeff() && low != high)
        _plain.origin = 0.5 * (low + high);
    for (Eigen::Index v = 0; v < all.cols(); ++v)
    {
        std::array<double, 7> numbers{};
        for (Eigen::Index i = 0; i < 3; ++i)
            numbers[static_cast<std::size_t>(i)] = all(i, v) - _plain.origin[i];
        if (!_text.colours.empty())
            std::copy_n(_text.colours.begin() + 4 * v, 4, numbers.begin() + 3);
        writeNumbers("v", numbers.data(), _text.colours.empty() ? 3 : 7);
    }
    for (std::size_t i = 0; i + 1 < _text.textures.size(); i += 2)
        writeNumbers("vt", &_text.textures[i], 2);
    for (std::size_t i = 0; i + 2 < _text.normals.size(); i += 3)
        writeNumbers("vn", &_text.normals[i], 3);
}

void PlainWriter::writeCorner(const ObjCorner& corner)
{
    const auto out = std::back_inserter(_plain.text);
    fmt::format_to(out, " {}", corner.vertex + 1);
    if (corner.texture >= 0) fmt::format_to(out, "/{}", corner.texture + 1);
    if (corner.normal >= 0)
        fmt::format_to(out, "{}{}", corner.texture >= 0 ? "/" : "//", corner.normal + 1);
}

void PlainWriter::writeFace(const ObjElement& face, const ObjCorner* corners)
{
    std::vector<std::array<int, 3>> parts{{0, 1, 2}};
    if (face.corners > 3)
    {
        Eigen::Matrix3Xd places(3, face.corners);
        for (int i = 0; i < face.corners; ++i)
            places.col(i) = place(corners[i]);
        bool crosses = false;
        parts = triangulated(places, crosses);
        if (crosses && _crossing++ == 0) _crossingLine = face.line;
    }
    for (const auto& part : parts)
    {
        _plain.text += 'f';
        for (const int corner : part)
            writeCorner(corners[corner]);
        _plain.text += '\n';
        const auto vertex = [&](int k) { return static_cast<int>(corners[part[k]].vertex); };
        triangles.emplace_back(vertex(0), vertex(1), vertex(2));
    }
}

void PlainWriter::write()
{
    _plain.text.reserve(80 * _text.coordinates.size() / 3 + 40 * _text.corners.size());
    writeMaterials();
    writeVertices();
    std::size_t state = 0;
    const ObjCorner* corners = _text.corners.data();
    for (std::size_t i = 0; i < _text.elements.size(); ++i)
    {
        for (; state < _text.states.size() && _text.states[state].first <= i; ++state)
            _plain.text += _text.states[state].second + "\n";
        const ObjElement& element = _text.elements[i];
        if (element.corners > 2)
            writeFace(element, corners);
        else
        {
            _plain.text += element.corners == 2 ? 'l' : 'p';
            for (int k = 0; k < element.corners; ++k)
                writeCorner({corners[k].vertex, -1, -1});
            _plain.text += '\n';
        }
        corners += element.corners;
    }
    if (_crossing > 0)
        _plain.warnings.push_back(
            fmt::format("{}, line {}: the face crosses itself{}; another shape may be felt there",
                        _path,
                        _crossingLine,
                        _crossing > 1 ? fmt::format(", as {} more do", _crossing - 1) : ""));
}

/// \a triangles: those of the faces, by their vertices.
PlainObj plainObj(ObjText& text, const std::string& path, std::vector<Eigen::Vector3i>& triangles)
{
    PlainObj plain;
    plain.warnings = std::move(text.warnings);
    plain.notes = std::move(text.notes);
    PlainWriter writer(text, path, plain);
    writer.write();
    triangles = std::move(writer.triangles);
    return plain;
}

/// Appends lines and points as triangles without area.
void addSegments(const ObjText& text, std::vector<Eigen::Vector3i>& triangles)
{
    const ObjCorner* corner = text.corners.data();
    for (const ObjElement& element : text.elements)
    {
        const auto from = static_cast<int>(corner[0].vertex);
        const auto to = static_cast<int>(corner[element.corners - 1].vertex);
        if (element.corners < 3) triangles.emplace_back(from, to, to);
        corner += element.corners;
    }
}

} // namespace

TriangleMesh readObj(const std::string& path, std::vector<std::string>* warnings)
{
    ObjText text = readObjText(path);
    std::vector<Eigen::Vector3i> triangles;
    const PlainObj plain = plainObj(text, path, triangles);
    addSegments(text, triangles);
    TriangleMesh mesh;
    mesh.vertices = Eigen::Map<const Eigen::Matrix3Xd>(
        text.coordinates.data(), 3, static_cast<Eigen::Index>(text.coordinates.size() / 3));
    mesh.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
    for (std::size_t t = 0; t < triangles.size(); ++t)
        mesh.triangles.col(static_cast<Eigen::Index>(t)) = triangles[t];
    if (!text.colours.empty())
        mesh.intensity =
            Eigen::Map<const Eigen::Matrix4Xd>(
                text.colours.data(), 4, static_cast<Eigen::Index>(text.colours.size() / 4))
                .topRows<3>()
                .colwise()
                .mean()
                .cast<float>();
    if (warnings != nullptr)
    {
        warnings->insert(warnings->end(), plain.warnings.begin(), plain.warnings.end());
        warnings->insert(warnings->end(), plain.notes.begin(), plain.notes.end());
    }
    return mesh;
}

PlainObj readPlainObj(const std::string& path)
{
    ObjText text = readObjText(path);
    std::vector<Eigen::Vector3i> unused;
    return plainObj(text, path, unused);
}

} // namespace midair::haptics
