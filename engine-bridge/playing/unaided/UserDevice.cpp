#include "engine-bridge/playing/unaided/UserDevice.h"

#include "device/limits/GuardedDevice.h"
#include "device/limits/UserLimits.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/base/Limits.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using device::DriveSignal;

/// Forwards fields to a device, lowered to an ear limit.
class HeldToEars : public device::ArrayDevice
{
public:
    HeldToEars(std::unique_ptr<device::ArrayDevice> device,
               const haptics::TransducerArray& array,
               double limit_dB,
               const Eigen::Matrix3Xd& places) :
        _device(std::move(device)),
        _array(array)
    {
        _ears.setPlace(_array, _medium, places);
        _ears.setLimit(limit_dB);
    }

    bool send(const DriveSignal& signal) override
    {
        keepAlive();
        return sendUnled(signal);
    }
    bool sendUnled(const DriveSignal& signal) override
    {
        const base::Lock lock(_mutex);
        DriveSignal held = signal;
        const double factor = hold(held);
        _factor = std::min(_factor, factor);
        if (factor > 0.0) return _device->sendUnled(held);
        ++_refused;
        _device->silence();
        return false;
    }
    void silence() override { _device->silence(); }
    void setMuted(bool muted) override { _device->setMuted(muted); }
    // Sounding levels might be rounded to levels for which no factor was computed.
    bool setAmplitudeCap(double amplitude) override
    {
        _device->silence();
        return _device->setAmplitudeCap(amplitude);
    }
    std::string status() const override
    {
        const base::Lock lock(_mutex);
        std::string text = _device->status();
        if (_factor < 1.0)
            text += fmt::format("; held down to the ear limit of {:g} dB, at the least to {:.3g} "
                                "of the drive",
                                _ears.limit_dB(),
                                _factor);
        return text;
    }
    device::DeviceReport report() const override
    {
        device::DeviceReport report = _device->report();
        const base::Lock lock(_mutex);
        report.sent += _refused;
        report.refused += _refused;
        if (_refused > 0 && report.message.empty())
            report.message = fmt::format("{} fields were refused: every level of the device "
                                         "exceeds the ear limit of {:g} dB",
                                         _refused,
                                         _ears.limit_dB());
        return report;
    }
    device::DriveAbility ability() const override
    {
        device::DriveAbility ability = _device->ability();
        ability.sequenceFields = 0;
        return ability;
    }
    bool identify(int board, bool light) override { return _device->identify(board, light); }
    std::vector<std::complex<float>> played() const override { return _device->played(); }
    std::vector<device::PlayedField> playedSince(double from_s) const override
    {
        return _device->playedSince(from_s);
    }
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override
    {
        const base::Lock lock(_mutex);
        DriveSignal held = signal;
        hold(held);
        return _device->wouldPlay(held);
    }
    void keepAlive() override { _device->keepAlive(); }
    void follow(const std::shared_ptr<device::Lead>& lead) override { _device->follow(lead); }
    bool isHoldOver() const override { return _device->isHoldOver(); }
    double confirmed_s() const override { return _device->confirmed_s(); }

private:
    /// Lowers \a signal to the limit; returns the factor, 0 for silence.
    double hold(DriveSignal& signal) const MIDAIR_REQUIRES(_mutex)
    {
        // The device refuses anything but fields of the array.
        if (signal.size() != _array.size()) return 1.0;
        const Eigen::Matrix3Xd nowhere(3, 0);
        CappedPlaces where{nowhere, {&_array}, _medium};
        where.ears = _ears.bound();
        const auto play = [this](const DriveSignal& drive)
        {
            const std::vector<std::complex<float>> q = _device->wouldPlay(drive);
            return Eigen::VectorXcf(
                Eigen::Map<const Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size())));
        };
        return PressureCap(base::kMostPressure_Pa, play, _device->ability())
            .hold(where, signal)
            .factor;
    }

    const std::unique_ptr<device::ArrayDevice> _device;
    const haptics::TransducerArray _array;
    const haptics::Medium _medium;
    mutable base::Mutex _mutex;
    mutable EarWatch _ears MIDAIR_GUARDED_BY(_mutex);
    double _factor MIDAIR_GUARDED_BY(_mutex) = 1.0; ///< smallest so far
    std::uint64_t _refused MIDAIR_GUARDED_BY(_mutex) = 0;
};

} // namespace

std::unique_ptr<device::ArrayDevice> openForUser(const std::string& uri,
                                                 const device::DeviceLayout& layout,
                                                 const haptics::TransducerArray* array,
                                                 const device::SafetyLimits& limits,
                                                 const std::string& owner)
{
    const device::UserCaps caps = device::capsOfUser();
    if (!caps.wrong.empty()) throw device::DeviceError(caps.wrong.front());
    if (caps.isSilencing) throw device::DeviceError(device::kDisabledByUser);
    const auto refuse = [&](const char* why)
    {
        throw device::DeviceError(fmt::format("device \"{}\": the ear limit of {:g} dB can't be "
                                              "held, because {}; nothing is played",
                                              uri,
                                              caps.earLimit_dB,
                                              why));
    };
    if (caps.earLimit_dB > 0.0 && device::playsByItself(uri))
        refuse("it plays by itself: \"midair-device play\" enforces it");
    if (caps.earLimit_dB > 0.0 && (!array || array->size() != layout.transducers))
        refuse("the positions of the transducers are unknown");
    device::SafetyLimits all = limits;
    all.maxAmplitude = std::min(limits.maxAmplitude, caps.maxAmplitude);
    all.maxPressure_Pa = device::stricterCap(limits.maxPressure_Pa, caps.maxPressure_Pa);
    auto device = device::openLimitedDevice(uri, layout, all, owner);
    if (!(caps.earLimit_dB > 0.0)) return device;
    Eigen::Matrix3Xd places(3, 0);
    readPlaces(caps.earPoints, places); // checked by device::capsOfUser()
    return std::make_unique<HeldToEars>(std::move(device), *array, caps.earLimit_dB, places);
}

} // namespace midair::bridge
