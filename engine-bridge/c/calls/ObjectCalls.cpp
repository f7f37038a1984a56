// midair_add_..(): objects of a scene.
#include "engine-bridge/c/inside/Scene.h"
#include "haptics/base/text/Words.h"
#include "haptics/sensation/SensationReader.h"
#include "haptics/surface/ObjReader.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

constexpr std::size_t kMostVertices = 50'000'000;
constexpr std::size_t kMostPoints = 100'000; // limit of midair-solve's files
constexpr double kLeastPressure = 1e-6;
constexpr double kMostPressure = 1e5;

std::uint64_t nextMesh()
{
    static std::atomic<std::uint64_t> next{1};
    return next++;
}

void requireCount(std::size_t count, std::size_t most, const char* name)
{
    if (count < 1 || count > most)
        fail(MIDAIR_INVALID, fmt::format("{} is {}; it must be 1 .. {}", name, count, most));
}

Eigen::Matrix3Xd placesOf(const double* places, std::size_t count, const char* name)
{
    given(places, name);
    requireFinite(places, 3 * count, name, 3);
    return Eigen::Map<const Eigen::Matrix3Xd>(places, 3, static_cast<Eigen::Index>(count));
}

void setTriangles(const uint32_t* triangles,
                  std::size_t count,
                  std::size_t vertices,
                  haptics::TriangleMesh& mesh)
{
    given(triangles, "triangles");
    mesh.triangles.resize(3, static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < 3 * count; ++i)
    {
        if (triangles[i] >= vertices)
            fail(MIDAIR_INVALID,
                 fmt::format("triangle {} has the vertex {}; there are {}, from 0",
                             i / 3,
                             triangles[i],
                             vertices));
        mesh.triangles.data()[i] = static_cast<int>(triangles[i]);
    }
}

void setIntensity(const float* intensity, std::size_t vertices, haptics::TriangleMesh& mesh)
{
    for (std::size_t i = 0; i < vertices; ++i)
        if (!(intensity[i] >= 0.0F && intensity[i] <= 1.0F))
            fail(MIDAIR_INVALID,
                 fmt::format("intensity {} is {:g}; it must be 0 .. 1", i, intensity[i]));
    mesh.intensity =
        Eigen::Map<const Eigen::VectorXf>(intensity, static_cast<Eigen::Index>(vertices));
}

midair_object add(Scene& scene, haptics::TriangleMesh mesh, SceneObject object)
{
    object.mesh = std::make_shared<const haptics::TriangleMesh>(std::move(mesh));
    object.meshId = nextMesh();
    object.topologyId = object.meshId;
    const auto number = static_cast<midair_object>(nextHandle());
    object.number = std::make_shared<const midair_object>(number);
    const base::Lock lock(scene.mutex);
    scene.objects.emplace(number, std::move(object));
    return number;
}

/// Stores \a pressures as intensities of 0 .. 1 and a pressure that is a power of two, so that
/// their product is the given pressure, rounded to a float.
void setPressures(const double* pressures,
                  std::size_t count,
                  bool inPascal,
                  SceneObject& object,
                  haptics::TriangleMesh& mesh)
{
    object.properties.pressureUnit = inPascal ? ObjectSettings::PASCAL : ObjectSettings::RELATIVE;
    if (!pressures) return;
    double largest = 0.0;
    for (std::size_t i = 0; i < count; ++i)
    {
        const double p = pressures[i];
        if (!(p == 0.0 || (p >= kLeastPressure && p <= kMostPressure)))
            fail(MIDAIR_INVALID,
                 fmt::format("pressure {} is {:g}; it must be 0 or 1e-6 .. 1e5", i, p));
        largest = std::max(largest, p);
    }
    if (largest == 0.0) fail(MIDAIR_INVALID, "all pressures are 0: there is nothing to feel");
    object.properties.pressure = std::exp2(std::ceil(std::log2(largest)));
    mesh.intensity = Eigen::Map<const Eigen::VectorXd>(pressures, static_cast<Eigen::Index>(count))
                         .cast<float>() /
                     static_cast<float>(object.properties.pressure);
}

} // namespace

midair_status midair_add_mesh(midair_scene* scene,
                              const double* vertices,
                              size_t vertex_count,
                              const uint32_t* triangles,
                              size_t triangle_count,
                              const float* intensity,
                              midair_object* object)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(object, "object");
            requireCount(vertex_count, kMostVertices, "vertex_count");
            requireCount(triangle_count, kMostVertices, "triangle_count");
            haptics::TriangleMesh mesh;
            mesh.vertices = placesOf(vertices, vertex_count, "vertices");
            setTriangles(triangles, triangle_count, vertex_count, mesh);
            if (intensity) setIntensity(intensity, vertex_count, mesh);
            *object = add(*of, std::move(mesh), {});
        });
}

midair_status
midair_add_file(midair_scene* scene, const char* obj_file, double size_m, midair_object* object)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(object, "object");
            if (!(size_m >= 0.0 && size_m <= 1e3))
                fail(MIDAIR_INVALID,
                     fmt::format("size_m is {:g}; it must be 0 (as in the file) .. 1000", size_m));
            std::vector<std::string> warnings;
            haptics::TriangleMesh mesh =
                haptics::readObj(textGiven(obj_file, "obj_file", 4096), &warnings);
            {
                const base::Lock lock(of->mutex);
                for (const std::string& warning : warnings)
                    of->player.log().say({base::MessageCode::OBJECT_GEOMETRY, warning});
            }
            if (size_m > 0.0) mesh = mesh.scaledTo(size_m);
            *object = add(*of, std::move(mesh), {});
        });
}

midair_status midair_add_points(midair_scene* scene,
                                const double* positions,
                                const double* pressures,
                                size_t count,
                                int32_t in_pascal,
                                midair_object* object)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(object, "object");
            requireCount(count, kMostPoints, "count");
            if (in_pascal && !pressures)
                fail(MIDAIR_INVALID, "pressures is NULL; points in Pa need theirs");
            haptics::TriangleMesh mesh;
            SceneObject points;
            points.isPoints = true;
            mesh.vertices = placesOf(positions, count, "positions");
            mesh.triangles.resize(3, static_cast<Eigen::Index>(count));
            for (Eigen::Index i = 0; i < mesh.triangles.cols(); ++i)
                mesh.triangles.col(i).setConstant(static_cast<int>(i));
            setPressures(pressures, count, in_pascal != 0, points, mesh);
            points.felt = forPipeline(points.properties);
            points.felt.sampling = haptics::Sampling::POINTS;
            *object = add(*of, std::move(mesh), std::move(points));
        });
}

midair_status
midair_add_sensation(midair_scene* scene, const char* sensation, midair_object* object)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(object, "object");
            SceneObject made;
            made.properties.sensation =
                textGiven(sensation, "sensation", haptics::kMostSensationBytes);
            if (base::trimmed(made.properties.sensation).empty())
                fail(MIDAIR_INVALID, "sensation is empty");
            made.felt = forPipeline(made.properties);
            *object = add(*of, {}, std::move(made));
        });
}

midair_status midair_move_vertices(midair_scene* scene,
                                   midair_object object,
                                   const double* vertices,
                                   size_t vertex_count)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            requireCount(vertex_count, kMostVertices, "vertex_count");
            Eigen::Matrix3Xd places = placesOf(vertices, vertex_count, "vertices");
            const base::Lock lock(of->mutex);
            SceneObject& one = objectOf(*of, object);
            if (places.cols() != one.mesh->vertices.cols())
                fail(MIDAIR_INVALID,
                     fmt::format("vertex_count is {}; the object has {}",
                                 vertex_count,
                                 one.mesh->vertices.cols()));
            haptics::TriangleMesh moved = *one.mesh;
            moved.vertices = std::move(places);
            one.mesh = std::make_shared<const haptics::TriangleMesh>(std::move(moved));
            one.meshId = nextMesh();
        });
}

midair_status midair_remove(midair_scene* scene, midair_object object)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            objectOf(*of, object);
            of->objects.erase(object);
        });
}
