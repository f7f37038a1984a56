#include "device/recording/Recording.h"

#include "device/drive/DriveEncoder.h"
#include "device/recording/PlayingDevice.h"
#include "device/recording/RecordingDevice.h"
#include "device/recording/RecordingFile.h"
#include "engine-bridge/playing/unaided/UserDevice.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Range.h"
#include "plugin/extending/ArrayConversion.h"

#include <osgMidair/ArrayDescription>
#include <osgMidair/HapticField>
#include <osgMidair/Recording>

#include <osg/Notify>

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

using midair::device::DeviceError;
using midair::device::DriveSignal;
namespace recording = midair::device::recording;

namespace
{

constexpr std::size_t kMostRecorded_bytes = std::size_t(2) << 30; // as for devices that play

bool encode(const std::vector<std::complex<float>>& activations, DriveSignal& signal)
{
    return midair::device::encode(activations.data(), static_cast<int>(activations.size()), signal);
}

/// Copies the numbers of dead transducers, each once. Returns false, with the reason in \a error,
/// if one is none of \a transducers: the list is then of another array.
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
};

Recorder::Recorder(std::unique_ptr<Part> part) : osg::Referenced(true), _part(std::move(part)) {}

Recorder::~Recorder() = default;

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
    return encode(activations, signal) && _part->send(signal);
}

bool Recorder::record(const HapticField& field)
{
    if (field.getNumFields() == 1) return record(field.getActivations());
    midair::device::DriveSequence sequence;
    sequence.rate_Hz = field.getFieldRate();
    for (unsigned int k = 0; k < field.getNumFields(); ++k)
        if (!encode(field.getActivations(k), sequence.signals.emplace_back())) return false;
    return _part->sendSequence(sequence);
}

void Recorder::silence()
{
    _part->silence();
}

std::string Recorder::getStatus() const
{
    return _part->status();
}

struct RecordingReader::Part
{
    Part(std::string content, const std::string& file) :
        bytes(std::move(content)),
        reader(bytes, file)
    {
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
        return new RecordingReader(
            std::make_unique<Part>(midair::base::readRegularFile(file, kMostRecorded_bytes), file));
    }
    catch (const midair::base::FileError& wrong)
    {
        error = "recording \"" + file + "\" " + wrong.what();
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
    const recording::Stop stop = _part->reader.next(_part->entry);
    if (stop == recording::Stop::TRUNCATED) _part->error = "the recording breaks off";
    if (stop == recording::Stop::CORRUPT) _part->error = "the recording is damaged";
    if (stop != recording::Stop::MORE) return false;
    field.time_s = static_cast<double>(_part->entry.time_ns) * 1e-9;
    if (_part->entry.kind == recording::Kind::FIELD)
        midair::device::decode(_part->entry.signal, field.activations);
    else
        field.activations.assign(static_cast<std::size_t>(_part->reader.transducers()), {});
    return true;
}

const std::string& RecordingReader::getError() const
{
    return _part->error;
}

struct Player::Part : midair::device::PlayingDevice
{
    using PlayingDevice::PlayingDevice;
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

Player::~Player() = default;

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
        // Read before the device is opened, so that a record: in it can't overwrite the file.
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
    _part->keepAlive();
    return _part->finished();
}

void Player::keepAlive()
{
    _part->keepAlive();
}

void Player::stop()
{
    _part->silence();
}

void Player::setMuted(bool muted)
{
    _part->setMuted(muted);
}

std::vector<std::complex<float>> Player::getActivations() const
{
    return _part->played();
}

std::string Player::getStatus() const
{
    return _part->status();
}

} // namespace osgMidair
