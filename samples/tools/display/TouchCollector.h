#pragma once

#include "engine-bridge/calibration/StillTip.h"

#include <osgMidair/HandSource>
#include <osgMidair/HeadSource>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace midair::samples
{

/// Sources of fingertips and heads.
struct TouchSources
{
    std::string hands;        ///< a hand source
    std::string heads;        ///< a head source; empty: none
    double hold_s = 1.0;      ///< how long a fingertip is held still
    bool isRehearsal = false; ///< time is a recording's; runs as fast as possible
};

/// Collects the positions of an index fingertip held still, one for each requested touch.
class TouchCollector
{
public:
    /// Opens the sources. Throws base::InputError.
    explicit TouchCollector(const TouchSources& sources);

    /// Calls \a ask with the number of the next touch, and \a frame at each step, until there are
    /// \a count touches. Throws base::InputError if the hands end early, the program is stopped or
    /// \a frame returns false.
    std::vector<bridge::StillTip::Sample>
    collect(int count, const std::function<void(int)>& ask, const std::function<bool()>& frame);

private:
    std::optional<bridge::StillTip::Sample> sampleAt(double time_s);

    TouchSources _sources;
    osg::ref_ptr<osgMidair::HandSource> _hands;
    osg::ref_ptr<osgMidair::HeadSource> _heads;
};

} // namespace midair::samples
