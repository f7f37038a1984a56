#include "haptics/sensation/Sensation.h"

#include "haptics/base/InputError.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::haptics
{

std::size_t Sensation::parameterIndex(const std::string& wanted) const
{
    const auto found =
        std::find_if(parameters.begin(),
                     parameters.end(),
                     [&](const SensationParameter& one) { return one.name == wanted; });
    return static_cast<std::size_t>(found - parameters.begin());
}

std::size_t Sensation::usedParameter(const std::string& wanted)
{
    const std::size_t index = parameterIndex(wanted);
    if (index == parameters.size())
    {
        if (index == kMostParameters)
            throw base::InputError(
                fmt::format("is one parameter too many; at most {} are possible", kMostParameters));
        SensationParameter used;
        used.name = wanted;
        used.isDefined = false;
        parameters.push_back(used);
    }
    return index;
}

} // namespace midair::haptics
