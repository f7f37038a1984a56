#pragma once

#include "device/ArrayDevice.h"
#include "device/BoardCodec.h"
#include "device/ByteSink.h"
#include "device/FieldCounters.h"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace midair::device
{

/// `sonicsurface:TTY`, `ultraino:TTY`, `openmpd:SERIAL`: an open board, which takes bytes and never answers.
///
/// A worker writes the newest field as soon as the one before has left the line. A lost board is opened again every quarter of a
/// second, silent until the next field.
class BoardDevice : public ArrayDevice
{
public:
    /// Opens the way to the board; \a lastWill are bytes that silence it. Throws DeviceError.
    using Open =
        std::function<std::unique_ptr<ByteSink>(const std::vector<std::uint8_t>& lastWill)>;

    /// Throws DeviceError when the board has another number of transducers or can't be opened.
    BoardDevice(const std::string& name,
                std::unique_ptr<BoardCodec> codec,
                int transducers,
                Open open);
    ~BoardDevice() override;

    BoardDevice(const BoardDevice&) = delete;
    BoardDevice& operator=(const BoardDevice&) = delete;

    bool send(const DriveSignal& signal) override;
    void silence() override;
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override
    {
        DriveAbility ability{_codec->phaseLevels(), _codec->amplitudes()};
        ability.fieldsPerSecond =
            _codec->bytesPerSecond() / static_cast<double>(_silentFrame.size());
        return ability;
    }
    std::vector<std::complex<float>> played() const override;
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    void connect(); ///< throws DeviceError
    void run();
    void lose(std::string why); ///< by value: it may be the error of the sink that goes
    bool writePaced(std::unique_lock<std::mutex>& lock);
    void silenceLocked();

    const std::string _name;
    const std::unique_ptr<BoardCodec> _codec;
    const int _transducers;
    const Open _open;
    std::vector<std::uint8_t> _silentFrame;
    mutable std::mutex _mutex;
    std::condition_variable _wake;
    std::condition_variable _quiet;
    std::unique_ptr<ByteSink> _sink; ///< the worker's
    std::vector<std::uint8_t> _bytes;
    DriveSignal _slot;
    double _slotAt_s = 0;
    bool _slotFull = false;
    bool _silenceWanted = false;
    std::uint64_t _epoch =
        0; ///< counts silences: a field of an older one never becomes what is playing
    DriveSignal _playing;
    double _lineFree_s = 0; ///< when the last byte will have left
    bool _ready = false;
    bool _closing = false;
    FieldCounters _counters;
    std::thread _thread;
};

} // namespace midair::device
