#include "haptics/surface/ObjReader.h"

#include "haptics/base/InputError.h"
#include "haptics/surface/ObjText.h"

#include <Eigen/Geometry>

#include <exception>
#include <sstream>

#include <fmt/format.h>
#include <tiny_obj_loader.h>

namespace midair::haptics
{

namespace
{

Eigen::Vector3d areaVector(const TriangleMesh& mesh, const Eigen::Vector3i& corners)
{
    const Eigen::Vector3d a = mesh.vertices.col(corners[0]);
    return (mesh.vertices.col(corners[1]) - a).cross(mesh.vertices.col(corners[2]) - a);
}

/// Splits concave quads along their other diagonal where the library has split them along one that
/// lies outside, which shows as two triangles with opposite normals. (The library takes the shorter
/// one.)
void mendConcaveQuads(TriangleMesh& mesh, const std::vector<int>& faceSizes)
{
    Eigen::Index t = 0;
    for (const int corners : faceSizes)
    {
        if (corners == 4)
        {
            const Eigen::Vector3i first = mesh.triangles.col(t);
            const Eigen::Vector3i second = mesh.triangles.col(t + 1);
            // Split along 0-2 the second triangle starts at corner 0, along 1-3 at corner 1.
            const bool along02 = second[0] == first[0];
            const int c0 = first[0];
            const int c1 = first[1];
            const int c2 = along02 ? first[2] : second[1];
            const int c3 = second[2];
            if (areaVector(mesh, first).dot(areaVector(mesh, second)) < 0.0)
            {
                mesh.triangles.col(t) =
                    along02 ? Eigen::Vector3i(c0, c1, c3) : Eigen::Vector3i(c0, c1, c2);
                mesh.triangles.col(t + 1) =
                    along02 ? Eigen::Vector3i(c1, c2, c3) : Eigen::Vector3i(c0, c2, c3);
            }
        }
        t += corners - 2;
    }
}

/// The checked text's faces as triangles, and its colours, as the OBJ library reads them.
TriangleMesh parsed(const ObjText& text, const std::string& path)
{
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warning;
    std::string error;
    bool good = false;
    try
    {
        std::istringstream stream(text.plain);
        good = tinyobj::LoadObj(
            &attributes, &shapes, &materials, &warning, &error, &stream, nullptr, true, false);
    }
    catch (const std::exception& exception)
    {
        error = exception.what();
    }
    if (!good) throw base::InputError(path + ": the file can't be parsed: " + error);

    TriangleMesh mesh;
    mesh.vertices = Eigen::Map<const Eigen::Matrix3Xd>(
        text.coordinates.data(), 3, static_cast<Eigen::Index>(text.coordinates.size() / 3));
    std::vector<int> indices;
    for (const tinyobj::shape_t& shape : shapes)
        for (const tinyobj::index_t& index : shape.mesh.indices)
            indices.push_back(index.vertex_index);
    mesh.triangles = Eigen::Map<const Eigen::Matrix3Xi>(
        indices.data(), 3, static_cast<Eigen::Index>(indices.size() / 3));
    if (attributes.colors.size() == text.coordinates.size())
        mesh.intensity =
            Eigen::Map<const Eigen::Matrix3Xd>(attributes.colors.data(), 3, mesh.vertices.cols())
                .colwise()
                .mean()
                .cast<float>();
    return mesh;
}

/// Appends lines and points as triangles without area.
void addSegments(TriangleMesh& mesh, const std::vector<std::array<int, 2>>& segments)
{
    Eigen::Index t = mesh.triangles.cols();
    mesh.triangles.conservativeResize(3, t + static_cast<Eigen::Index>(segments.size()));
    for (const auto& [from, to] : segments)
        mesh.triangles.col(t++) << from, to, to;
}

} // namespace

TriangleMesh readObj(const std::string& path, std::vector<std::string>* warnings)
{
    ObjText text = readObjText(path);
    TriangleMesh mesh = parsed(text, path);
    Eigen::Index expected = 0;
    for (const int corners : text.faceSizes)
        expected += corners - 2;
    if (mesh.triangles.cols() == expected)
    {
        mendConcaveQuads(mesh, text.faceSizes);
    }
    else
    {
        text.warnings.push_back(fmt::format("{}: {} triangles were expected of its polygons, {} "
                                            "came; a polygon crosses itself or has no area",
                                            path,
                                            expected,
                                            mesh.triangles.cols()));
    }
    addSegments(mesh, text.segments);
    if (mesh.triangles.cols() == 0)
    {
        throw base::InputError(fmt::format(
            "{}: none of its {} faces can be triangulated", path, text.faceSizes.size()));
    }
    if (warnings != nullptr)
    {
        warnings->insert(warnings->end(), text.warnings.begin(), text.warnings.end());
    }
    return mesh;
}

} // namespace midair::haptics
