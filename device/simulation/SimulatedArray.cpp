#include "device/simulation/SimulatedArray.h"

#include "device/DeviceLog.h"
#include "device/DeviceUri.h"
#include "device/boards/BoardKind.h"
#include "device/drive/DriveEncoder.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device
{

namespace
{

// Throws before the members are constructed, so that they can be const.
const DeviceLayout&
checked(const DeviceLayout& layout, const BoardCodec* codec, const std::string& name)
{
    if (codec == nullptr && !name.empty())
        throw DeviceError("device \"sim:\": board=" + name +
                          " should be autd3, sonicsurface, ultraino or openmpd");
    if (codec != nullptr && !codec->takes(layout.transducers))
        throw DeviceError(fmt::format("device \"sim:\": board {} has {}, but the array has {}",
                                      name,
                                      codec->takesText(),
                                      layout.transducers));
    return layout;
}

} // namespace

SimulatedBoard::SimulatedBoard(const std::string& scheme, int transducers) :
    _transducers(transducers),
    _codec(makeBoardCodec(scheme)),
    _board(makeVirtualBoard(scheme, transducers))
{
    _codec->appendReset(_bytes, transducers);
    give(0);
}

void SimulatedBoard::play(const DriveSignal& signal, double now_s)
{
    _inTurn.signals.clear();
    _bytes.clear();
    _codec->appendField(_bytes, signal);
    give(now_s);
}

bool SimulatedBoard::playSequence(const DriveSequence& sequence, double now_s)
{
    if (sequence.signals.size() > static_cast<std::size_t>(_codec->sequenceFields()) ||
        (_codec->swap() == nullptr && _codec->piecesOf(sequence).empty()))
        return false;
    _inTurn = sequence;
    _inTurnSince_s = now_s;
    _inTurnStep = -1;
    advance(now_s);
    return true;
}

void SimulatedBoard::advance(double now_s)
{
    if (_inTurn.signals.empty()) return;
    constexpr std::int64_t kMostSteps = 200; // more of a modulation than the history keeps
    const auto step = static_cast<std::int64_t>((now_s - _inTurnSince_s) * _inTurn.rate_Hz);
    for (_inTurnStep = std::max(_inTurnStep, step - kMostSteps); _inTurnStep < step;)
    {
        const auto signal = static_cast<std::size_t>(++_inTurnStep) % _inTurn.signals.size();
        _bytes.clear();
        _codec->appendField(_bytes, _inTurn.signals[signal]);
        give(_inTurnSince_s + static_cast<double>(_inTurnStep) / _inTurn.rate_Hz);
    }
}

void SimulatedBoard::silence(double now_s)
{
    _inTurn.signals.clear();
    _bytes.clear();
    _codec->appendSilence(_bytes, _transducers);
    give(now_s);
}

void SimulatedBoard::give(double now_s)
{
    _board->receive(_bytes.data(), _bytes.size());
    Activations q = _board->playing();
    if (!_history.newest() || q != *_history.newest()) _history.note(now_s, std::move(q));
}

SimulatedArray::Options SimulatedArray::takeOptions(DeviceUri& uri)
{
    constexpr double kNever_s = 1e6;
    Options options;
    options.drop = uri.takeNumber("drop", 0, 0, 1);
    options.corrupt = uri.takeNumber("corrupt", 0, 0, 1);
    options.seed = static_cast<unsigned>(uri.takeNumber("seed", 1, 0, 1e9));
    options.firmware.latency_s = uri.takeSeconds("latency", 0);
    options.firmware.fieldsPerSecond = uri.takeNumber("fps", 0, 0, 1e6);
    options.unplugAt_s = uri.takeSeconds("unplug_at", kNever_s);
    options.replugAt_s = uri.takeSeconds("replug_at", kNever_s);
    options.hangAt_s = uri.takeSeconds("hang_at", kNever_s);
    options.board = uri.takeText("board", "");
    options.firmware.hasHistory = true;
    options.ringing_s = uri.takeSeconds("ringing", -1);
    if (options.ringing_s > kMostSimulatedRinging_s)
        throw uri.error(
            fmt::format("ringing is {:g} s; it should be 0s to {:g}ms, the time constant "
                        "of the transducers",
                        options.ringing_s,
                        1000 * kMostSimulatedRinging_s));
    return options;
}

SimulatedArray::SimulatedArray(const DeviceLayout& layout, const Options& options) :
    _layout(checked(layout, makeBoardCodec(options.board).get(), options.board)),
    _options(options),
    _ranges(protocol::ranges(layout)),
    _start_s(base::steadySeconds()),
    _board(options.board.empty()
               ? nullptr
               : std::make_unique<SimulatedBoard>(options.board, layout.transducers)),
    _firmware(layout, options.firmware),
    _random(options.seed)
{
    if (_board != nullptr) return;
    protocol::Packet hello;
    hello.type = protocol::Type::HELLO;
    tell(hello, 0);
    _firmware.takeAnswer(4096, 0);
}

SimulatedArray::~SimulatedArray()
{
    SimulatedArray::silence();
}

bool SimulatedArray::sendSequence(const DriveSequence& sequence)
{
    const double sentAt_s = base::steadySeconds();
    const base::Lock lock(_mutex);
    const double now_s = advance();
    if (_board == nullptr || !sequence.fits(_layout.transducers) || unplugged(now_s) ||
        !_board->playSequence(sequence, now_s))
    {
        _counters.countRefused();
        return false;
    }
    _counters.countPlayed(sentAt_s);
    return true;
}

double SimulatedArray::advance() const
{
    const double now_s = base::steadySeconds() - _start_s;
    if (_board != nullptr && !unplugged(now_s)) _board->advance(now_s);
    // A real host sends KEEPALIVE from a thread; here each call updates the firmware.
    if (!unplugged(now_s)) _firmware.keptAlive(std::min(now_s, _options.hangAt_s));
    const std::uint32_t watchdogs = _firmware.status(now_s).watchdogs;
    if (watchdogs > _watchdogs)
    {
        _confirmed_s = std::numeric_limits<double>::infinity(); // it is silent
        _counters.countFault("muted by its watchdog");
    }
    _watchdogs = watchdogs;
    if (now_s >= _options.unplugAt_s && !_unplugged)
    {
        _unplugged = _lost = true;
        _counters.countLoss("unplugged");
        _firmware.powerCycle(now_s);
        _watchdogs = 0;
        deviceLog().error("sim: unplugged; silent until it is plugged in again");
    }
    if (now_s >= _options.replugAt_s && _options.replugAt_s > _options.unplugAt_s && _lost)
    {
        _lost = false;
        _counters.countReturn();
        deviceLog().info("sim: plugged in again");
    }
    return now_s;
}

// Each packet may be lost or damaged, as on a wire.
void SimulatedArray::deliver(double now_s)
{
    if (_options.drop <= 0 && _options.corrupt <= 0)
    {
        _firmware.receive(_bytes.data(), _bytes.size(), now_s);
        return;
    }
    std::uniform_real_distribution<double> chance(0, 1);
    std::size_t begin = 0;
    while (begin < _bytes.size())
    {
        const std::size_t length = protocol::kHeaderBytes + _bytes[begin + 4] +
                                   256U * _bytes[begin + 5] + protocol::kCrcBytes;
        if (chance(_random) < _options.corrupt) _bytes[begin + _random() % length] ^= 0x10;
        if (chance(_random) >= _options.drop)
            _firmware.receive(_bytes.data() + begin, length, now_s);
        begin += length;
    }
}

bool SimulatedArray::sendPackets(const DriveSignal& signal, double now_s)
{
    if (++_sequence == 0) ++_sequence; // 0 means none
    _bytes.clear();
    protocol::appendField(_bytes, signal, _ranges, _sequence);
    deliver(now_s);
    _firmware.takeAnswer(1 << 16, now_s);
    return _firmware.status(now_s).lastPlayed == _sequence;
}

bool SimulatedArray::send(const DriveSignal& signal)
{
    const double sentAt_s = base::steadySeconds();
    const base::Lock lock(_mutex);
    const double now_s = advance();
    if (!signal.fits(_layout.transducers) || unplugged(now_s))
    {
        _counters.countRefused();
        return false;
    }
    if (_board != nullptr)
    {
        _board->play(signal, now_s);
        _counters.countPlayed(sentAt_s);
        return true;
    }
    const bool arrives = now_s < _options.hangAt_s && sendPackets(signal, now_s);
    noteArrival(arrives, sentAt_s);
    if (!arrives)
        _counters.change(
            [](DeviceReport& report)
            {
                ++report.sent;
                ++report.lost;
                report.message = "an incomplete field was not played";
            });
    else
        _counters.countPlayed(sentAt_s);
    return true;
}

void SimulatedArray::silence()
{
    const base::Lock lock(_mutex);
    const double now_s = advance();
    if (_board != nullptr) return _board->silence(now_s);
    if (unplugged(now_s)) return;
    noteArrival(now_s < _options.hangAt_s, _start_s + now_s);
    if (now_s >= _options.hangAt_s) return;
    protocol::Packet mute;
    mute.type = protocol::Type::MUTE;
    mute.sequence = ++_sequence;
    tell(mute, now_s);
}

void SimulatedArray::tell(const protocol::Packet& packet, double now_s)
{
    _bytes.clear();
    protocol::append(_bytes, packet);
    _firmware.receive(_bytes.data(), _bytes.size(), now_s);
}

void SimulatedArray::noteArrival(bool arrived, double asked_s)
{
    if (arrived)
        _confirmed_s = std::numeric_limits<double>::infinity();
    else
        _confirmed_s = std::min(_confirmed_s, std::nextafter(asked_s, 0));
}

double SimulatedArray::confirmed_s() const
{
    const base::Lock lock(_mutex);
    return _confirmed_s;
}

bool SimulatedArray::identify(int board, bool light)
{
    const base::Lock lock(_mutex);
    const double now_s = advance();
    if (_board != nullptr || unplugged(now_s)) return false;
    protocol::Packet packet;
    packet.type = protocol::Type::IDENTIFY;
    packet.board = board < 0 ? protocol::kAllBoards : static_cast<std::uint16_t>(board);
    packet.light = light;
    tell(packet, now_s);
    return true;
}

DriveAbility SimulatedArray::ability() const
{
    DriveAbility ability;
    ability.fieldsPerSecond = _options.firmware.fieldsPerSecond;
    ability.ringing_s = _options.ringing_s;
    if (_board == nullptr) return ability;
    const base::Lock lock(_mutex);
    const BoardCodec& codec = _board->codec();
    ability.phaseLevels = codec.phaseLevels();
    ability.amplitudes = codec.amplitudes();
    // The simulation has no line, but should have the limit of the real board's.
    const double carried = codec.fieldsPerSecond(_layout.transducers);
    if (ability.fieldsPerSecond <= 0 || carried < ability.fieldsPerSecond)
        ability.fieldsPerSecond = carried;
    ability.sequenceFields = codec.sequenceFields();
    ability.sequenceClock_Hz = codec.sequenceClock_Hz();
    return ability;
}

DeviceReport SimulatedArray::report() const
{
    const base::Lock lock(_mutex);
    const double now_s = advance();
    DeviceReport report = _counters.report();
    if (_board == nullptr)
    {
        report.firmware = fmt::format("1.{}.0", _options.firmware.firmwareMinor);
        report.temperature_C = _firmware.status(now_s).temperature_dC / 10.0;
    }
    return report;
}

std::string SimulatedArray::status() const
{
    const std::string counters = countersText(report());
    const base::Lock lock(_mutex);
    const double now_s = advance();
    std::string text =
        fmt::format("sim: {}{} transducers, {}",
                    _board != nullptr ? fmt::format("{}, ", _board->codec().name()) : "",
                    _layout.transducers,
                    counters);
    if (_board != nullptr) return text;
    const protocol::Status status = _firmware.status(now_s);
    if ((status.flags & protocol::WATCHDOG_FIRED) != 0) text += "; muted by the watchdog";
    if (status.incomplete > 0)
        text += fmt::format("; {} incomplete fields were not played", status.incomplete);
    return text;
}

std::vector<std::complex<float>> SimulatedArray::played() const
{
    const base::Lock lock(_mutex);
    const double now_s = advance();
    if (unplugged(now_s)) return std::vector<std::complex<float>>(_layout.transducers);
    if (_board != nullptr) return _board->playing();
    std::vector<std::complex<float>> q;
    decode(_firmware.playing(now_s), q);
    return q;
}

std::vector<PlayedField> SimulatedArray::playedSince(double from_s) const
{
    const base::Lock lock(_mutex);
    const double now_s = advance();
    std::vector<PlayedField> fields;
    if (_board != nullptr)
        for (auto& [since_s, q] : _board->playedSince(from_s - _start_s))
            fields.push_back({_start_s + since_s, std::move(q)});
    else
        for (const auto& [since_s, signal] : _firmware.playedSince(from_s - _start_s, now_s))
        {
            fields.push_back({_start_s + since_s, {}});
            decode(signal, fields.back().q);
        }
    return fields;
}

std::vector<std::complex<float>> SimulatedArray::wouldPlay(const DriveSignal& signal) const
{
    if (_board == nullptr) return ArrayDevice::wouldPlay(signal);
    std::vector<std::complex<float>> q;
    const base::Lock lock(_mutex);
    _board->codec().played(signal, q);
    return q;
}

} // namespace midair::device
