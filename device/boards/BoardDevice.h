#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/FieldQueue.h"
#include "device/boards/BoardCodec.h"
#include "device/boards/ByteSink.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace midair::device
{

/// The line to a board: tracks when its last byte leaves and which requests have left the computer.
/// Has no lock: the owner guards it. Times are base::steadySeconds().
class BoardLine
{
public:
    /// Time when the last byte has left the line.
    double free_s() const { return _free_s; }

    /// Reports \a bytes written at \a now_s, which occupy the line for \a onLine_s. \a isAhead:
    /// queued behind bytes still on the line; otherwise the line was free.
    void noteBytes(std::size_t bytes, double now_s, double onLine_s, bool isAhead)
    {
        _written += bytes;
        _free_s = (isAhead ? std::max(now_s, _free_s) : now_s) + onLine_s;
    }
    /// Assigns the bytes so far to the request of \a asked_s.
    void noteAsked(double asked_s) { _onItsWay.push_back({asked_s, _written}); }
    /// Reports a request as sent, if it keeps the line busy or occupies it for longer than a field.
    void noteSent(double asked_s) { _confirmed_s = std::max(_confirmed_s, asked_s); }
    /// Drops bytes in transit, which were discarded, or the board is lost.
    void forget() { _onItsWay.clear(); }
    bool isAnyOnItsWay() const { return !_onItsWay.empty(); }

    /// Request time of the latest request that has left.
    double confirmed_s() const { return _confirmed_s; }
    /// Reports that the computer still has \a unsent bytes.
    void noteUnsent(std::uint64_t unsent)
    {
        const std::uint64_t gone = _written - std::min(_written, unsent);
        for (; !_onItsWay.empty() && _onItsWay.front().end <= gone; _onItsWay.pop_front())
            noteSent(_onItsWay.front().asked_s);
    }

private:
    /// Written bytes that have not left the computer: request time and last byte.
    struct OnItsWay
    {
        double asked_s = 0;
        std::uint64_t end = 0;
    };
    std::deque<OnItsWay> _onItsWay;
    std::uint64_t _written = 0; ///< bytes
    double _confirmed_s = 0;
    double _free_s = 0;
};

/// An open board (BoardKind.h), which receives bytes and usually never answers.
///
/// A worker thread writes the newest field when the previous one has left the line. It repeats the
/// output, also silence, every 200 ms, which corrects damaged bytes and restarted boards. After
/// opening and after every loss it first silences the board. A lost board is silenced if this
/// process or its guard still can, and the worker tries to reopen it every 0.25 s.
///
/// A sequence is stored and timed by the board; for boards with two buffers exchanged by a byte,
/// the worker keeps the line busy with these bytes some milliseconds ahead. Silence overtakes them
/// and fills both buffers. A sequence is written in pieces, so that silence and newer fields wait
/// for one of them only.
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
    /// Silences the board. Waits for a board that is still starting, because it would begin to play
    /// by itself.
    ~BoardDevice() override;

    BoardDevice(const BoardDevice&) = delete;
    BoardDevice& operator=(const BoardDevice&) = delete;

    bool send(const DriveSignal& signal) override;
    bool sendSequence(const DriveSequence& sequence) override;
    void silence() override;
    double confirmed_s() const override; ///< completely sent by the computer
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override
    {
        const BoardCodec& codec = *_board.codec;
        DriveAbility ability{codec.phaseLevels(), codec.amplitudes()};
        ability.fieldsPerSecond = codec.fieldsPerSecond(_board.transducers);
        ability.sequenceFields = codec.sequenceFields();
        ability.sequenceClock_Hz = codec.sequenceClock_Hz();
        return ability;
    }
    std::vector<std::complex<float>> played() const override;
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    /// The board: how to open, drive and silence it.
    struct Board
    {
        std::string name;
        std::unique_ptr<BoardCodec> codec;
        int transducers = 0;
        Open open;
        std::vector<std::uint8_t> reset;       ///< BoardCodec::appendReset()
        std::vector<std::uint8_t> silentField; ///< BoardCodec::appendSilentField()
    };

    /// A sequence in the board's form; if both are empty: a single field.
    struct InTurn
    {
        BoardCodec::Pieces stored; ///< for a board that times it itself
        std::size_t written = 0;   ///< pieces of it
        double sentAt_s = 0;
        std::unique_ptr<BufferSwaps> swaps;

        bool isSequence() const { return swaps || !stored.empty(); }
        bool isBeingWritten() const { return written < stored.size(); }
    };

    /// Fields that are not written yet.
    struct Fields
    {
        FieldQueue queue; ///< at most one in flight
        InTurn waiting;   ///< of the field that waits
        std::uint32_t sequence = 0;
    };

    /// Output of the board.
    struct Sound
    {
        DriveSignal signal;
        std::vector<std::uint8_t> bytes; ///< field or silence written last; repeated
        InTurn inTurn;
        double nextLoad_s = 0; ///< earliest time to replace fields of inTurn

        void silence() { std::fill(signal.duty.begin(), signal.duty.end(), std::uint8_t(0)); }
    };

    /// Pending silence.
    struct Silencing
    {
        bool isWanted = false;
        double asked_s = 0;      ///< steady clock, of the last request
        int fieldsLeft = 0;      ///< silent fields left to write, for the board's other buffers
        bool isResetDue = false; ///< only Board::reset may be written, not before settled_s
        double settled_s = 0;    ///< time when the board is up
        std::uint64_t epoch = 0; ///< counts silences; fields of an older epoch don't play
    };

    /// Watches the answers of a board that should answer. After a reset an Arduino runs its
    /// bootloader, which stays while it receives bytes; after it the board begins to play by
    /// itself.
    struct Answers
    {
        enum
        {
            UNKNOWN,
            YES,
            NEVER
        } known = UNKNOWN;
        double due_s = 0; ///< 0: none due
        int missed = 0;   ///< in a row
    };

    /// Times of the worker's periodic actions.
    struct Rounds
    {
        double repeat_s = 0;      ///< time to repeat the output
        double openedLine_s = 0;  ///< when the codec's opening was last written
        double lookedAfter_s = 0; ///< last check of the line
    };

    /// Bytes that the worker writes at once.
    struct Piece
    {
        enum
        {
            RESET,   ///< silences everything on the line
            SILENCE, ///< one silent field
            FIELD,   ///< or the first piece of a sequence
            UPLOAD,  ///< a later piece of Sound::inTurn
            SWAPS,   ///< bytes of Sound::inTurn.swaps
            REPEAT
        } kind = REPEAT;
        std::uint64_t epoch = 0;
        std::vector<std::uint8_t> field; ///< bytes of the field that plays next
        double sentAt_s = 0;
        InTurn inTurn;
        bool isInserted = false; ///< into queued bytes of Sound::inTurn.swaps
    };

    bool put(const DriveSignal& signal, InTurn inTurn) MIDAIR_REQUIRES(_mutex);
    void silenceLocked() MIDAIR_REQUIRES(_mutex);

    // Called by the worker; those that open or write release _mutex meanwhile.
    void run() MIDAIR_EXCLUDES(_mutex);
    void reconnect(base::Lock& lock) MIDAIR_REQUIRES(_mutex);
    void adopt(std::unique_ptr<ByteSink> sink) MIDAIR_REQUIRES(_mutex);
    void lookAfterLine() MIDAIR_REQUIRES(_mutex);
    void writeNext() MIDAIR_REQUIRES(_mutex);
    void lose(std::string why) MIDAIR_REQUIRES(_mutex);
    /// Refuses fields from now on and drops the waiting one.
    void fail(const std::string& why) MIDAIR_REQUIRES(_mutex);
    void becomeReady() MIDAIR_REQUIRES(_mutex);
    /// Returns true if nothing is left to write before closing.
    bool quiet() const MIDAIR_REQUIRES(_mutex);
    bool watchesAnswers() const MIDAIR_REQUIRES(_mutex);
    void listen() MIDAIR_REQUIRES(_mutex);
    void missAnswer() MIDAIR_REQUIRES(_mutex);
    double nextWrite_s() const MIDAIR_REQUIRES(_mutex);
    Piece nextPiece() MIDAIR_REQUIRES(_mutex); ///< puts its bytes into _bytes
    Piece nextField() MIDAIR_REQUIRES(_mutex);
    Piece nextSwaps() MIDAIR_REQUIRES(_mutex);
    Piece nextUpload() MIDAIR_REQUIRES(_mutex);
    void noteUpload(double now_s) MIDAIR_REQUIRES(_mutex);
    /// False: none is waiting, or it must wait for the previous one.
    bool fieldIsDue() const MIDAIR_REQUIRES(_mutex);
    /// Returns true if both the waiting and the playing field are timed by the line.
    bool isInserted() const MIDAIR_REQUIRES(_mutex)
    {
        return _sound.inTurn.swaps && _fields.waiting.swaps;
    }
    void finish(Piece piece) MIDAIR_REQUIRES(_mutex);

    Board _board;                     ///< written only by the constructor
    std::vector<std::uint8_t> _bytes; ///< used only by the worker
    FieldCounters _counters;          ///< any thread

    mutable base::Mutex _mutex;
    base::Condition _wake;
    /// Null: lost. Only the worker replaces it, and uses it without the lock.
    std::unique_ptr<ByteSink> _sink MIDAIR_GUARDED_BY(_mutex);
    mutable BoardLine _line MIDAIR_GUARDED_BY(_mutex);
    Fields _fields MIDAIR_GUARDED_BY(_mutex);
    Sound _sound MIDAIR_GUARDED_BY(_mutex);
    Silencing _silencing MIDAIR_GUARDED_BY(_mutex);
    Answers _answers MIDAIR_GUARDED_BY(_mutex);
    Rounds _rounds MIDAIR_GUARDED_BY(_mutex);
    bool _ready MIDAIR_GUARDED_BY(_mutex) = false; ///< takes fields
    bool _closing MIDAIR_GUARDED_BY(_mutex) = false;

    std::thread _thread; ///< last, because it uses all others
};

} // namespace midair::device
