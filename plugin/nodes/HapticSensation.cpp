#include "engine-bridge/sensations/SensationTexts.h"
#include "haptics/base/text/Number.h"

#include <osgMidair/HapticSensation>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace osgMidair
{

HapticSensation::HapticSensation() = default;

HapticSensation::HapticSensation(const std::string& sensation)
{
    setSensation(sensation);
}

HapticSensation::HapticSensation(const HapticSensation& other, const osg::CopyOp& copyop) :
    HapticSurface(other, copyop),
    _lastPlays(other._lastPlays)
{
}

HapticSensation::~HapticSensation() = default;

void HapticSensation::play()
{
    _lastPlays = midair::bridge::nextPlays(_lastPlays, getPlays());
    setPlays(_lastPlays);
}

void HapticSensation::stop()
{
    _lastPlays = std::max(_lastPlays, getPlays());
    setPlays(0);
}

void HapticSensation::setParameter(const std::string& name, double value)
{
    if (!std::isfinite(value)) return;
    std::vector<std::pair<std::string, double>> values;
    midair::bridge::readParameters(getParameters(), values);
    const auto known = std::find_if(
        values.begin(), values.end(), [&name](const auto& one) { return one.first == name; });
    if (known != values.end())
        known->second = value;
    else
        values.emplace_back(name, value);
    setParameters(midair::bridge::parametersText(values));
}

} // namespace osgMidair
