#pragma once

#include "device/ArrayDevice.h"
#include "device/recording/RecordingFile.h"
#include "haptics/base/threads/Mutex.h"

#include <string>
#include <thread>
#include <vector>

namespace midair::device
{

/// `play:FILE?to=DEVICE`: plays a recording on another device at the recorded times, in a thread of
/// its own. Refuses all fields that are sent to it. At the end of the file, or where it breaks off,
/// it silences the device. Its fields are no signs of life: where that device has a hold, whoever
/// plays the recording has to give them (keepAlive()).
class PlayingDevice : public ArrayDevice
{
public:
    /// How the recording is played.
    struct Options
    {
        double speed = 1;  ///< > 0; factor on the recorded speed
        bool loop = false; ///< start again at the end
        /// transducers that are never driven, whatever the recording says; others than the array's
        /// don't count
        std::vector<int> dead = {};
    };

    PlayingDevice(recording::Show show,
                  const Options& options,
                  std::unique_ptr<ArrayDevice> device);
    ~PlayingDevice() override;

    PlayingDevice(const PlayingDevice&) = delete;
    PlayingDevice& operator=(const PlayingDevice&) = delete;

    bool send(const DriveSignal&) override { return false; }
    void silence() override;                                         ///< ends playing
    void setMuted(bool muted) override { _device->setMuted(muted); } ///< playing goes on, silently
    bool setAmplitudeCap(double amplitude) override { return _device->setAmplitudeCap(amplitude); }
    void keepAlive() override { _device->keepAlive(); }
    void follow(const std::shared_ptr<Lead>& lead) override { _device->follow(lead); }
    bool isHoldOver() const override { return _device->isHoldOver(); }
    double confirmed_s() const override { return _device->confirmed_s(); }
    std::string status() const override;
    /// The other device's report; LOST, with one more fault, if the file broke off or was damaged.
    DeviceReport report() const override;
    DriveAbility ability() const override; ///< the other device's, but with no sequences
    bool identify(int board, bool light) override { return _device->identify(board, light); }
    std::vector<std::complex<float>> played() const override { return _device->played(); }
    std::vector<PlayedField> playedSince(double from_s) const override
    {
        return _device->playedSince(from_s);
    }
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override
    {
        return _device->wouldPlay(signal);
    }

    bool finished() const;          ///< true if playing has ended
    std::string ending() const;     ///< what is wrong with the file; empty: nothing so far
    double worstLateness_s() const; ///< the longest delay of an entry against its recorded time

private:
    void run();
    void leaveOutDead(DriveSignal& signal) const;
    /// Returns false after silence() or in the destructor.
    bool playOnce(base::Lock& lock) MIDAIR_REQUIRES(_mutex);

    const recording::Show _show;
    const Options _options;
    const std::unique_ptr<ArrayDevice> _device;
    mutable base::Mutex _mutex;
    base::Condition _wake;
    bool _stop MIDAIR_GUARDED_BY(_mutex) = false;
    bool _finished MIDAIR_GUARDED_BY(_mutex) = false;
    std::uint64_t _fields MIDAIR_GUARDED_BY(_mutex) = 0;
    double _time_s MIDAIR_GUARDED_BY(_mutex) = 0;
    double _worstLateness_s MIDAIR_GUARDED_BY(_mutex) = 0;
    std::string _ending MIDAIR_GUARDED_BY(_mutex);
    std::thread _thread;
};

} // namespace midair::device
