#pragma once

#include "device/ArrayDevice.h"
#include "device/recording/RecordingFile.h"
#include "haptics/base/threads/Mutex.h"

#include <string>
#include <thread>
#include <vector>

namespace midair::device
{

/// `play:FILE?to=DEVICE`: plays a recording on another device at the recorded times, in its own
/// thread. Refuses all fields. At the end of the file, or where it breaks off, it silences the
/// device. Its fields are not signs of life: if that device has a hold, the program that plays the
/// recording must call keepAlive().
class PlayingDevice : public ArrayDevice
{
public:
    /// Playback options.
    struct Options
    {
        double speed = 1;  ///< > 0; factor on the recorded speed
        bool loop = false; ///< start again at the end
        /// transducers that are never driven, whatever the recording contains; unknown ones are
        /// ignored
        std::vector<int> dead = {};
    };

    PlayingDevice(recording::Show show,
                  const Options& options,
                  std::unique_ptr<ArrayDevice> device);
    ~PlayingDevice() override;

    PlayingDevice(const PlayingDevice&) = delete;
    PlayingDevice& operator=(const PlayingDevice&) = delete;

    bool send(const DriveSignal&) override { return false; }
    void silence() override; ///< ends playing
    void setMuted(bool muted) override
    {
        _device->setMuted(muted);
    } ///< playback continues
      ///< silently
    bool setAmplitudeCap(double amplitude) override { return _device->setAmplitudeCap(amplitude); }
    void keepAlive() override { _device->keepAlive(); }
    void follow(const std::shared_ptr<Lead>& lead) override { _device->follow(lead); }
    bool isHoldOver() const override { return _device->isHoldOver(); }
    double confirmed_s() const override { return _device->confirmed_s(); }
    std::string status() const override;
    /// The other device's report; LOST, with one more fault, if the file is damaged. A file
    /// truncated by a kill is played as far as it goes, without a fault.
    DeviceReport report() const override;
    DriveAbility ability() const override; ///< of the other device, without sequences
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

    bool finished() const;      ///< true if playing has ended
    std::string ending() const; ///< reason if the file ended without its end mark; otherwise empty
    double worstLateness_s() const; ///< longest delay of an entry after its recorded time

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
    bool _isDamaged MIDAIR_GUARDED_BY(_mutex) = false;
    std::thread _thread;
};

} // namespace midair::device
