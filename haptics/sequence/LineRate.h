#pragma once

#include "haptics/sequence/Modulator.h"

#include <string>

namespace midair::haptics
{

/// Limits field rates to what the line to a device carries, for fields in turn and for modulation.
///
/// Each field sent is a sample of the modulation. Modulator's cosine needs four fields per period:
/// its top, its bottom and twice its half height; an array whose emitters are only on or off needs
/// two. If the line is slower than the requested field rate, the rate becomes the largest multiple
/// of the modulation's frequency that fits, since other rates would beat with it.
///
/// A device that stores the fields of a period and times them by itself needs its line for none of
/// them: where the line is too slow, the rate is one that fits the store and the device's clock.
class LineRate
{
public:
    LineRate() = default; ///< no limit
    /// \a fieldsPerSecond >= 0; 0: no limit. \a onOff: emitters have no amplitudes between off and
    /// full. \a stored: the most fields that the device times by itself, 0: none, at rates of \a
    /// clock_Hz over a whole number, 0: any.
    LineRate(double fieldsPerSecond, bool onOff, int stored = 0, double clock_Hz = 0.0) :
        _carried(fieldsPerSecond),
        _aPeriod(onOff ? 2 : 4),
        _stored(stored),
        _clock_Hz(clock_Hz)
    {
    }

    /// Lowers the field rate of \a modulation to what the line carries, for a modulation of \a
    /// frequency_Hz (0: none) of \a fields that follow each other. Throws base::InputError if the
    /// line is too slow for it. Returns the frequency that is played: the nearest one that the
    /// device's clock has.
    double fit(ModulatorOptions& modulation, double frequency_Hz, int fields = 1) const;

    bool isSlowerThan(double fieldRate_Hz) const
    {
        return _carried > 0.0 && fieldRate_Hz > _carried;
    }
    /// Returns the message for fields that follow each other at the rate of \a played instead of \a
    /// asked.
    std::string message(const ModulatorOptions& played, const ModulatorOptions& asked) const;

private:
    double store(ModulatorOptions& modulation, double frequency_Hz, int fields) const;

    double _carried = 0.0; // fields per second; 0: no limit
    int _aPeriod = 4;
    int _stored = 0;
    double _clock_Hz = 0.0;
};

} // namespace midair::haptics
