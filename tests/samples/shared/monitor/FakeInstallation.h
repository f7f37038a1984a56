#pragma once

#include "samples/shared/monitor/Monitor.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <string>

namespace midair::samples
{

/// An installation without a scene, which says what the test wants it to.
class FakeInstallation : public MonitorSource
{
public:
    FakeInstallation()
    {
        reading.array = "octagon";
        reading.statistics.state = osgMidair::ArrayState::PLAYING;
        reading.statistics.device = "sim: 3984 transducers, 7 sent, 7 played";
        reading.statistics.fields.sent = 7;
        reading.statistics.fields.played = 7;
        reading.statistics.figures = {
            {"rms", 0.0125}, {"meanPhaseStep_rad", 0.5}, {"solve_ms", 2.0}};
        reading.statistics.rms = 0.0125;
        reading.statistics.exposure.places = 30;
        reading.statistics.exposure.level_dB = 117.5;
    }

    MonitorReading read() const override
    {
        std::unique_lock<std::mutex> lock(_mutex);
        ++begun;
        _changed.wait(lock, [this] { return !_hangs; });
        if (runs) ++reading.statistics.frames;
        ++reads;
        return reading;
    }

    void setMuted(bool muted) override
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        if (isBroken) throw std::runtime_error("broken");
        ++mutes;
        if (isDeaf) return;
        reading.isMuted = muted;
        reading.statistics.state =
            muted ? osgMidair::ArrayState::MUTED : osgMidair::ArrayState::PLAYING;
    }

    MonitorPicture picture() override { return {jpeg, 0.0}; }
    PictureCost pictureCost() const override { return {"", 3, 0.5, 0.75, 1.5}; }

    /// Changes what is read.
    template<typename Change>
    void change(const Change& change)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        change(reading);
    }

    /// From now on reading doesn't return, until it is false again.
    void hang(bool hangs)
    {
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            _hangs = hangs;
        }
        _changed.notify_all();
    }

    std::string jpeg = "\xFF\xD8picture"; ///< set before it is served
    std::atomic<bool> runs{true};         ///< a frame with each reading
    std::atomic<bool> isDeaf{false};      ///< mutes do nothing
    std::atomic<bool> isBroken{false};    ///< mutes throw
    std::atomic<int> mutes{0};
    mutable std::atomic<int> begun{0}; ///< readings; more than have ended: one hangs
    mutable std::atomic<int> reads{0}; ///< that have ended

private:
    mutable std::mutex _mutex;
    mutable std::condition_variable _changed;
    mutable MonitorReading reading;
    bool _hangs = false;
};

} // namespace midair::samples
