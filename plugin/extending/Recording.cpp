#include "device/recording/Recording.h"

#include "device/drive/DriveEncoder.h"
#include "device/recording/PlayingDevice.h"
#include "device/recording/RecordingDevice.h"
#include "device/recording/RecordingFile.h"
#include "engine-bridge/playing/unaided/UserDevice.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Range.h"
#include "haptics/base/threads/Forks.h"
#include "plugin/extending/ArrayConversion.h"

#include <osgMidair/ArrayDescription>
#include <osgMidair/HapticField>
#include <osgMidair/Recording>

#include <osg/Notify>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

namespace osgMidair
{

using midair::device::DeviceError;
using midair::device::DriveSignal;
namespace recording = midair::device::recording;

namespace
{

constexpr std::size_t kMostRecorded_bytes = std::size_t(2) << 30; // as for playing devices

bool encode(const std::vector<std::complex<float>>& activations, DriveSignal& signal)
{
    return midair::device::encode(activations.data(), static_cast<int>(activations.size()), signal);
}

/// Copies the indices of dead transducers, each once. Returns false, with the reason in \a error,
/// if one is not below \a transducers: the list then belongs to another array.
bool readDead(std::vector<unsigned int> given,
              unsigned int transducers,
              std::vector<int>& dead,
              std::string& error)
{
    std::sort(given.begin(), given.end());
    given.erase(std::unique(given.begin(), given.end()), given.end());
    if (!given.empty() && given.back() >= transducers)
    {
        error = fmt::format("transducer {} is dead, but the recording is for {}, from 0",
                            given.back(),
                            transducers);
        return false;
    }
    dead.assign(given.begin(), given.end());
    return true;
}

} // namespace

struct Recorder::Part : midair::device::RecordingDevice
{
    using RecordingDevice::RecordingDevice;
    const midair::base::MadeHere isOurs;
};

Recorder::Recorder(std::unique_ptr<Part> part) : osg::Referenced(true), _part(std::move(part)) {}

Recorder::~Recorder()
{
    midair::base::dropOrLeave(_part->isOurs, _part);
}

osg::ref_ptr<Recorder> Recorder::open(const std::string& file,
                                      unsigned int transducers,
                                      std::string& error,
                                      bool overwrite)
{
    if (!midair::base::RangeCheck()
             .within("transducers", transducers, 1, recording::kMostTransducers)
             .passed(&error))
        return nullptr;
    std::unique_ptr<Part> part;
    const auto open = [&]
    {
        part = std::make_unique<Part>(file,
                                      static_cast<int>(transducers),
                                      overwrite ? recording::Before::OVERWRITTEN
                                                : recording::Before::REPLACED);
    };
    return succeeds(open, error) ? new Recorder(std::move(part)) : nullptr;
}

bool Recorder::record(const std::vector<std::complex<float>>& activations)
{
    DriveSignal signal;
    return _part->isOurs && encode(activations, signal) && _part->send(signal);
}

bool Recorder::record(const HapticField& field)
{
    if (!_part->isOurs) return false;
    if (field.getNumFields() == 1) return record(field.getActivations());
    midair::device::DriveSequence sequence;
    sequence.rate_Hz = field.getFieldRate();
    for (unsigned int k = 0; k < field.getNumFields(); ++k)
        if (!encode(field.getActivations(k), sequence.signals.emplace_back())) return false;
    return _part->sendSequence(sequence);
}

void Recorder::silence()
{
    if (_part->isOurs) _part->silence();
}

std::string Recorder::getStatus() const
{
    return _part->isOurs ? _part->status() : midair::base::kForked;
}

struct RecordingWriter::Part
{
    explicit Part(int count) : transducers(count), writer(count)
    {
        add(writer.header(0)); // no time stamp, so that the same fields give the same bytes
    }

    void add(const std::vector<std::uint8_t>& more) { bytes.append(more.begin(), more.end()); }

    const int transducers;
    recording::Writer writer;
    std::string bytes; ///< not taken yet
    std::uint64_t last_ns = 0;
    bool isEnded = false;
};

static_assert(std::string_view(RecordingWriter::kBeginning) == recording::kMagic);

RecordingWriter::RecordingWriter(unsigned int transducers) :
    osg::Referenced(true),
    _part(std::make_unique<Part>(static_cast<int>(
        std::clamp(transducers, 1U, static_cast<unsigned int>(recording::kMostTransducers)))))
{
}

RecordingWriter::~RecordingWriter() = default;

bool RecordingWriter::record(const BakedField& field)
{
    const DriveSignal signal{field.phase, field.duty};
    const bool isSilence = field.phase.empty() && field.duty.empty();
    if (_part->isEnded || field.time_ns < _part->last_ns ||
        (!isSilence && !signal.fits(_part->transducers)))
        return false;
    _part->last_ns = field.time_ns;
    _part->add(isSilence ? _part->writer.mark(field.time_ns, recording::Kind::SILENCE)
                         : _part->writer.field(field.time_ns, signal));
    return true;
}

void RecordingWriter::end(std::uint64_t time_ns)
{
    if (_part->isEnded) return;
    _part->isEnded = true;
    _part->add(_part->writer.mark(std::max(time_ns, _part->last_ns), recording::Kind::END));
}

std::string RecordingWriter::take()
{
    return std::exchange(_part->bytes, {});
}

bool RecordingWriter::save(const std::string& file, std::string& error, bool overwrite)
{
    const auto write = [&]
    {
        const recording::OpenFile opened = recording::openForWriting(
            file, overwrite ? recording::Before::OVERWRITTEN : recording::Before::REPLACED);
        const std::string bytes = take();
        for (std::size_t done = 0; done < bytes.size();)
        {
            const ssize_t count =
                ::write(opened.descriptor(), bytes.data() + done, bytes.size() - done);
            if (count < 0 && errno == EINTR) continue;
            if (count < 0)
                throw DeviceError("recording \"" + file +
                                  "\": " + std::generic_category().message(errno));
            done += static_cast<std::size_t>(count);
        }
    };
    return succeeds(write, error);
}

struct RecordingReader::Part
{
    Part(std::string content, const std::string& file) :
        bytes(std::move(content)),
        reader(bytes, file)
    {
    }
    /// Reads the next entry; false: end.
    bool next()
    {
        const recording::Stop stop = reader.next(entry);
        if (stop == recording::Stop::TRUNCATED) error = "the recording ended without its last mark";
        if (stop == recording::Stop::CORRUPT) error = "the recording is damaged";
        return stop == recording::Stop::MORE;
    }

    const std::string bytes;
    recording::Reader reader;
    recording::Entry entry;
    std::string error;
};

RecordingReader::RecordingReader(std::unique_ptr<Part> part) : _part(std::move(part)) {}

RecordingReader::~RecordingReader() = default;

osg::ref_ptr<RecordingReader> RecordingReader::open(const std::string& file, std::string& error)
{
    try
    {
        return read(midair::base::readRegularFile(file, kMostRecorded_bytes), file, error);
    }
    catch (const midair::base::FileError& wrong)
    {
        error = "recording \"" + file + "\" " + wrong.what();
    }
    return nullptr;
}

osg::ref_ptr<RecordingReader>
RecordingReader::read(std::string bytes, const std::string& name, std::string& error)
{
    try
    {
        return new RecordingReader(std::make_unique<Part>(std::move(bytes), name));
    }
    catch (const DeviceError& wrong)
    {
        error = wrong.what();
    }
    return nullptr;
}

unsigned int RecordingReader::getNumTransducers() const
{
    return static_cast<unsigned int>(_part->reader.transducers());
}

bool RecordingReader::next(RecordedField& field)
{
    if (!_part->next()) return false;
    field.time_s = static_cast<double>(_part->entry.time_ns) * 1e-9;
    if (_part->entry.kind == recording::Kind::FIELD)
        midair::device::decode(_part->entry.signal, field.activations);
    else
        field.activations.assign(static_cast<std::size_t>(_part->reader.transducers()), {});
    return true;
}

bool RecordingReader::next(BakedField& field)
{
    if (!_part->next()) return false;
    field = {_part->entry.time_ns, {}, {}};
    if (_part->entry.kind != recording::Kind::FIELD) return true;
    field.phase = std::move(_part->entry.signal.phase);
    field.duty = std::move(_part->entry.signal.duty);
    return true;
}

const std::string& RecordingReader::getError() const
{
    return _part->error;
}

struct Player::Part : midair::device::PlayingDevice
{
    using PlayingDevice::PlayingDevice;
    const midair::base::MadeHere isOurs;
};

void PlayerOptions::useArray(const ArrayDescription& array)
{
    board.clear();
    for (const Transducer& transducer : array.transducers)
        board.push_back(transducer.board);
    dead = array.dead;
    this->array = std::make_shared<const ArrayDescription>(array);
}

Player::Player(std::unique_ptr<Part> part) : osg::Referenced(true), _part(std::move(part)) {}

Player::~Player()
{
    midair::base::dropOrLeave(_part->isOurs, _part);
}

osg::ref_ptr<Player> Player::open(const std::string& file,
                                  const std::string& device,
                                  std::string& error,
                                  const PlayerOptions& options)
{
    if (!midair::base::RangeCheck()
             .within("speed", options.speed, 0.001, 1000.0)
             .within("maxAmplitude", options.maxAmplitude, 0.0, 1.0)
             .passed(&error))
        return nullptr;
    const osg::ref_ptr<RecordingReader> head = RecordingReader::open(file, error);
    if (!head) return nullptr;
    std::vector<int> dead;
    if (!readDead(options.dead, head->getNumTransducers(), dead, error)) return nullptr;
    std::unique_ptr<Part> part;
    const auto open = [&]
    {
        const int transducers = static_cast<int>(head->getNumTransducers());
        if (midair::device::playsByItself(device))
            throw DeviceError("device \"" + device +
                              "\": a recording plays on an array, not on another recording");
        // Read before the device is opened, so that a record: device can't overwrite the file.
        recording::Show show(file, transducers);
        midair::device::SafetyLimits limits;
        limits.maxAmplitude = options.maxAmplitude;
        std::optional<midair::haptics::TransducerArray> array;
        if (options.array) array = arrayOf(*options.array);
        auto opened = midair::bridge::openForUser(
            device, {transducers, options.board}, array ? &*array : nullptr, limits, "a Player");
        if (opened->ability().maxPressure_Pa > 0.0)
            throw DeviceError("device \"" + device +
                              "\": max-pressure can't be held, since a recording has no control "
                              "points; max-amplitude can");
        if (!dead.empty())
            osg::notify(osg::NOTICE)
                << "osgMidair: recording \"" << file << "\": " << dead.size() << " of "
                << transducers << " transducers are dead and left out" << std::endl;
        part = std::make_unique<Part>(
            std::move(show),
            midair::device::PlayingDevice::Options{options.speed, options.loop, std::move(dead)},
            std::move(opened));
    };
    return succeeds(open, error) ? new Player(std::move(part)) : nullptr;
}

bool Player::isFinished() const
{
    if (!_part->isOurs) return true;
    _part->keepAlive();
    return _part->finished();
}

void Player::keepAlive()
{
    if (_part->isOurs) _part->keepAlive();
}

void Player::stop()
{
    if (_part->isOurs) _part->silence();
}

void Player::setMuted(bool muted)
{
    if (_part->isOurs) _part->setMuted(muted);
}

std::vector<std::complex<float>> Player::getActivations() const
{
    return _part->isOurs ? _part->played() : std::vector<std::complex<float>>();
}

std::string Player::getStatus() const
{
    return _part->isOurs ? _part->status() : midair::base::kForked;
}

} // namespace osgMidair
