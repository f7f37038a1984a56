#include "haptics/surface/ObjReader.h"

#include "haptics/base/InputError.h"
#include "haptics/surface/obj/ObjText.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <filesystem>
#include <iterator>
#include <limits>
#include <sstream>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <tiny_obj_loader.h>

namespace midair::haptics
{

namespace
{

/// Cuts off a polygon's ears: convex corners whose triangle has no other corner inside (G. H.
/// Meisters, "Polygons have ears", 1975). Other corners are checked again only if their neighbours
/// change, so that a simple polygon takes O(n^2).
class EarClipping
{
public:
    // Computes the normal by Newell's method and drops its longest axis.
    explicit EarClipping(const Eigen::Matrix3Xd& corners) :
        _places(2, corners.cols()),
        _isKnown(static_cast<std::size_t>(corners.cols()), false),
        _left(static_cast<int>(corners.cols()))
    {
        const Eigen::Matrix3Xd at = corners.colwise() - corners.col(0).eval();
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();
        for (int i = 0; i < _left; ++i)
        {
            const int next = (i + 1) % _left;
            normal += Eigen::Vector3d(at.col(i)).cross(Eigen::Vector3d(at.col(next)));
            _before.push_back((i + _left - 1) % _left);
            _after.push_back(next);
        }
        Eigen::Index away = 0;
        normal.cwiseAbs().maxCoeff(&away);
        const bool isTurned = normal[away] < 0.0;
        _places.row(isTurned ? 1 : 0) = at.row((away + 1) % 3);
        _places.row(isTurned ? 0 : 1) = at.row((away + 2) % 3);
        _flat = 1e-14 * at.colwise().squaredNorm().maxCoeff();
    }
    void run()
    {
        constexpr int kMostStuck =
            16; // then it crosses itself everywhere, and the choice doesn't matter any more
        int stuck = 0;
        int misses = 0;
        bool isFresh = false; // all remaining corners were checked again
        // Quads are split along their shorter diagonal, if it is inside.
        const auto diagonal2 = [this](int from)
        { return (_places.col(from) - _places.col(from + 2)).squaredNorm(); };
        int corner = _left == 4 && diagonal2(0) < diagonal2(1) ? 1 : 0;
        while (_left > 3)
        {
            if (stuck > kMostStuck ||
                (!_isKnown[static_cast<std::size_t>(corner)] && isEar(corner)))
            {
                corner = cut(corner);
                misses = 0;
                isFresh = false;
                continue;
            }
            _isKnown[static_cast<std::size_t>(corner)] = true;
            corner = after(corner);
            if (++misses < _left) continue;
            misses = 0;
            if (isFresh)
            {
                corner = cut(flattest(corner));
                ++stuck;
            }
            else
                _isKnown.assign(_isKnown.size(), false);
            isFresh = !isFresh;
        }
        cut(corner);
    }

    std::vector<std::array<int, 3>> triangles;
    bool isClean = true; ///< no triangle is flipped

private:
    int& before(int corner) { return _before[static_cast<std::size_t>(corner)]; }
    int& after(int corner) { return _after[static_cast<std::size_t>(corner)]; }
    /// Twice the area of three corners; above 0: same orientation as the polygon.
    double turn(int a, int b, int c) const
    {
        const Eigen::Vector2d ab = _places.col(b) - _places.col(a);
        const Eigen::Vector2d ac = _places.col(c) - _places.col(a);
        return ab.x() * ac.y() - ab.y() * ac.x();
    }
    bool isEar(int corner)
    {
        const int a = before(corner);
        const int c = after(corner);
        if (!(turn(a, corner, c) > _flat)) return false;
        for (int i = after(c); i != a; i = after(i))
        {
            // Where a hole is joined to the outline, two corners coincide.
            const auto isAt = [&](int other) { return _places.col(i) == _places.col(other); };
            if (isAt(a) || isAt(corner) || isAt(c)) continue;
            if (turn(a, corner, i) >= 0.0 && turn(corner, c, i) >= 0.0 && turn(c, a, i) >= 0.0)
                return false;
        }
        return true;
    }
    /// Returns the next corner.
    int cut(int corner)
    {
        const int a = before(corner);
        const int c = after(corner);
        if (turn(a, corner, c) < -_flat) isClean = false;
        // Starts at the lowest corner.
        if (corner < a && corner < c)
            triangles.push_back({corner, c, a});
        else if (c < a)
            triangles.push_back({c, a, corner});
        else
            triangles.push_back({a, corner, c});
        --_left;
        after(a) = c;
        before(c) = a;
        _isKnown[static_cast<std::size_t>(a)] = _isKnown[static_cast<std::size_t>(c)] = false;
        return c;
    }
    /// Returns the corner whose removal does the least harm, if none is an ear.
    int flattest(int from)
    {
        int best = from;
        double least = std::numeric_limits<double>::infinity();
        for (int i = from, n = 0; n < _left; ++n, i = after(i))
        {
            const double size = std::abs(turn(before(i), i, after(i)));
            if (!(size < least)) continue;
            best = i;
            least = size;
        }
        return best;
    }

    Eigen::Matrix2Xd _places;
    std::vector<int> _before; ///< in the ring of remaining corners
    std::vector<int> _after;
    std::vector<bool> _isKnown; ///< not an ear, until its neighbours change
    int _left;
    double _flat; ///< twice the area below which three corners are collinear
};

/// Splits a polygon of \a corners (3 x n, n >= 3) into n - 2 triangles, with corners counted from 0
/// and the polygon's winding. A polygon that isn't flat is projected along its mean normal. \a
/// crosses: it crosses itself, so its triangles overlap.
std::vector<std::array<int, 3>> triangulated(const Eigen::Matrix3Xd& corners, bool& crosses)
{
    EarClipping ears(corners);
    ears.run();
    crosses = !ears.isClean;
    return std::move(ears.triangles);
}

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

    void write()
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
            _plain.warnings.push_back(fmt::format(
                "{}, line {}: the face crosses itself{}; another shape may be felt there",
                _path,
                _crossingLine,
                _crossing > 1 ? fmt::format(", as {} more do", _crossing - 1) : ""));
    }

private:
    // Checks only whether the files exist and opens none, because a name may be that of a pipe or
    // device.
    void writeMaterials()
    {
        const std::filesystem::path folder(_path.substr(0, _path.find_last_of('/') + 1));
        const auto take = [&](const std::string& name)
        {
            std::error_code ignored;
            const std::filesystem::path given(name);
            const std::filesystem::path file = given.is_absolute() ? given : folder / given;
            if (name.size() > 1000 || !std::filesystem::is_regular_file(file, ignored))
                return false;
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
    // Writes the shortest text that reads back as the same number, in any locale.
    void writeNumbers(std::string_view word, const double* numbers, std::size_t count)
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
    void writeVertices()
    {
        const Eigen::Map<const Eigen::Matrix3Xd> all(
            _text.coordinates.data(), 3, static_cast<Eigen::Index>(_text.coordinates.size() / 3));
        // Floats far from the origin have the precision of large numbers, so small shapes would
        // lose digits.
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
    void writeCorner(const ObjCorner& corner)
    {
        const auto out = std::back_inserter(_plain.text);
        fmt::format_to(out, " {}", corner.vertex + 1);
        if (corner.texture >= 0) fmt::format_to(out, "/{}", corner.texture + 1);
        if (corner.normal >= 0)
            fmt::format_to(out, "{}{}", corner.texture >= 0 ? "/" : "//", corner.normal + 1);
    }
    void writeFace(const ObjElement& face, const ObjCorner* corners)
    {
        std::vector<std::array<int, 3>> triangles{{0, 1, 2}};
        if (face.corners > 3)
        {
            Eigen::Matrix3Xd places(3, face.corners);
            for (int i = 0; i < face.corners; ++i)
                places.col(i) = place(corners[i]);
            bool crosses = false;
            triangles = triangulated(places, crosses);
            if (crosses && _crossing++ == 0) _crossingLine = face.line;
        }
        for (const auto& triangle : triangles)
        {
            _plain.text += 'f';
            for (const int corner : triangle)
                writeCorner(corners[corner]);
            _plain.text += '\n';
        }
    }
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

PlainObj plainObj(ObjText& text, const std::string& path)
{
    PlainObj plain;
    plain.warnings = std::move(text.warnings);
    plain.notes = std::move(text.notes);
    PlainWriter(text, path, plain).write();
    return plain;
}

/// The plain text's triangles and colours, as the OBJ library reads them.
TriangleMesh parsed(const std::string& text, const std::string& path)
{
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warning;
    std::string error;
    bool good = false;
    try
    {
        std::istringstream stream(text);
        good = tinyobj::LoadObj(
            &attributes, &shapes, &materials, &warning, &error, &stream, nullptr, true, false);
    }
    catch (const std::exception& exception)
    {
        error = exception.what();
    }
    if (!good) throw base::InputError(path + ": the file can't be parsed: " + error);
    TriangleMesh mesh;
    std::vector<int> indices;
    for (const tinyobj::shape_t& shape : shapes)
        for (const tinyobj::index_t& index : shape.mesh.indices)
            indices.push_back(index.vertex_index);
    mesh.triangles = Eigen::Map<const Eigen::Matrix3Xi>(
        indices.data(), 3, static_cast<Eigen::Index>(indices.size() / 3));
    if (!attributes.colors.empty())
        mesh.intensity = Eigen::Map<const Eigen::Matrix3Xd>(
                             attributes.colors.data(),
                             3,
                             static_cast<Eigen::Index>(attributes.colors.size() / 3))
                             .colwise()
                             .mean()
                             .cast<float>();
    return mesh;
}

/// Appends lines and points as degenerate triangles.
void addSegments(TriangleMesh& mesh, const ObjText& text)
{
    std::vector<Eigen::Vector3i> segments;
    const ObjCorner* corner = text.corners.data();
    for (const ObjElement& element : text.elements)
    {
        const auto from = static_cast<int>(corner[0].vertex);
        const auto to = static_cast<int>(corner[element.corners - 1].vertex);
        if (element.corners < 3) segments.emplace_back(from, to, to);
        corner += element.corners;
    }
    Eigen::Index t = mesh.triangles.cols();
    mesh.triangles.conservativeResize(3, t + static_cast<Eigen::Index>(segments.size()));
    for (const Eigen::Vector3i& segment : segments)
        mesh.triangles.col(t++) = segment;
}

} // namespace

TriangleMesh readObj(const std::string& path, std::vector<std::string>* warnings)
{
    ObjText text = readObjText(path);
    const PlainObj plain = plainObj(text, path);
    TriangleMesh mesh = parsed(plain.text, path);
    mesh.vertices = Eigen::Map<const Eigen::Matrix3Xd>(
        text.coordinates.data(), 3, static_cast<Eigen::Index>(text.coordinates.size() / 3));
    if (text.colours.empty()) mesh.intensity.resize(0);
    addSegments(mesh, text);
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
    return plainObj(text, path);
}

} // namespace midair::haptics
