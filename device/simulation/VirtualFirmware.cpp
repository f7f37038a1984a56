#include "device/simulation/VirtualFirmware.h"

#include <algorithm>
#include <cmath>

namespace midair::device
{

using protocol::Packet;
using protocol::Type;

namespace
{

constexpr double kCoolingBand_C = 5;
constexpr std::size_t kMostAnswers = 64; // bounds the memory if a host never reads

} // namespace

VirtualFirmware::VirtualFirmware(const DeviceLayout& layout, const Options& options) :
    _options(options),
    _transducers(layout.transducers),
    _temperature_C(options.temperature_C)
{
    _boards.begin.push_back(0);
    for (int i = 1; i < _transducers; ++i)
        if (!layout.board.empty() && layout.board[i] != layout.board[i - 1])
            _boards.begin.push_back(i);
    _boards.light.assign(_boards.begin.size(), false);
    _boards.begin.push_back(_transducers);
    reset(0);
}

void VirtualFirmware::reset(double now_s)
{
    _parser = protocol::StreamParser();
    _back.signal = silentSignal(_transducers);
    _front = _back.signal;
    _back.stamp.assign(_transducers, 0);
    _commits.queue.clear();
    _answers.clear();
    _status = protocol::Status();
    _commits.newest = 0;
    mute(protocol::MUTED, now_s);
}

void VirtualFirmware::powerCycle(double now_s)
{
    const base::Lock lock(_mutex);
    reset(now_s);
    _watchdog.fed_s = now_s;
}

// Repeated fields and repeated silences change nothing.
void VirtualFirmware::note(double since_s)
{
    if (!_options.hasHistory) return;
    const DriveSignal* last = _history.newest();
    if (last && last->phase == _front.phase && last->duty == _front.duty) return;
    _history.note(since_s, _front);
}

void VirtualFirmware::mute(std::uint16_t why, double at_s)
{
    _commits.queue.clear();
    std::fill(_front.duty.begin(), _front.duty.end(), std::uint8_t(0));
    note(at_s);
    _status.flags =
        static_cast<std::uint16_t>((_status.flags & ~unsigned(protocol::PLAYING)) | why);
}

// Advances the state to now_s: swaps in due fields, unless the watchdog muted before.
void VirtualFirmware::advance(double now_s)
{
    const double watchdogAt_s = _watchdog.fed_s + _watchdog.after_s;
    while (!_commits.queue.empty() && _commits.queue.front().due_s <= std::min(now_s, watchdogAt_s))
    {
        _front = std::move(_commits.queue.front().signal);
        note(_commits.queue.front().due_s);
        _commits.queue.pop_front();
    }
    const bool sounds = (_status.flags & protocol::PLAYING) != 0;
    if (sounds && now_s > watchdogAt_s)
    {
        mute(protocol::WATCHDOG_FIRED, watchdogAt_s);
        ++_status.watchdogs;
        answerStatus(0);
    }
}

void VirtualFirmware::answerStatus(std::uint32_t sequence)
{
    _status.temperature_dC = static_cast<std::int16_t>(std::lround(_temperature_C * 10));
    _status.badPackets = _parser.badPackets();
    Packet packet;
    packet.type = Type::STATUS;
    packet.version = _options.protocolVersion;
    packet.sequence = sequence;
    packet.status = _status;
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, packet);
    _answers.push_back(std::move(bytes));
    if (_answers.size() > kMostAnswers) _answers.pop_front();
}

void VirtualFirmware::receive(const std::uint8_t* bytes, std::size_t count, double now_s)
{
    const base::Lock lock(_mutex);
    advance(now_s);
    _parser.push(bytes, count);
    Packet packet;
    while (_parser.next(packet))
    {
        _watchdog.fed_s = now_s;
        handle(packet, now_s);
    }
    advance(now_s);
}

void VirtualFirmware::handle(const Packet& packet, double now_s)
{
    switch (packet.type)
    {
    case Type::HELLO:
        greet(packet, now_s);
        break;
    case Type::DATA:
        store(packet);
        break;
    case Type::COMMIT:
        commit(packet, now_s);
        answerStatus(packet.sequence);
        break;
    case Type::MUTE:
        // Ignored if a newer field has been committed; 0 always mutes.
        if (packet.sequence == 0 || protocol::newer(packet.sequence, _commits.newest))
        {
            _commits.newest = packet.sequence == 0 ? _commits.newest : packet.sequence;
            mute(protocol::MUTED, now_s);
        }
        answerStatus(packet.sequence);
        break;
    case Type::KEEPALIVE:
        break;
    case Type::GET_STATUS:
        answerStatus(0);
        break;
    case Type::IDENTIFY:
        for (std::size_t board = 0; board < _boards.light.size(); ++board)
            if (packet.board == protocol::kAllBoards || packet.board == board)
                _boards.light[board] = packet.light;
        break;
    case Type::STATUS:
    case Type::INFO:
        break; // no host sends these
    }
}

void VirtualFirmware::greet(const Packet& packet, double now_s)
{
    _commits.newest = 0;
    _status.lastPlayed = 0;
    std::fill(_back.stamp.begin(), _back.stamp.end(), 0U);
    mute(protocol::MUTED, now_s);
    _watchdog.after_s =
        std::min<double>(std::max<int>(packet.watchdog_ms, 1), 1000 * protocol::kWatchdog_s) / 1000;
    Packet answer;
    answer.type = Type::INFO;
    answer.version = _options.protocolVersion;
    answer.info.firmwareMajor = 1;
    answer.info.firmwareMinor = _options.firmwareMinor;
    answer.info.boards = static_cast<std::uint16_t>(_boards.begin.size() - 1);
    answer.info.transducers = static_cast<std::uint32_t>(_transducers);
    answer.info.watchdog_ms = static_cast<std::uint16_t>(std::lround(_watchdog.after_s * 1000));
    answer.info.fieldsPerSecond =
        static_cast<std::uint16_t>(std::min(_options.fieldsPerSecond, 65535.0));
    answer.info.nonce = packet.nonce;
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, answer);
    _answers.push_back(std::move(bytes));
}

void VirtualFirmware::store(const Packet& packet)
{
    if (packet.board + 1U >= _boards.begin.size()) return;
    const int begin = _boards.begin[packet.board] + packet.first;
    const int count = static_cast<int>(packet.phases.size());
    if (begin + count > _boards.begin[packet.board + 1U]) return;
    std::copy(packet.phases.begin(), packet.phases.end(), _back.signal.phase.begin() + begin);
    std::copy(packet.duties.begin(), packet.duties.end(), _back.signal.duty.begin() + begin);
    std::fill_n(_back.stamp.begin() + begin, count, packet.sequence);
}

void VirtualFirmware::commit(const Packet& packet, double now_s)
{
    if (!protocol::newer(packet.sequence, _commits.newest))
    {
        ++_status.stale;
        return;
    }
    const bool complete =
        packet.transducers == static_cast<std::uint32_t>(_transducers) &&
        std::all_of(_back.stamp.begin(),
                    _back.stamp.end(),
                    [&](std::uint32_t stamp) { return stamp == packet.sequence; });
    if (!complete)
    {
        ++_status.incomplete;
        return;
    }
    if ((_status.flags & protocol::OVER_TEMPERATURE) != 0) return;
    double due_s = now_s + _options.latency_s;
    if (_options.fieldsPerSecond > 0)
    {
        // A newer field takes the place of a waiting one.
        if (!_commits.queue.empty() && _commits.queue.back().due_s > due_s)
        {
            due_s = _commits.queue.back().due_s;
            _commits.queue.pop_back();
            ++_status.stale;
            --_status.played;
        }
        else
            due_s = std::max(due_s, _commits.lastDue_s + 1 / _options.fieldsPerSecond);
    }
    _commits.lastDue_s = due_s;
    _commits.queue.push_back({due_s, _back.signal});
    _commits.newest = packet.sequence;
    _status.lastPlayed = packet.sequence;
    ++_status.played;
    _status.flags = protocol::PLAYING;
}

std::vector<std::uint8_t> VirtualFirmware::takeAnswer(std::size_t most, double now_s)
{
    const base::Lock lock(_mutex);
    advance(now_s);
    std::vector<std::uint8_t> bytes;
    while (!_answers.empty() && bytes.size() + _answers.front().size() <= most)
    {
        bytes.insert(bytes.end(), _answers.front().begin(), _answers.front().end());
        _answers.pop_front();
    }
    return bytes;
}

bool VirtualFirmware::hasAnswer(double now_s)
{
    const base::Lock lock(_mutex);
    advance(now_s);
    return !_answers.empty();
}

void VirtualFirmware::keptAlive(double now_s)
{
    const base::Lock lock(_mutex);
    _watchdog.fed_s = now_s;
    advance(now_s);
}

DriveSignal VirtualFirmware::playing(double now_s)
{
    const base::Lock lock(_mutex);
    advance(now_s);
    return _front;
}

std::vector<std::pair<double, DriveSignal>> VirtualFirmware::playedSince(double from_s,
                                                                         double now_s)
{
    const base::Lock lock(_mutex);
    advance(now_s);
    return _history.since(from_s);
}

protocol::Status VirtualFirmware::status(double now_s)
{
    const base::Lock lock(_mutex);
    advance(now_s);
    _status.badPackets = _parser.badPackets();
    _status.temperature_dC = static_cast<std::int16_t>(std::lround(_temperature_C * 10));
    return _status;
}

bool VirtualFirmware::light(int board) const
{
    const base::Lock lock(_mutex);
    return _boards.light.at(board);
}

void VirtualFirmware::setTemperature(double celsius, double now_s)
{
    const base::Lock lock(_mutex);
    advance(now_s);
    _temperature_C = celsius;
    const bool hot = (_status.flags & protocol::OVER_TEMPERATURE) != 0;
    if (!hot && celsius > _options.temperatureLimit_C)
    {
        mute(protocol::OVER_TEMPERATURE, now_s);
        answerStatus(0);
    }
    else if (hot && celsius < _options.temperatureLimit_C - kCoolingBand_C)
    {
        _status.flags = protocol::MUTED;
        answerStatus(0);
    }
}

} // namespace midair::device
