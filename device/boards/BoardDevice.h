#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/FieldQueue.h"
#include "device/boards/BoardCodec.h"
#include "device/boards/ByteSink.h"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace midair::device
{

/// An open board (BoardKind.h), which takes bytes and in most cases never answers.
///
/// A worker writes the newest field as soon as the one before has left the line, and what plays, be
/// it silence, again every 200 ms, so that a byte that arrived damaged or a board that was switched
/// off and on is mended. Nothing else is written before the board was silenced, after opening and
/// after every loss. A lost board is silenced where anybody still can, and opened again every
/// quarter of a second.
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
    ~BoardDevice() override; ///< a board that is still starting is waited for: it would begin to
                             ///< play by itself

    BoardDevice(const BoardDevice&) = delete;
    BoardDevice& operator=(const BoardDevice&) = delete;

    bool send(const DriveSignal& signal) override;
    void silence() override;
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override
    {
        DriveAbility ability{_codec->phaseLevels(), _codec->amplitudes()};
        ability.fieldsPerSecond = _codec->fieldsPerSecond(_transducers);
        return ability;
    }
    std::vector<std::complex<float>> played() const override;
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    /// What the worker writes in one go.
    struct Piece
    {
        enum
        {
            RESET,   ///< silences whatever is on the line
            SILENCE, ///< one silent field
            FIELD,
            REPEAT
        } kind = REPEAT;
        std::uint64_t epoch = 0;
        std::vector<std::uint8_t> field; ///< bytes of what plays then
        double sentAt_s = 0;
    };

    void silenceLocked();
    void fail(const std::string& why); ///< takes no more fields, has none that waits
    // The worker's; with _mutex held, where it is given that is let go for the time of what may
    // take long.
    void run();
    void reconnect(std::unique_lock<std::mutex>& lock);
    void adopt(std::unique_ptr<ByteSink> sink);
    void lookAfterLine(std::unique_lock<std::mutex>& lock);
    void writeNext(std::unique_lock<std::mutex>& lock);
    void lose(std::unique_lock<std::mutex>& lock, std::string why);
    bool quiet() const; ///< nothing is left to be written before closing
    void becomeReady();
    bool watchesAnswers() const;
    void listen();
    void missAnswer();
    double nextWrite_s() const;
    Piece nextPiece(); ///< and its bytes in _bytes
    void finish(Piece piece);

    const std::string _name;
    const std::unique_ptr<BoardCodec> _codec;
    const int _transducers;
    const Open _open;
    std::vector<std::uint8_t> _reset;       ///< silences all there is, whatever it was told before
    std::vector<std::uint8_t> _silentField; ///< one
    mutable std::mutex _mutex;
    std::condition_variable _wake;
    std::unique_ptr<ByteSink> _sink;    ///< the worker's; null: lost
    std::vector<std::uint8_t> _bytes;   ///< the worker's
    std::vector<std::uint8_t> _current; ///< the field, or silence, that the board has got
    FieldQueue _fields;                 ///< one on its way at most
    std::uint32_t _sequence = 0;
    bool _silenceWanted = false;
    bool _resetDue = false; ///< nothing but _reset is written, and that not before _settled_s
    int _silentLeft = 0;    ///< fields, for the board's other buffers
    std::uint64_t _epoch =
        0; ///< counts silences: a field of an older one never becomes what is playing
    DriveSignal _playing;
    double _settled_s = 0;
    double _lineFree_s = 0; ///< when the last byte will have left
    double _repeatAt_s = 0;
    double _openingAt_s = 0; ///< when the codec's opening was last written
    double _lookedAfter_s = 0;
    // Whether a board that should answer does: an Arduino that is reset listens to its bootloader,
    // which takes every byte for a reason to stay, and then begins to play by itself.
    enum class Answers
    {
        UNKNOWN,
        YES,
        NEVER
    } _answers = Answers::UNKNOWN;
    double _answerDue_s = 0; ///< 0: none is
    int _missed = 0;         ///< answers in a row
    bool _ready = false;     ///< takes fields
    bool _closing = false;
    FieldCounters _counters;
    std::thread _thread;
};

} // namespace midair::device
