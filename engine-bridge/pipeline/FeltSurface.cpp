#include "engine-bridge/pipeline/FeltSurface.h"

#include "haptics/points/ControlPoints.h"

#include <algorithm>

namespace midair::bridge
{

void FeltSurface::setStop(const base::StopToken& stop)
{
    _stop = stop;
    _samples.setStop(stop);
}

std::optional<haptics::ControlPoints> FeltSurface::places(const std::vector<HapticObject>& objects,
                                                          const haptics::ControlPoints& points)
{
    std::optional<haptics::ControlPoints> found;
    for (const double spacing : haptics::kPlaceSpacings)
    {
        found = placesOf(objects, points, spacing * _wavelength_m);
        if (found) break;
    }
    _samples.endSnapshot();
    return found;
}

namespace
{

haptics::ControlPoints ownPoints(const haptics::ControlPoints& points, std::size_t object)
{
    std::vector<int> own;
    for (std::size_t l = 0; l < points.object.size(); ++l)
        if (points.object[l] == static_cast<int>(object)) own.push_back(static_cast<int>(l));
    return haptics::pick(points, own);
}

/// Those of \a places (mesh frame) that no plane clips, in the array frame.
Eigen::Matrix3Xd unclipped(const HapticObject& object, const Eigen::Matrix3Xd& places)
{
    Eigen::Matrix3Xd all = object.pose * places;
    Eigen::Index kept = 0;
    for (Eigen::Index i = 0; i < all.cols(); ++i)
        if (!isClipped(object.clips, all.col(i))) all.col(kept++) = all.col(i);
    all.conservativeResize(3, kept);
    return all;
}

} // namespace

std::optional<haptics::ControlPoints>
FeltSurface::placesOf(const std::vector<HapticObject>& objects,
                      const haptics::ControlPoints& points,
                      double spacing_m)
{
    haptics::ControlPoints all;
    for (std::size_t i = 0; i < objects.size(); ++i)
    {
        const HapticObject& object = objects[i];
        const haptics::ControlPoints own = ownPoints(points, i);
        if (own.size() == 0 || !object.mesh) continue;
        const CachedSamples& cached = _samples.get(object, spacing_m);
        // It could be sampled for its points, so these samples are too many.
        if (cached.sets.empty()) return std::nullopt;
        const double pointSpacing_m =
            object.properties.spacing_m > 0.0 ? object.properties.spacing_m : _wavelength_m;
        const haptics::ControlPoints places =
            haptics::feltPlaces(unclipped(object, cached.sets.front().positions),
                                own,
                                haptics::kFeltReach * std::max(pointSpacing_m, spacing_m),
                                _stop);
        if (all.size() + places.size() > haptics::kMostPlaces) return std::nullopt;
        if (all.size() == 0)
            all = places;
        else
            append(all, places);
    }
    return all;
}

} // namespace midair::bridge
