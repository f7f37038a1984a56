#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/FieldQueue.h"
#include "device/boards/BoardCodec.h"
#include "device/boards/BufferSwaps.h"
#include "device/boards/ByteSink.h"

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace midair::device
{

/// An open board (BoardKind.h), which takes bytes and usually never answers.
///
/// A worker thread writes the newest field as soon as the one before has left the line. It repeats
/// what plays, also silence, every 200 ms, which corrects damaged bytes and a board that was
/// switched off and on. After opening and after every loss it first silences the board. A lost
/// board is silenced if this process or its guard still can, and the worker tries to open it again
/// every 0.25 s.
///
/// A sequence is stored by the board, which times it by itself, or, where it has two buffers that a
/// byte exchanges, the worker keeps the line busy with these bytes some milliseconds ahead. Silence
/// overtakes them, and fills both buffers.
class BoardDevice : public ArrayDevice
{
public:
    /// Opens the connection to the board; \a lastWill are the bytes that silence it. Throws
    /// DeviceError.
    using Open =
        std::function<std::unique_ptr<ByteSink>(const std::vector<std::uint8_t>& lastWill)>;

    /// Throws DeviceError if the board has another number of transducers or can't be opened.
    BoardDevice(const std::string& name,
                std::unique_ptr<BoardCodec> codec,
                int transducers,
                Open open);
    /// Silences the board. Waits for a board that is still starting, which would begin to play by
    /// itself.
    ~BoardDevice() override;

    BoardDevice(const BoardDevice&) = delete;
    BoardDevice& operator=(const BoardDevice&) = delete;

    bool send(const DriveSignal& signal) override;
    bool sendSequence(const DriveSequence& sequence) override;
    void silence() override;
    double confirmed_s() const override; ///< what has left the computer whole
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override
    {
        DriveAbility ability{_codec->phaseLevels(), _codec->amplitudes()};
        ability.fieldsPerSecond = _codec->fieldsPerSecond(_transducers);
        ability.sequenceFields = _codec->sequenceFields();
        ability.sequenceClock_Hz = _codec->sequenceClock_Hz();
        return ability;
    }
    std::vector<std::complex<float>> played() const override;
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    /// A sequence as this board gets it; neither: a single field.
    struct InTurn
    {
        std::vector<std::uint8_t> stored; ///< for a board that times it by itself
        std::unique_ptr<BufferSwaps> swaps;

        bool isSequence() const { return swaps || !stored.empty(); }
    };

    /// The bytes that the worker writes in one go.
    struct Piece
    {
        enum
        {
            RESET,   ///< silences everything on the line
            SILENCE, ///< one silent field
            FIELD,
            SWAPS, ///< bytes of _inTurn.swaps
            REPEAT
        } kind = REPEAT;
        std::uint64_t epoch = 0;
        std::vector<std::uint8_t> field; ///< bytes of the field that plays afterwards
        double sentAt_s = 0;
        InTurn inTurn;
        bool isInserted = false; ///< into what is on its way to the line: bytes of _inTurn.swaps
    };

    void silenceLocked();
    void fail(const std::string& why); ///< refuses fields from now on and drops the waiting one
    // These are called by the worker with _mutex held; those that take the lock release it during
    // long operations.
    void run();
    void reconnect(std::unique_lock<std::mutex>& lock);
    void adopt(std::unique_ptr<ByteSink> sink);
    void lookAfterLine(std::unique_lock<std::mutex>& lock);
    void writeNext(std::unique_lock<std::mutex>& lock);
    void lose(std::unique_lock<std::mutex>& lock, std::string why);
    bool quiet() const; ///< true if nothing is left to be written before closing
    void becomeReady();
    bool watchesAnswers() const;
    void listen();
    void missAnswer();
    double nextWrite_s() const;
    Piece nextPiece(); ///< puts its bytes into _bytes
    Piece nextField();
    Piece nextSwaps();
    bool fieldIsDue() const; ///< false: none waits, or it has to wait for the one before
    /// Whether both the field that waits and the one that plays are timed by the line.
    bool isInserted() const { return _inTurn.swaps && _waiting.swaps; }
    bool put(const DriveSignal& signal, InTurn inTurn);
    void finish(Piece piece);
    void noteWritten(double asked_s, bool isTimed = false);

    const std::string _name;
    const std::unique_ptr<BoardCodec> _codec;
    const int _transducers;
    const Open _open;
    std::vector<std::uint8_t> _reset;       ///< BoardCodec::appendReset()
    std::vector<std::uint8_t> _silentField; ///< BoardCodec::appendSilentField()
    mutable std::mutex _mutex;
    std::condition_variable _wake;
    std::unique_ptr<ByteSink> _sink;    ///< used by the worker; null: lost
    std::vector<std::uint8_t> _bytes;   ///< used by the worker
    std::vector<std::uint8_t> _current; ///< the field, or silence, written last; repeated
    FieldQueue _fields;                 ///< at most one in flight
    InTurn _waiting;                    ///< of the field that waits
    InTurn _inTurn;                     ///< what plays
    double _nextLoad_s = 0;             ///< before it _inTurn's fields aren't replaced by others
    std::uint32_t _sequence = 0;
    bool _silenceWanted = false;
    double _silenceAsked_s = 0; ///< steady clock, of the last one
    /// What was written, until it has left the computer: when it was asked for, and its last byte.
    struct OnItsWay
    {
        double asked_s = 0;
        std::uint64_t end = 0;
    };
    mutable std::deque<OnItsWay> _onItsWay;
    std::uint64_t _written = 0;      ///< bytes
    mutable double _confirmed_s = 0; ///< when that was asked for which has left last
    bool _resetDue = false;          ///< only _reset may be written, and not before _settled_s
    int _silentLeft = 0;             ///< silent fields left to write, for the board's other buffers
    /// Counts silences; a field of an older epoch doesn't become _playing.
    std::uint64_t _epoch = 0;
    DriveSignal _playing;
    double _settled_s = 0;
    double _lineFree_s = 0; ///< when the last byte has left the line
    double _repeatAt_s = 0;
    double _openingAt_s = 0; ///< when the codec's opening was last written
    double _lookedAfter_s = 0;
    // Does a board that should answer do so? After a reset an Arduino runs its bootloader, which
    // stays as long as it gets bytes; after it the board begins to play by itself.
    enum class Answers
    {
        UNKNOWN,
        YES,
        NEVER
    } _answers = Answers::UNKNOWN;
    double _answerDue_s = 0; ///< 0: no answer is due
    int _missed = 0;         ///< missing answers in a row
    bool _ready = false;     ///< takes fields
    bool _closing = false;
    FieldCounters _counters;
    std::thread _thread;
};

} // namespace midair::device
