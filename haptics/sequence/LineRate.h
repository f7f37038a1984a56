#pragma once

#include "haptics/sequence/Modulator.h"

#include <string>

namespace midair::haptics
{

/// Knows how many fields the line to a device carries, for fields in turn and for modulation.
///
/// A modulation is sampled where a field is sent: Modulator's cosine needs four fields a period,
/// which hold its half height besides its top and its bottom; an array whose emitters are on or off
/// needs two. On a line that is slower than the field rate asked for, a modulation gets the largest
/// multiple of its frequency that fits, since any other rate beats with it.
class LineRate
{
public:
    LineRate() = default; ///< carries everything
    /// \a fieldsPerSecond >= 0; 0: any number. \a onOff: emitters have no amplitudes between off
    /// and full.
    LineRate(double fieldsPerSecond, bool onOff) :
        _carried(fieldsPerSecond),
        _aPeriod(onOff ? 2 : 4)
    {
    }

    /// Lowers \a modulation's field rate to what the line carries, for a modulation of \a
    /// frequency_Hz (0: none). Throws base::InputError where it doesn't carry that.
    void fit(ModulatorOptions& modulation, double frequency_Hz) const;

    bool isSlowerThan(double fieldRate_Hz) const
    {
        return _carried > 0.0 && fieldRate_Hz > _carried;
    }
    /// The message where fields in turn follow each other as \a played and not as \a asked for.
    std::string message(const ModulatorOptions& played, const ModulatorOptions& asked) const;

private:
    double _carried = 0.0; // fields a second; 0: any number
    int _aPeriod = 4;
};

} // namespace midair::haptics
