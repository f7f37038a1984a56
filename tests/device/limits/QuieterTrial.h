#pragma once

#include "device/ArrayDevice.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"

#include <algorithm>
#include <complex>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

/// What is tried with each device, whose way to the hardware fails when it should become quieter.
/// What tells is the far side.
namespace midair::quieter
{

/// How it is asked to become quieter.
enum class Way
{
    CAP,
    FIELD,
    MUTE,
    SILENCE
};
/// What fails from then on.
enum class Failure
{
    DROPS, ///< what is sent, or what is answered, doesn't come
    REFUSES,
    HANGS
};

inline std::vector<Way> allWays()
{
    return {Way::CAP, Way::FIELD, Way::MUTE, Way::SILENCE};
}
inline std::vector<Failure> allFailures()
{
    return {Failure::DROPS, Failure::REFUSES, Failure::HANGS};
}
inline const char* nameOf(Way way)
{
    constexpr const char* kNames[] = {"cap", "field", "mute", "silence"};
    return kNames[static_cast<int>(way)];
}
inline const char* nameOf(Failure failure)
{
    constexpr const char* kNames[] = {"drops", "refuses", "hangs"};
    return kNames[static_cast<int>(failure)];
}

constexpr double kConfirm_s = 0.1; ///< the promise: silence is asked for within it
constexpr double kHangs_s = 1.0;   ///< and after it the state says so
constexpr double kLate_s = 0.1;    ///< of threads, beside what this one sees of it

struct FarSide
{
    std::unique_ptr<device::ArrayDevice> device;
    int transducers = 0;
    std::function<double()> loudness; ///< at the far side, any measure; 0: silence
    std::function<void()> fail;
    std::function<void()> recover;
    /// How often silence was sent on its way, as far as the way lets that be seen.
    std::function<int()> silences;
    /// The far side is quieter within this time all the same, whatever is asked for: by a second
    /// way to it, or by itself; 0: it can't be.
    double quiet_s = 0;
    bool isTold = true; ///< false: bytes are lost on a line that nobody answers on
    /// It hangs for as long as it fails; false: after a while it doesn't, since it was opened
    /// again, say.
    bool staysFaulty = true;
    int tries = 3;                  ///< silence is sent so often, at least, while it stays faulty
    double patience_s = kConfirm_s; ///< what is confirmed in
    std::vector<std::shared_ptr<void>> keep;
};

/// Full drive everywhere, or in the second half alone.
inline device::DriveSignal fieldOf(int transducers, bool isHalf)
{
    device::DriveSignal field = device::silentSignal(transducers);
    std::fill(field.duty.begin() + (isHalf ? transducers / 2 : 0), field.duty.end(), 255);
    return field;
}

inline double loudnessOf(const std::vector<std::complex<float>>& q)
{
    double sum = 0.0;
    for (const std::complex<float> one : q)
        sum += std::abs(one);
    return sum;
}
inline double loudnessOf(const device::DriveSignal& signal)
{
    double sum = 0.0;
    for (const std::uint8_t duty : signal.duty)
        sum += duty;
    return sum;
}

inline void quieten(Way way, device::ArrayDevice& device, int transducers)
{
    switch (way)
    {
    case Way::CAP:
        device.setAmplitudeCap(0.1);
        break;
    case Way::FIELD:
        device.send(fieldOf(transducers, true));
        break;
    case Way::MUTE:
        device.setMuted(true);
        break;
    case Way::SILENCE:
        device.silence();
        break;
    }
}

/// What was seen while the way fails; times since the asking, s, < 0: never.
struct Seen
{
    double loud_s = 0.0; ///< heard as loud as before, last
    double silence_s = -1.0;
    double told_s = -1.0;
    double fault_s = -1.0;
    double gap_s = 0.0; ///< the longest that nobody looked
    int silences = 0;
};

inline Seen watch(FarSide& far, double loud, int before, std::uint64_t faults, double asked_s)
{
    Seen seen;
    const double end_s = asked_s + kHangs_s + 5.0 * kConfirm_s + far.patience_s;
    double look_s = asked_s;
    for (double now_s = asked_s; now_s < end_s; now_s = base::steadySeconds())
    {
        const double since_s = now_s - asked_s;
        seen.gap_s = std::max(seen.gap_s, now_s - look_s);
        look_s = now_s;
        if (far.loudness() > 0.9 * loud) seen.loud_s = since_s;
        seen.silences = far.silences() - before;
        if (seen.silences > 0 && seen.silence_s < 0) seen.silence_s = since_s;
        const device::DeviceReport report = far.device->report();
        const bool isFault = report.state >= device::DeviceState::HANGING;
        const bool isTold = isFault || report.faults > faults || !report.quieted.empty() ||
                            !report.unsilenced.empty();
        if (isTold && seen.told_s < 0) seen.told_s = since_s;
        if (isFault && seen.fault_s < 0) seen.fault_s = since_s;
        letPass(5e-4);
    }
    return seen;
}

inline std::string wrongOf(const FarSide& far, const Seen& seen)
{
    const double late_s = kLate_s + seen.gap_s;
    const auto isLate = [&](double at_s, double due_s)
    { return at_s < 0 || at_s > due_s + late_s; };
    if (far.quiet_s > 0 && isLate(seen.loud_s, far.quiet_s))
        return fmt::format("is as loud as before {:.0f} ms after it was asked", 1e3 * seen.loud_s);
    if (!far.isTold) return "";
    // A device that is lost by then gets nothing more, and what falls silent by itself needs none.
    const bool isLost = far.quiet_s > 0 && !isLate(seen.fault_s, far.patience_s);
    if (!isLost && isLate(seen.silence_s, far.patience_s))
        return fmt::format("silence is first sent after {:.0f} ms", 1e3 * seen.silence_s);
    if (isLate(seen.told_s, std::max(far.patience_s, far.quiet_s)))
        return fmt::format("is told after {:.0f} ms", 1e3 * seen.told_s);
    if (!far.staysFaulty) return "";
    if (isLate(seen.fault_s, far.patience_s + kHangs_s))
        return fmt::format("is a fault after {:.0f} ms", 1e3 * seen.fault_s);
    if (!isLost && seen.silences < far.tries)
        return fmt::format("silence is sent {} times", seen.silences);
    return "";
}

/// Plays loudly, lets the way fail, asks for something quieter and looks; then the way works again.
/// Returns what is wrong; empty: nothing.
inline std::string trial(Way way, FarSide far)
{
    device::ArrayDevice& device = *far.device;
    device.send(fieldOf(far.transducers, false));
    const bool isSettled = eventually(
        [&]
        { return far.loudness() > 0 && device.report().pending == 0 && device.confirmed_s() > 0; });
    if (!isSettled) return "never sounds: " + device.status();
    const double loud = far.loudness();
    const int before = far.silences();
    const std::uint64_t faults = device.report().faults;
    far.fail();
    const double asked_s = base::steadySeconds();
    quieten(way, device, far.transducers);
    const Seen seen = watch(far, loud, before, faults, asked_s);
    const std::string wrong = wrongOf(far, seen);
    if (!wrong.empty()) return wrong + ": " + device.status();
    far.recover();
    if (far.isTold && !eventually([&] { return far.loudness() < 0.9 * loud; }))
        return "stays loud when its way works again: " + device.status();
    device.setMuted(false);
    device.setAmplitudeCap(1);
    const auto isBack = [&]
    {
        device.send(fieldOf(far.transducers, false));
        return eventually([&] { return far.loudness() > 0.9 * loud; }, 0.2);
    };
    if (!eventually(isBack)) return "doesn't play again: " + device.status();
    const auto isWell = [&]
    {
        const device::DeviceReport report = device.report();
        return report.state == device::DeviceState::READY && report.quieted.empty() &&
               report.unsilenced.empty();
    };
    return eventually(isWell) ? "" : "still tells of it: " + device.status();
}

} // namespace midair::quieter
