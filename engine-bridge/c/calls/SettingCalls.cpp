// midair_set() and related calls: settings and properties by name.
#include "engine-bridge/c/inside/Scene.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"

#include <algorithm>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

constexpr std::size_t kMostText = std::size_t(4) << 20; // that of a sensation's pattern

/// Returns the problem of the transducers named in the settings of \a scene; empty: none.
std::string problemOfMarks(const Scene& scene) MIDAIR_REQUIRES(scene.mutex)
{
    try
    {
        scene.markedArray();
        return {};
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
}

/// Sets \a name in \a object from \a value. Returns an error, with \a object unchanged, or an empty
/// text.
template<typename T>
std::string assigned(const base::SettingTable<T>& table,
                     T& object,
                     const std::string& name,
                     const std::string& value)
{
    T changed = object;
    std::string error;
    if (!table.set(changed, name, value, error)) return error;
    const base::Setting<T>& row = *table.find(name);
    if (!row.holds(changed)) return name + " " + row.problem(changed, value);
    object = std::move(changed);
    return {};
}

/// Returns the safety settings that \a name may be a misspelling of.
template<typename T>
std::vector<std::string> meantBy(const base::SettingTable<T>& table, const std::string& name)
{
    std::vector<std::string> meant =
        table.find(name) ? std::vector<std::string>{name} : base::nearestWords(name, table.names());
    meant.erase(std::remove_if(meant.begin(),
                               meant.end(),
                               [&](const std::string& one) { return !table.find(one)->isSafety; }),
                meant.end());
    return meant;
}

/// Records an error that concerns safety, and fails.
template<typename T>
[[noreturn]] void refuse(const base::SettingTable<T>& table,
                         const std::string& name,
                         std::string error,
                         Scene& scene,
                         Misunderstood& misunderstood) MIDAIR_REQUIRES(scene.mutex)
{
    const midair_status status = table.find(name) ? MIDAIR_INVALID : MIDAIR_UNKNOWN;
    if (std::vector<std::string> meant = meantBy(table, name); !meant.empty())
    {
        error += "; nothing is played";
        misunderstood.note(std::move(meant), error);
        scene.player.silence();
    }
    fail(status, error);
}

template<typename T>
midair_status get(const base::SettingTable<T>& table,
                  const T& object,
                  const std::string& name,
                  char* text,
                  size_t size,
                  size_t* needed)
{
    const base::Setting<T>* row = table.find(name);
    if (!row)
    {
        T scratch;
        std::string error;
        table.set(scratch, name, "", error);
        fail(MIDAIR_UNKNOWN, error);
    }
    return writeText(row->defaultText(object), text, size, needed);
}

/// Names and summaries at fixed addresses.
template<typename T>
const std::vector<std::pair<std::string, std::string>>&
described(const base::SettingTable<T>& table)
{
    static const auto* const all =
        new std::vector<std::pair<std::string, std::string>>(table.describe());
    return *all;
}

/// Deviations of a pose from a rotation up to this are rounding errors.
constexpr double kRigid = 1e-6;

Eigen::Isometry3d poseOf(const double* matrix)
{
    given(matrix, "matrix");
    requireFinite(matrix, 16, "matrix", 4);
    const Eigen::Matrix4d m =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(matrix);
    const Eigen::Matrix3d turn = m.topLeftCorner<3, 3>();
    if (!(m.row(3) - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).isZero(kRigid))
        fail(MIDAIR_INVALID, "the matrix' last row must be 0 0 0 1: it is read row by row");
    if (!(turn.transpose() * turn).isIdentity(kRigid) || turn.determinant() < 0.0)
        fail(MIDAIR_INVALID,
             "the matrix is not a rotation with a translation; apply scales to the vertices");
    Eigen::Isometry3d pose;
    pose.matrix() = m;
    return pose;
}

} // namespace

midair_status midair_set(midair_scene* scene, const char* name, const char* value)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const std::string setting = textGiven(name, "name", 256);
            const std::string text = textGiven(value, "value", kMostText);
            const base::Lock lock(of->mutex);
            const SceneSettings before = of->settings;
            std::string error = assigned(sceneTable(), of->settings, setting, text);
            if (error.empty() && (setting == "dead" || setting == "weak"))
                error = problemOfMarks(*of);
            if (!error.empty())
            {
                of->settings = before;
                refuse(sceneTable(), setting, error, *of, of->misunderstood);
            }
            of->misunderstood.settle(setting);
        });
}

midair_status
midair_get(midair_scene* scene, const char* name, char* text, size_t size, size_t* needed)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            return get(
                sceneTable(), of->settings, textGiven(name, "name", 256), text, size, needed);
        });
}

midair_status
midair_object_set(midair_scene* scene, midair_object object, const char* name, const char* value)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const std::string property = textGiven(name, "name", 256);
            const std::string text = textGiven(value, "value", kMostText);
            const base::Lock lock(of->mutex);
            SceneObject& one = objectOf(*of, object);
            const bool isGiven =
                property == "pressure" || property == "unit" || property == "sampling";
            if (one.isPoints && isGiven)
                fail(MIDAIR_INVALID,
                     property + " of points can't be set: midair_add_points() fixes it");
            ObjectSettings changed = one.properties;
            const std::string error = assigned(objectTable(), changed, property, text);
            if (!error.empty()) refuse(objectTable(), property, error, *of, one.misunderstood);
            bridge::HapticProperties felt = forPipeline(changed);
            if (one.isPoints)
            {
                felt.pressure = one.felt.pressure;
                felt.pressureInPa = one.felt.pressureInPa;
                felt.sampling = one.felt.sampling;
            }
            one.felt = felt;
            one.properties = std::move(changed);
            one.misunderstood.settle(property);
        });
}

midair_status midair_object_get(midair_scene* scene,
                                midair_object object,
                                const char* name,
                                char* text,
                                size_t size,
                                size_t* needed)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            const SceneObject& one = objectOf(*of, object);
            return get(
                objectTable(), one.properties, textGiven(name, "name", 256), text, size, needed);
        });
}

midair_status
midair_setting(int32_t of_objects, size_t index, const char** name, const char** summary)
{
    return called(
        [&]
        {
            const auto& all = of_objects ? described(objectTable()) : described(sceneTable());
            if (index >= all.size())
                fail(MIDAIR_UNKNOWN, fmt::format("index is {}; there are {}", index, all.size()));
            if (name) *name = all[index].first.c_str();
            if (summary) *summary = all[index].second.c_str();
        });
}

midair_status midair_set_pose(midair_scene* scene, midair_object object, const double matrix[16])
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const Eigen::Isometry3d pose = poseOf(matrix);
            const base::Lock lock(of->mutex);
            objectOf(*of, object).pose = pose;
        });
}
