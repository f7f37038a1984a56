#include "haptics/sensation/SensationValues.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

double withinRange(const SensationParameter& parameter, double value)
{
    if (parameter.low) value = std::max(value, *parameter.low);
    if (parameter.high) value = std::min(value, *parameter.high);
    return value;
}

} // namespace

SensationValues::SensationValues(const Sensation& sensation) : _parameters(sensation.parameters)
{
    for (const SensationParameter& parameter : _parameters)
    {
        _values.push_back(withinRange(parameter, parameter.standard));
        _isKnown.push_back(parameter.isDefined);
    }
}

std::vector<std::string> SensationValues::names() const
{
    std::vector<std::string> names;
    for (const SensationParameter& parameter : _parameters)
        names.push_back(parameter.name);
    return names;
}

bool SensationValues::set(const std::string& name, double value)
{
    if (std::isnan(value)) return false;
    for (std::size_t index = 0; index < _parameters.size(); ++index)
        if (_parameters[index].name == name)
        {
            _values[index] = withinRange(_parameters[index], value);
            _isKnown[index] = true;
            return true;
        }
    return false;
}

} // namespace midair::haptics
