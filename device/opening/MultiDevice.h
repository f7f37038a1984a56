#pragma once

#include "device/ArrayDevice.h"
#include "device/JointCommit.h"

#include <mutex>

namespace midair::device
{

/// Several devices as one: boards of the array on different ports, or the array and a recorder.
///
/// A field goes to all of them one right after the other. Those that can stage it
/// (ArrayDevice::canStage()) are told to play it when the last of them has its piece; the others
/// play at once. The report says how far apart that was. One that is lost does not keep the others
/// from playing; send() is false when any of them refused.
class MultiDevice : public ArrayDevice
{
public:
    /// Which transducers a device has: from first, count of them.
    struct Part
    {
        std::unique_ptr<ArrayDevice> device;
        int first = 0;
        int count = 0;
    };

    MultiDevice(std::vector<Part> parts, int transducers);

    bool send(const DriveSignal& signal) override;
    void silence() override;
    void setMuted(bool muted) override;
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override; ///< the coarsest and slowest of all
    bool identify(int board, bool light) override;
    std::vector<std::complex<float>>
    played() const override; ///< of the first device that has the transducer
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    void measureSkew() const;
    static void cut(const DriveSignal& signal, const Part& part, DriveSignal& piece);
    template<typename Play>
    std::vector<std::complex<float>> join(Play&& play) const;

    std::vector<Part> _parts;
    const int _transducers;
    const int _staging;        ///< how many parts can
    mutable std::mutex _mutex; ///< one field at a time
    const std::shared_ptr<SkewMeter> _skew = std::make_shared<SkewMeter>();
    std::uint64_t _refused = 0;
    std::vector<DriveSignal> _cuts;
};

/// The devices of a list, cut at commas that a kind of device follows; one when there is no such
/// comma. Throws DeviceError for a list that is too long (DeviceUri.h).
std::vector<std::string> splitDeviceList(const std::string& text);

} // namespace midair::device
