#pragma once

#include <osgMidair/FoundObject>
#include <osgMidair/HapticSettings>

#include <osg/Node>

#include <string>
#include <vector>

namespace osgMidair
{

/// Returns sentences on what of \a scene goes by the wall's clock or by who is there, so that it
/// can't be known beforehand. \a settings: as they are played. \a hasOwnHands: the program has set
/// a source of hands.
std::vector<std::string> unbakeable(osg::Node& scene,
                                    const HapticSettings& settings,
                                    const std::vector<FoundObject>& found,
                                    bool hasOwnHands);

} // namespace osgMidair
