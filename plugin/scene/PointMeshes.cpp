#include "plugin/scene/PointMeshes.h"

#include "engine-bridge/scene/Convert.h"
#include "haptics/surface/PointGrid.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using midair::base::MessageCode;

constexpr std::uint64_t kKeptFrames = 60;
constexpr double kLeastPressure = 1e-6; ///< as of HapticProperty::pressure
constexpr double kMostPressure = 1e5;
/// Points closer than this coincide and are merged.
constexpr double kSamePlace_m = 1e-6;
constexpr double kFarthest_m = 1e3; ///< nothing farther away is played

bool isPressure(double pressure)
{
    return pressure == 0.0 || (pressure >= kLeastPressure && pressure <= kMostPressure);
}

/// Points of a node that are left out for one reason.
struct LeftOut
{
    std::size_t count = 0;
    std::size_t first = 0;

    void add(std::size_t i)
    {
        if (count++ == 0) first = i;
    }
};

/// Adds one message for each reason, however many points there are.
void tellLeftOut(const HapticPoints& node,
                 const LeftOut& notFinite,
                 const LeftOut& noPressure,
                 std::vector<std::string>& told)
{
    const std::size_t points = node.getPoints().size();
    if (notFinite.count > 0)
        told.push_back(
            fmt::format("{} of {} points are not finite and left out, the first is point {}",
                        notFinite.count,
                        points,
                        notFinite.first));
    if (noPressure.count > 0)
        told.push_back(fmt::format(
            "{} of {} points have invalid pressures and are left out; the first, of point "
            "{}, is {:g}, should be 0 or {:g} .. {:g}",
            noPressure.count,
            points,
            noPressure.first,
            node.getPressures()[noPressure.first],
            kLeastPressure,
            kMostPressure));
}

/// Returns the indices of the usable points; \a told gets messages about the others.
std::vector<std::size_t> usablePoints(const HapticPoints& node, std::vector<std::string>& told)
{
    std::vector<std::size_t> usable;
    LeftOut notFinite;
    LeftOut noPressure;
    for (std::size_t i = 0; i < node.getPoints().size(); ++i)
        if (!node.getPoints()[i].valid() || !std::isfinite(node.getPoints()[i].length2()))
            notFinite.add(i);
        else if (!node.getPressures().empty() && !isPressure(node.getPressures()[i]))
            noPressure.add(i);
        else
            usable.push_back(i);
    tellLeftOut(node, notFinite, noPressure, told);
    return usable;
}

/// Returns the points \a usable as a mesh of degenerate triangles; \a pressure: of the strongest.
midair::haptics::TriangleMesh meshOf(const HapticPoints& node,
                                     const std::vector<std::size_t>& usable,
                                     const Eigen::Matrix3d& stretch,
                                     double& pressure)
{
    const auto count = static_cast<Eigen::Index>(usable.size());
    midair::haptics::TriangleMesh mesh;
    mesh.vertices.resize(3, count);
    mesh.triangles.resize(3, count);
    for (const std::size_t i : usable)
        if (!node.getPressures().empty()) pressure = std::max(pressure, node.getPressures()[i]);
    if (!node.getPressures().empty()) mesh.intensity.setZero(count);
    for (Eigen::Index k = 0; k < count; ++k)
    {
        const std::size_t i = usable[static_cast<std::size_t>(k)];
        mesh.vertices.col(k) = stretch * midair::bridge::toEigen(node.getPoints()[i]);
        mesh.triangles.col(k).setConstant(static_cast<int>(k));
        if (pressure > 0.0)
            mesh.intensity[k] = static_cast<float>(node.getPressures()[i] / pressure);
    }
    return mesh;
}

/// Moves points that coincide with an earlier one exactly onto it and returns messages about them:
/// of coinciding points only the first counts. \a usable: the node's points that the vertices of \a
/// mesh stand for.
std::vector<std::string> joinCoinciding(const HapticPoints& node,
                                        const std::vector<std::size_t>& usable,
                                        midair::haptics::TriangleMesh& mesh)
{
    LeftOut coinciding;
    std::vector<std::size_t> firsts; // the point at each position
    std::size_t first = 0;           // the one that the first coinciding point joins
    midair::haptics::PointGrid places(kSamePlace_m);
    places.reserve(usable.size());
    for (Eigen::Index k = 0; k < mesh.vertices.cols(); ++k)
    {
        const Eigen::Vector3d place = mesh.vertices.col(k);
        const bool isFelt = mesh.intensity.size() == 0 || mesh.intensity[k] > 0.0F;
        if (!isFelt || !(place.cwiseAbs().maxCoeff() < kFarthest_m)) continue;
        const int near = places.nearest(place, kSamePlace_m);
        if (near < 0)
        {
            places.insert(place);
            firsts.push_back(usable[static_cast<std::size_t>(k)]);
            continue;
        }
        mesh.vertices.col(k) = places[near];
        if (coinciding.count == 0) first = firsts[static_cast<std::size_t>(near)];
        coinciding.add(usable[static_cast<std::size_t>(k)]);
    }
    if (coinciding.count == 0) return {};
    return {fmt::format("{} of {} points coincide with another and are merged into it; the first "
                        "of them is point {}, which coincides with "
                        "point {}",
                        coinciding.count,
                        node.getPoints().size(),
                        coinciding.first,
                        first)};
}

} // namespace

const PointMesh*
PointMeshes::get(const HapticPoints& node, const Eigen::Matrix4d& toArray, const Say& say)
{
    midair::bridge::PoseAndStretch placed;
    if (!midair::bridge::decompose(toArray, placed))
    {
        say(MessageCode::OBJECT_INVALID,
            "its matrix is singular, not finite or a perspective; it can't be felt");
        return nullptr;
    }
    const auto same = [&](const Entry& entry) {
        return entry.points == node.getModifiedCount() &&
               entry.stretch.isApprox(placed.stretch, 1e-6);
    };
    auto found = std::find_if(_entries.begin(), _entries.end(), same);
    if (found == _entries.end())
    {
        if (!node.getPressures().empty() && node.getPressures().size() != node.getPoints().size())
        {
            say(MessageCode::OBJECT_INVALID,
                fmt::format("has {} pressures for {} points; it can't be felt",
                            node.getPressures().size(),
                            node.getPoints().size()));
            return nullptr;
        }
        Entry entry;
        const std::vector<std::size_t> usable = usablePoints(node, entry.made.leftOut);
        if (usable.empty())
        {
            for (const std::string& what : entry.made.leftOut)
                say(MessageCode::POINTS_INVALID, what);
            say(MessageCode::OBJECT_INVALID,
                node.getPoints().empty() ? "has no points; it can't be felt"
                                         : "none of its points can be used; it can't be felt");
            return nullptr;
        }
        entry.points = node.getModifiedCount();
        entry.stretch = placed.stretch;
        entry.made.mesh.meshId = _nextId++;
        midair::haptics::TriangleMesh mesh =
            meshOf(node, usable, placed.stretch, entry.made.pressure);
        for (std::string& what : joinCoinciding(node, usable, mesh))
            entry.made.leftOut.push_back(std::move(what));
        entry.made.mesh.mesh =
            std::make_shared<const midair::haptics::TriangleMesh>(std::move(mesh));
        _entries.push_back(std::move(entry));
        found = std::prev(_entries.end());
    }
    for (const std::string& what : found->made.leftOut)
        say(MessageCode::POINTS_INVALID, what);
    found->used = _frame;
    found->made.mesh.pose = placed.pose;
    return &found->made;
}

void PointMeshes::endFrame()
{
    ++_frame;
    // A caller that keeps a mesh doesn't necessarily ask for it again.
    const auto old = [this](const Entry& entry)
    { return _frame - entry.used > kKeptFrames && entry.made.mesh.mesh.useCount() == 1; };
    if (_frame % kKeptFrames == 0)
        _entries.erase(std::remove_if(_entries.begin(), _entries.end(), old), _entries.end());
}

} // namespace osgMidair
