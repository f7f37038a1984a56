#pragma once

#include "haptics/sensation/SensationSample.h"
#include "haptics/sensation/SensationValues.h"

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace midair::samples
{

/// A parameter that is set at a time.
struct SetParameter
{
    double time_ms = 0.0;
    std::string name;
    double value = 0.0;
};

/// Reads a CSV file with the header t_ms,name,value; times must ascend. Throws InputError with the
/// line.
std::vector<SetParameter> readSetParameters(const std::string& path);

/// Sets those of \a all that are due at \a time_ms, from the index \a next on, which moves on.
/// Throws InputError for a name that the pattern neither defines nor uses.
void setDue(const std::vector<SetParameter>& all,
            double time_ms,
            std::size_t& next,
            haptics::SensationValues& values);

/// A sample and its time.
struct TimedSample
{
    double time_ms = 0.0;
    haptics::SensationSample sample;
};

/// Writes samples as CSV: t_ms, x_mm, y_mm, z_mm, intensity, pattern_time_ms, stop (0 or 1).
void writeSamples(std::ostream& out, const std::vector<TimedSample>& samples);

} // namespace midair::samples
