#pragma once

#include "device/ArrayDevice.h"
#include "device/JointCommit.h"
#include "haptics/base/threads/Mutex.h"

namespace midair::device
{

/// Combines several devices into one: boards of the array on different ports, or the array and a
/// recording.
///
/// A field goes to all of them, one right after the other. Devices that can stage it
/// (ArrayDevice::canStage()) play it when the last of them has its part; the others play at once.
/// The report's skew_s is the time between them. A lost device doesn't keep the others from
/// playing; send() returns false if any of them refused.
class MultiDevice : public ArrayDevice
{
public:
    /// A device and its transducers: count of them, from first on.
    struct Part
    {
        std::unique_ptr<ArrayDevice> device;
        int first = 0;
        int count = 0;
    };

    MultiDevice(std::vector<Part> parts, int transducers);

    bool send(const DriveSignal& signal) override
    {
        keepAlive();
        return sendUnled(signal);
    }
    bool sendUnled(const DriveSignal& signal) override;
    void silence() override;
    void setMuted(bool muted) override;
    bool setAmplitudeCap(double amplitude) override;
    void keepAlive() override;
    void follow(const std::shared_ptr<Lead>& lead) override; ///< the same lead for all
    bool isHoldOver() const override;                        ///< of any device
    double confirmed_s() const override;                     ///< by all devices
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override; ///< of the coarsest and slowest; no sequences
    bool identify(int board, bool light) override;
    /// for each transducer, of the first device that has it
    std::vector<std::complex<float>> played() const override;
    /// likewise; empty if one of these devices isn't simulated
    std::vector<PlayedField> playedSince(double from_s) const override;
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    void measureSkew() const MIDAIR_REQUIRES(_mutex);
    static void cut(const DriveSignal& signal, const Part& part, DriveSignal& piece);
    template<typename Play>
    std::vector<std::complex<float>> join(Play&& play) const;

    const std::vector<Part> _parts; ///< devices take calls from any thread
    const int _transducers;
    const int _staging; ///< number of parts that can stage
    const std::shared_ptr<SkewMeter> _skew = std::make_shared<SkewMeter>();
    mutable base::Mutex _mutex; ///< held by send(): one field at a time
    std::uint64_t _refused MIDAIR_GUARDED_BY(_mutex) = 0;
    std::vector<DriveSignal> _cuts MIDAIR_GUARDED_BY(_mutex);
};

/// Splits a list of URIs at commas followed by letters and a colon; otherwise the text is one URI.
/// Throws DeviceError for a list that is too long (DeviceUri.h).
std::vector<std::string> splitDeviceList(const std::string& text);

/// Returns the same devices with recordings set to continue, for reopening. Throws DeviceError for
/// an invalid URI.
std::string continuedRecordings(const std::string& uri);

} // namespace midair::device
