#pragma once

#include "haptics/sensation/Sensation.h"

#include <cstddef>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Values of a pattern's parameters, each within its range. At first the pattern's own.
class SensationValues
{
public:
    explicit SensationValues(const Sensation& sensation);

    /// Sets a parameter, limited to its range. Returns false, and changes nothing, if the pattern
    /// neither defines nor uses \a name, or if \a value is NaN.
    bool set(const std::string& name, double value);

    /// Returns the names of the parameters, in their order.
    std::vector<std::string> names() const;
    /// Returns the value of a parameter; 0 if the pattern doesn't define it and it isn't set.
    double operator[](std::size_t index) const { return _values[index]; }
    bool isKnown(std::size_t index) const { return _isKnown[index]; }

private:
    std::vector<SensationParameter> _parameters;
    std::vector<double> _values;
    std::vector<bool> _isKnown; ///< defined, or set
};

} // namespace midair::haptics
