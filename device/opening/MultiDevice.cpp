#include "device/opening/MultiDevice.h"

#include "device/DeviceUri.h"
#include "device/FieldCounters.h"
#include "device/limits/GuardedDevice.h"

#include <algorithm>
#include <cctype>
#include <limits>

#include <fmt/format.h>

namespace midair::device
{

std::vector<std::string> splitDeviceList(const std::string& text)
{
    if (text.size() > kMostUriCharacters)
        throw DeviceError(fmt::format("device \"{}..\": has {} characters, should have at most {}",
                                      text.substr(0, 40),
                                      text.size(),
                                      kMostUriCharacters));
    std::vector<std::string> parts;
    std::size_t begin = 0;
    for (std::size_t comma = text.find(','); comma != std::string::npos;
         comma = text.find(',', comma + 1))
    {
        // A comma may be part of a file's name; letters and a colon after it begin a new device.
        std::size_t end = comma + 1;
        while (end < text.size() && std::isalpha(static_cast<unsigned char>(text[end])) != 0)
            ++end;
        if (end == comma + 1 || end == text.size() || text[end] != ':') continue;
        const std::string part = text.substr(begin, comma - begin);
        // the value of "to" is itself a list, which takes the rest
        if (part.find("?to=") != std::string::npos || part.find("&to=") != std::string::npos)
            continue;
        parts.push_back(part);
        begin = comma + 1;
    }
    parts.push_back(text.substr(begin));
    if (parts.size() > kMostDevices)
        throw DeviceError(
            fmt::format("device \"{}..\": is a list of {} devices, should be at most {}",
                        text.substr(0, 40),
                        parts.size(),
                        kMostDevices));
    return parts;
}

MultiDevice::MultiDevice(std::vector<Part> parts, int transducers) :
    _parts(std::move(parts)),
    _transducers(transducers),
    _staging(static_cast<int>(std::count_if(
        _parts.begin(), _parts.end(), [](const Part& part) { return part.device->canStage(); }))),
    _cuts(_parts.size())
{
}

// Notes the skew of the last field when all devices have handed it over. Joints measure their own.
void MultiDevice::measureSkew() const
{
    if (_staging > 1) return;
    double first = std::numeric_limits<double>::infinity();
    double last = 0;
    for (const Part& part : _parts)
    {
        const DeviceReport report = part.device->report();
        if (report.state != DeviceState::READY || report.pending > 0 ||
            report.lastHandedOver_s == 0)
            return;
        first = std::min(first, report.lastHandedOver_s);
        last = std::max(last, report.lastHandedOver_s);
    }
    _skew->note(last - first);
}

void MultiDevice::cut(const DriveSignal& signal, const Part& part, DriveSignal& piece)
{
    const auto first = static_cast<std::ptrdiff_t>(part.first);
    piece.phase.assign(signal.phase.begin() + first, signal.phase.begin() + first + part.count);
    piece.duty.assign(signal.duty.begin() + first, signal.duty.begin() + first + part.count);
}

bool MultiDevice::sendUnled(const DriveSignal& signal)
{
    const base::Lock lock(_mutex);
    if (!signal.fits(_transducers))
    {
        ++_refused;
        return false;
    }
    measureSkew(); // of the last field, which has usually been handed over by now
    // Splits all first, so that the sends follow each other closely.
    for (std::size_t i = 0; i < _parts.size(); ++i)
        cut(signal, _parts[i], _cuts[i]);
    // A single staging device has no other to wait for.
    const auto joint = _staging > 1 ? std::make_shared<JointCommit>(_staging, _skew) : nullptr;
    bool taken = true;
    for (std::size_t i = 0; i < _parts.size(); ++i)
    {
        ArrayDevice& device = *_parts[i].device;
        taken = device.sendTogether(_cuts[i], device.canStage() ? joint : nullptr) && taken;
    }
    return taken;
}

bool MultiDevice::setAmplitudeCap(double amplitude)
{
    bool all = true;
    for (const Part& part : _parts)
        all = part.device->setAmplitudeCap(amplitude) && all;
    return all;
}

void MultiDevice::keepAlive()
{
    for (const Part& part : _parts)
        part.device->keepAlive();
}

void MultiDevice::follow(const std::shared_ptr<Lead>& lead)
{
    for (const Part& part : _parts)
        part.device->follow(lead);
}

bool MultiDevice::isHoldOver() const
{
    return std::any_of(
        _parts.begin(), _parts.end(), [](const Part& part) { return part.device->isHoldOver(); });
}

double MultiDevice::confirmed_s() const
{
    double all_s = std::numeric_limits<double>::infinity();
    for (const Part& part : _parts)
        all_s = std::min(all_s, part.device->confirmed_s());
    return all_s;
}

void MultiDevice::silence()
{
    for (const Part& part : _parts)
        part.device->silence();
}

void MultiDevice::setMuted(bool muted)
{
    for (const Part& part : _parts)
        part.device->setMuted(muted);
}

std::string MultiDevice::status() const
{
    std::string text;
    for (const Part& part : _parts)
        text += (text.empty() ? "" : " | ") + part.device->status();
    return text;
}

// Sums all devices' counters, with the state and message of the first device in the worst state.
DeviceReport MultiDevice::report() const
{
    const base::Lock lock(_mutex);
    measureSkew();
    DeviceReport sum;
    for (const Part& part : _parts)
    {
        const DeviceReport one = part.device->report();
        if (sum.shortfall.empty()) sum.shortfall = one.shortfall;
        if (sum.unsilenced.empty()) sum.unsilenced = one.unsilenced;
        if (sum.quieted.empty()) sum.quieted = one.quieted;
        if (sum.complaint.empty()) sum.complaint = one.complaint;
        if (one.state > sum.state)
        {
            sum.state = one.state;
            sum.message = one.message;
        }
        if (sum.message.empty()) sum.message = one.message;
        sum.sent += one.sent;
        sum.played += one.played;
        sum.dropped += one.dropped;
        sum.lost += one.lost;
        sum.refused += one.refused;
        sum.pending += one.pending;
        sum.faults += one.faults;
        sum.reconnects += one.reconnects;
        sum.silences += one.silences;
        sum.lastHandedOver_s = std::max(sum.lastHandedOver_s, one.lastHandedOver_s);
        sum.latency_s = std::max(sum.latency_s, one.latency_s);
        sum.temperature_C = std::max(sum.temperature_C, one.temperature_C);
        if (sum.firmware.empty()) sum.firmware = one.firmware;
    }
    sum.sent += _refused;
    sum.refused += _refused;
    sum.skew_s = _skew->read().last_s;
    sum.worstSkew_s = _skew->read().worst_s;
    return sum;
}

DriveAbility MultiDevice::ability() const
{
    DriveAbility coarsest;
    double maxAmplitude = 0;
    for (const Part& part : _parts)
    {
        const DriveAbility one = part.device->ability();
        coarsest.phaseLevels = std::min(coarsest.phaseLevels, one.phaseLevels);
        coarsest.maxPressure_Pa = stricterCap(coarsest.maxPressure_Pa, one.maxPressure_Pa);
        if (!one.amplitudes.empty() &&
            (coarsest.amplitudes.empty() || one.amplitudes.size() < coarsest.amplitudes.size()))
            coarsest.amplitudes = one.amplitudes;
        maxAmplitude = std::max(maxAmplitude, one.maxAmplitude);
        coarsest.fades = coarsest.fades || one.fades;
        coarsest.ringing_s = std::max(coarsest.ringing_s, one.ringing_s);
        if (one.fieldsPerSecond > 0)
            coarsest.fieldsPerSecond = coarsest.fieldsPerSecond > 0
                                           ? std::min(coarsest.fieldsPerSecond, one.fieldsPerSecond)
                                           : one.fieldsPerSecond;
    }
    coarsest.maxAmplitude = maxAmplitude;
    // For each transducer the first device that has it; devices that have all transducers, such as
    // an array and its recording, are one part.
    std::vector<int> part(static_cast<std::size_t>(_transducers), 0);
    for (std::size_t k = _parts.size(); k-- > 0;)
        std::fill_n(part.begin() + _parts[k].first, _parts[k].count, static_cast<int>(k));
    if (std::any_of(part.begin(), part.end(), [&](int k) { return k != part.front(); }))
        coarsest.part = std::move(part);
    return coarsest;
}

bool MultiDevice::identify(int board, bool light)
{
    bool any = false;
    for (const Part& part : _parts)
        any = part.device->identify(board, light) || any;
    return any;
}

// If several devices have a transducer, the first in the list counts.
template<typename Play>
std::vector<std::complex<float>> MultiDevice::join(Play&& play) const
{
    std::vector<std::complex<float>> q(_transducers);
    for (auto part = _parts.rbegin(); part != _parts.rend(); ++part)
    {
        const auto piece = play(*part);
        std::copy(piece.begin(), piece.end(), q.begin() + part->first);
    }
    return q;
}

std::vector<std::complex<float>> MultiDevice::played() const
{
    return join([](const Part& part) { return part.device->played(); });
}

// A change in one of them makes a new field of all.
std::vector<PlayedField> MultiDevice::playedSince(double from_s) const
{
    if (_parts.front().count == _transducers) return _parts.front().device->playedSince(from_s);
    std::vector<std::vector<PlayedField>> pieces;
    std::vector<double> times_s;
    double begin_s = 0; // of the last to begin
    for (const Part& part : _parts)
    {
        pieces.push_back(part.device->playedSince(from_s));
        if (pieces.back().empty()) return {};
        begin_s = std::max(begin_s, pieces.back().front().since_s);
        for (const PlayedField& piece : pieces.back())
            times_s.push_back(piece.since_s);
    }
    std::sort(times_s.begin(), times_s.end());
    times_s.erase(std::unique(times_s.begin(), times_s.end()), times_s.end());
    std::vector<PlayedField> fields;
    for (const double time_s : times_s)
    {
        if (time_s < begin_s) continue;
        const auto sounding = [&](const Part& part)
        {
            const auto& all = pieces[static_cast<std::size_t>(&part - _parts.data())];
            const auto next =
                std::upper_bound(all.begin(),
                                 all.end(),
                                 time_s,
                                 [](double t, const PlayedField& one) { return t < one.since_s; });
            return (next - 1)->q;
        };
        fields.push_back({time_s, join(sounding)});
    }
    return fields;
}

std::vector<std::complex<float>> MultiDevice::wouldPlay(const DriveSignal& signal) const
{
    return join(
        [&](const Part& part)
        {
            DriveSignal piece;
            cut(signal, part, piece);
            return part.device->wouldPlay(piece);
        });
}

} // namespace midair::device
