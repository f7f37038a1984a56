#include "device/ArrayDevice.h"
#include "device/DeviceUri.h"
#include "device/FieldCounters.h"
#include "device/autd3/Autd3Device.h"
#include "device/boards/BoardKind.h"
#include "device/limits/DeviceClaim.h"
#include "device/limits/GuardedDevice.h"
#include "device/opening/DeviceRegistry.h"
#include "device/opening/MultiDevice.h"
#include "device/recording/PlayingDevice.h"
#include "device/recording/RecordingDevice.h"
#include "device/simulation/SimulatedArray.h"
#include "device/usb/UsbArrayDevice.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::device
{

namespace
{

/// `null:`: takes every field and holds it in memory.
class NullDevice : public ArrayDevice
{
public:
    explicit NullDevice(int transducers) : _held(transducers) {}

    bool send(const DriveSignal& signal) override
    {
        if (!signal.fits(_held.transducers()))
        {
            _counters.countRefused();
            return false;
        }
        _held.replace(signal);
        _counters.countPlayed(base::steadySeconds());
        return true;
    }
    void silence() override { _held.clear(); }
    std::string status() const override { return "null: " + countersText(report()); }
    DeviceReport report() const override { return _counters.report(); }
    std::vector<std::complex<float>> played() const override { return _held.activations(); }

private:
    HeldField _held;
    FieldCounters _counters;
};

void checkLayout(const DeviceLayout& layout)
{
    if (layout.transducers < 1)
        throw DeviceError(fmt::format("device layout: {} transducers; there must be at least 1",
                                      layout.transducers));
    for (const int i : layout.dead)
        if (i < 0 || i >= layout.transducers)
            throw DeviceError(fmt::format("device layout: dead transducer {}; they must be 0 .. {}",
                                          i,
                                          layout.transducers - 1));
    if (layout.board.empty()) return;
    if (layout.board.size() != static_cast<std::size_t>(layout.transducers))
        throw DeviceError(fmt::format(
            "device layout: board numbers for {} transducers; there must be one for each of {}",
            layout.board.size(),
            layout.transducers));
    if (layout.board.front() != 0)
        throw DeviceError(fmt::format("device layout: the first board is {}; it must be 0",
                                      layout.board.front()));
    int before = 0;
    for (const int board : layout.board)
    {
        if (board < before || board > before + 1)
            throw DeviceError(fmt::format(
                "device layout: board {} follows board {}; they must ascend from 0 without gaps",
                board,
                before));
        before = board;
    }
}

using Opener = std::unique_ptr<ArrayDevice> (*)(DeviceUri&, const DeviceLayout&);

std::unique_ptr<ArrayDevice> openSimulation(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.rejectPath();
    if (uri.takeText("board", "") == "autd3")
    {
        if (const OpenDevice& open = rehearsedAutd3()) return open(uri, layout);
        throw uri.error("this program has no emulated units; run \"midair-device emulate autd3 "
                        "--units 1 --port 44336\" and open \"autd3:?units=1&group=[::1]:44336\"");
    }
    const SimulatedArray::Options options = SimulatedArray::takeOptions(uri);
    uri.rejectUnknown();
    return std::make_unique<SimulatedArray>(layout, options);
}

std::unique_ptr<ArrayDevice> openUsb(DeviceUri& uri, const DeviceLayout& layout)
{
    const UsbArrayDevice::Options options = UsbArrayDevice::takeOptions(uri);
    uri.rejectUnknown();
    return std::make_unique<UsbArrayDevice>(layout, options);
}

std::unique_ptr<ArrayDevice> openNull(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.rejectPath();
    uri.rejectUnknown();
    return std::make_unique<NullDevice>(layout.transducers);
}

std::unique_ptr<ArrayDevice> openRecording(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.requirePath("a file");
    const bool overwrites = uri.takeFlag("overwrite", false);
    const bool continues = uri.takeFlag("continue", false);
    uri.rejectUnknown();
    const auto before = continues    ? recording::Before::CONTINUED
                        : overwrites ? recording::Before::OVERWRITTEN
                                     : recording::Before::REPLACED;
    return std::make_unique<RecordingDevice>(uri.path(), layout.transducers, before);
}

constexpr const char* kNoPointsInRecording =
    "max-pressure can't be held: a recording has no control points. Its fields were capped when "
    "they were recorded; max-amplitude caps them again";

std::unique_ptr<ArrayDevice> openList(const std::string& text,
                                      const DeviceLayout& layout,
                                      const SafetyLimits& limits,
                                      const std::string& owner = {});

// The limits are those of the target device, which is guarded.
std::unique_ptr<ArrayDevice>
openPlaying(DeviceUri& uri, const DeviceLayout& layout, const SafetyLimits& limits)
{
    uri.requirePath("a file");
    PlayingDevice::Options options;
    options.speed = uri.takeNumber("speed", 1, 0.001, 1000);
    options.loop = uri.takeFlag("loop", false);
    const std::string to = uri.takeText("to", "");
    uri.rejectUnknown();
    if (to.empty()) throw uri.error("choose a device: \"play:FILE?to=usb:\"");
    if (playsByItself(to))
        throw uri.error("a recording plays on an array, not on another recording: \"play:\" may "
                        "not stand in \"to\"");
    // Read before the other device is opened, so that a `record:` in it can't overwrite the file.
    recording::Show show(uri.path(), layout.transducers);
    std::unique_ptr<ArrayDevice> device = openList(to, layout, limits);
    if (device->ability().maxPressure_Pa > 0) throw uri.error(kNoPointsInRecording);
    return std::make_unique<PlayingDevice>(std::move(show), options, std::move(device));
}

/// A kind of device: scheme, open function, and line of help.
struct Scheme
{
    const char* name;
    Owned owned;
    Opener open;
    const char* text;
};

// In the order of the help text.
std::vector<Scheme> allSchemes()
{
    std::vector<Scheme> all = {
        {"sim",
         Owned::NOTHING,
         openSimulation,
         "sim:                    a virtual array; ?drop=0.01&unplug_at=2s&.. rehearses faults"},
        {"usb",
         Owned::HARDWARE,
         openUsb,
         "usb: or usb:SERIAL      the array over USB; ?wait=yes begins without it"},
        {"autd3",
         Owned::HARDWARE,
         openAutd3,
         "autd3:                  AUTD3 units over UDP; ?units=16&interface=eth0&.."},
    };
    for (const BoardKind& kind : boardKinds())
        all.push_back({kind.scheme, kind.owned, kind.open, kind.help});
    const Scheme others[] = {
        {"record",
         Owned::FILE,
         openRecording,
         "record:FILE             writes every field into a file; ?overwrite=yes into any"},
        {"play",
         Owned::NOTHING,
         nullptr, // openPlaying(), with the limits
         "play:FILE?to=DEVICE     plays a recording on another device; ?loop=yes&speed=2"},
        {"null", Owned::NOTHING, openNull, "null:                   takes every field"},
    };
    all.insert(all.end(), std::begin(others), std::end(others));
    return all;
}

/// Opens a device of a known kind with the limits around it.
template<typename Open>
std::unique_ptr<ArrayDevice> openWith(const Open& open,
                                      Owned owned,
                                      DeviceUri& uri,
                                      const DeviceLayout& layout,
                                      const SafetyLimits& strict,
                                      const std::string& owner)
{
    // Without an owner's name, the operating system refuses hardware in use.
    auto claim = owner.empty() ? nullptr : std::make_unique<DeviceClaim>(uri, owned, owner);
    auto device = open(uri, layout);
    return std::make_unique<GuardedDevice>(
        std::move(device), strict, layout.transducers, std::move(claim));
}

std::unique_ptr<ArrayDevice> openOne(DeviceUri& uri,
                                     const DeviceLayout& layout,
                                     const SafetyLimits& limits,
                                     const std::string& owner)
{
    const SafetyLimits strict = takeLimits(uri, limits);
    if (uri.scheme() == "play" && strict.maxPressure_Pa > 0) throw uri.error(kNoPointsInRecording);
    if (uri.scheme() == "play") return openPlaying(uri, layout, strict);
    std::vector<std::string> known;
    for (const Scheme& scheme : allSchemes())
    {
        if (uri.scheme() == scheme.name)
            return openWith(scheme.open, scheme.owned, uri, layout, strict, owner);
        known.push_back(fmt::format("{}:", scheme.name));
    }
    for (const OwnScheme& scheme : ownSchemes())
    {
        if (uri.scheme() == scheme.name)
            return openWith(scheme.open, Owned::HARDWARE, uri, layout, strict, owner);
        known.push_back(scheme.name + ":");
    }
    throw uri.error(
        fmt::format("unknown kind \"{}:\"; known are {}", uri.scheme(), fmt::join(known, ", ")));
}

// Takes `boards`, such as "0-7" or "3", from the URI: the transducers of these boards.
MultiDevice::Part partOf(DeviceUri& uri, const DeviceLayout& layout)
{
    MultiDevice::Part part;
    part.count = layout.transducers;
    const std::string boards = uri.takeText("boards", "");
    if (boards.empty()) return part;
    const int last = layout.board.empty() ? 0 : layout.board.back();
    int from = 0;
    int to = 0;
    const std::size_t dash = std::min(boards.find('-'), boards.size());
    const std::string end = dash == boards.size() ? boards : boards.substr(dash + 1);
    const bool read = base::parseWhole(boards.substr(0, dash), from) && base::parseWhole(end, to);
    if (!read || boards.find_first_not_of("0123456789-") != std::string::npos || from < 0 ||
        from > to || to > last)
        throw uri.error(fmt::format(
            "boards={} should be a board or a range of them, from 0 to {}", boards, last));
    if (layout.board.empty()) return part;
    const auto begin = std::lower_bound(layout.board.begin(), layout.board.end(), from);
    part.first = static_cast<int>(begin - layout.board.begin());
    part.count = static_cast<int>(std::upper_bound(begin, layout.board.end(), to) - begin);
    return part;
}

DeviceLayout cut(const DeviceLayout& layout, const MultiDevice::Part& part)
{
    DeviceLayout piece{part.count, {}};
    if (!layout.board.empty())
        for (int i = 0; i < part.count; ++i)
            piece.board.push_back(layout.board[part.first + i] - layout.board[part.first]);
    for (const int i : layout.dead)
        if (i >= part.first && i < part.first + part.count) piece.dead.push_back(i - part.first);
    return piece;
}

std::unique_ptr<ArrayDevice> openList(const std::string& text,
                                      const DeviceLayout& layout,
                                      const SafetyLimits& given,
                                      const std::string& owner)
{
    std::vector<MultiDevice::Part> parts;
    const std::vector<std::string> list = splitDeviceList(text);
    // An array is silent only if all its parts are: the shortest hold applies to all.
    SafetyLimits limits = given;
    for (const std::string& one : list)
    {
        DeviceUri uri(one);
        limits.hold_s = takeLimits(uri, limits).hold_s;
    }
    for (const std::string& one : list)
    {
        DeviceUri uri(one);
        parts.push_back(partOf(uri, layout));
        parts.back().device = openOne(uri, cut(layout, parts.back()), limits, owner);
    }
    if (parts.size() == 1 && parts[0].count == layout.transducers)
        return std::move(parts[0].device);
    std::vector<bool> covered(layout.transducers);
    for (const MultiDevice::Part& part : parts)
        std::fill_n(covered.begin() + part.first, part.count, true);
    const auto missing = std::find(covered.begin(), covered.end(), false);
    if (missing != covered.end())
        throw DeviceError(fmt::format("device \"{}\": no device has transducer {} of {}",
                                      text,
                                      missing - covered.begin(),
                                      layout.transducers));
    return std::make_unique<MultiDevice>(std::move(parts), layout.transducers);
}

constexpr std::size_t kMostLetters = 32;

struct Registry
{
    base::Mutex mutex;
    std::vector<OwnScheme> schemes MIDAIR_GUARDED_BY(mutex);
    OpenDevice rehearsedAutd3; ///< set before devices are opened
};

Registry& registry()
{
    static Registry all;
    return all;
}

// Letters only: a list of devices is split where letters and a colon begin the next.
bool isSchemeName(const std::string& name)
{
    return !name.empty() && name.size() <= kMostLetters &&
           std::all_of(name.begin(), name.end(), [](char c) { return c >= 'a' && c <= 'z'; });
}

bool isOneOf(const std::vector<OwnScheme>& registered, const std::string& scheme)
{
    const std::vector<std::string> kits = deviceSchemes();
    return std::find(kits.begin(), kits.end(), scheme) != kits.end() ||
           std::any_of(registered.begin(),
                       registered.end(),
                       [&](const OwnScheme& other) { return other.name == scheme; });
}

} // namespace

std::string continuedRecordings(const std::string& uri)
{
    std::vector<std::string> list = splitDeviceList(uri);
    for (std::string& one : list)
    {
        const DeviceUri part(one);
        if (part.scheme() == "record" && !part.has("continue"))
            one += (one.find('?') == std::string::npos ? "?" : "&") + std::string("continue=yes");
    }
    return fmt::format("{}", fmt::join(list, ","));
}

bool playsByItself(const std::string& uri)
{
    const std::vector<std::string> list = splitDeviceList(uri);
    return std::any_of(list.begin(),
                       list.end(),
                       [](const std::string& one) { return DeviceUri(one).scheme() == "play"; });
}

std::unique_ptr<ArrayDevice> openDevice(const std::string& uri, const DeviceLayout& layout)
{
    return openLimitedDevice(uri, layout, {});
}

std::unique_ptr<ArrayDevice> openLimitedDevice(const std::string& uri,
                                               const DeviceLayout& layout,
                                               const SafetyLimits& limits,
                                               const std::string& owner)
{
    checkLayout(layout);
    return openList(uri, layout, limits, owner);
}

std::vector<std::string> deviceSchemes()
{
    std::vector<std::string> schemes;
    for (const Scheme& scheme : allSchemes())
        schemes.emplace_back(scheme.name);
    return schemes;
}

std::string deviceKinds()
{
    std::string text;
    for (const Scheme& scheme : allSchemes())
        text += std::string(scheme.text) + "\n";
    return text;
}

bool registerScheme(OwnScheme scheme, std::string& error)
{
    if (!isSchemeName(scheme.name))
        error = "\"" + scheme.name + "\" is no scheme; it must have 1 to 32 small letters";
    else if (!scheme.open)
        error = "the scheme \"" + scheme.name + "\" has nothing that opens it";
    else
    {
        Registry& known = registry();
        const base::Lock lock(known.mutex);
        std::vector<OwnScheme>& all = known.schemes;
        if (!isOneOf(all, scheme.name))
        {
            all.push_back(std::move(scheme));
            return true;
        }
        error = "the scheme \"" + scheme.name + "\" is taken";
    }
    return false;
}

bool isKnownScheme(const std::string& scheme)
{
    return isOneOf(ownSchemes(), scheme);
}

std::vector<OwnScheme> ownSchemes()
{
    Registry& known = registry();
    const base::Lock lock(known.mutex);
    return known.schemes;
}

void setRehearsedAutd3(OpenDevice open)
{
    registry().rehearsedAutd3 = std::move(open);
}

const OpenDevice& rehearsedAutd3()
{
    return registry().rehearsedAutd3;
}

} // namespace midair::device
