#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"

#include <osgMidair/FoundObject>
#include <osgMidair/HapticSettings>

#include <osg/Node>

#include <complex>
#include <string>
#include <vector>

namespace osgMidair
{

/// The device of a FieldBaker's pipeline: takes every field at once and plays nothing. What is
/// played is read from the pipeline's results.
class BakingDevice : public midair::device::ArrayDevice
{
public:
    explicit BakingDevice(int transducers);

    bool send(const midair::device::DriveSignal& signal) override;
    bool sendSequence(const midair::device::DriveSequence& sequence) override;
    void silence() override { _held.clear(); }
    std::string status() const override { return "baked into a recording"; }
    midair::device::DeviceReport report() const override { return _counters.report(); }
    midair::device::DriveAbility ability() const override;
    std::vector<std::complex<float>> played() const override { return _held.activations(); }

private:
    midair::device::HeldField _held;
    midair::device::FieldCounters _counters;
};

/// What a device would limit, by its URI.
struct BakedLimits
{
    midair::device::SafetyLimits limits; ///< those that hold in a recording: maxima
    /// Sentences on those that a device keeps itself, since they go by time.
    std::vector<std::string> unkept;
};

/// Reads the limits from \a uri, or of several with commas in between: the strictest. Throws
/// midair::device::DeviceError for what isn't understood.
BakedLimits limitsOfDevice(const std::string& uri);

/// Returns sentences on what of \a scene goes by the wall's clock or by who is there, so that it
/// can't be known beforehand. \a settings: as they are played. \a hasOwnHands: the program has set
/// a source of hands.
std::vector<std::string> unbakeable(osg::Node& scene,
                                    const HapticSettings& settings,
                                    const std::vector<FoundObject>& found,
                                    bool hasOwnHands);

} // namespace osgMidair
