#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/pipeline/SampleCache.h"
#include "haptics/points/ControlPoints.h"

#include <optional>
#include <vector>

namespace midair::bridge
{

/// Finds the places on a scene's surfaces over which a cycle's fields are evened out.
class FeltSurface
{
public:
    /// \a wavelength_m: > 0; also the spacing of objects that set none.
    explicit FeltSurface(double wavelength_m) : _wavelength_m(wavelength_m) {}

    /// Once \a stop is requested, places() throws base::Stopped.
    void setStop(const base::StopToken& stop);

    /// Returns the places of \a objects near \a points, the control points that are played, with
    /// the targets of the nearest: at the first of haptics::kPlaceSpacings that gives at most
    /// haptics::kMostPlaces; nothing if none does.
    std::optional<haptics::ControlPoints> places(const std::vector<HapticObject>& objects,
                                                 const haptics::ControlPoints& points);

private:
    std::optional<haptics::ControlPoints> placesOf(const std::vector<HapticObject>& objects,
                                                   const haptics::ControlPoints& points,
                                                   double spacing_m);

    double _wavelength_m;
    base::StopToken _stop;
    SampleCache _samples;
};

} // namespace midair::bridge
