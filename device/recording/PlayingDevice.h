#pragma once

#include "device/ArrayDevice.h"
#include "device/recording/RecordingFile.h"

#include <condition_variable>
#include <mutex>
#include <thread>

namespace midair::device
{

/// `play:FILE?to=DEVICE`: plays a recording on another device at the recorded times, in a thread of
/// its own. Fields that are sent meanwhile are refused: the recording is the show. At the end, or
/// where the file breaks off, the device falls silent.
class PlayingDevice : public ArrayDevice
{
public:
    struct Options
    {
        double speed = 1; ///< > 0
        bool loop = false;
    };

    PlayingDevice(recording::Show show,
                  const Options& options,
                  std::unique_ptr<ArrayDevice> device);
    ~PlayingDevice() override;

    PlayingDevice(const PlayingDevice&) = delete;
    PlayingDevice& operator=(const PlayingDevice&) = delete;

    bool send(const DriveSignal&) override;
    void silence() override;                                         ///< stops the show
    void setMuted(bool muted) override { _device->setMuted(muted); } ///< the show goes on unheard
    std::string status() const override;
    /// The other device's, which counts as failed when the file broke off or was damaged.
    DeviceReport report() const override;
    DriveAbility ability() const override; ///< the other device's, but for sequences: it takes none
    bool identify(int board, bool light) override { return _device->identify(board, light); }
    std::vector<std::complex<float>> played() const override { return _device->played(); }
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override
    {
        return _device->wouldPlay(signal);
    }

    bool finished() const;
    std::string ending() const;     ///< what was wrong with the file; empty: nothing
    double worstLateness_s() const; ///< how much later than recorded a field was sent, at most

private:
    void run();
    bool playOnce(std::unique_lock<std::mutex>& lock); ///< false: stopped

    const recording::Show _show;
    const Options _options;
    const std::unique_ptr<ArrayDevice> _device;
    mutable std::mutex _mutex;
    std::condition_variable _wake;
    bool _stop = false;
    bool _finished = false;
    std::uint64_t _fields = 0;
    double _time_s = 0;
    double _worstLateness_s = 0;
    std::string _ending;
    std::thread _thread;
};

} // namespace midair::device
