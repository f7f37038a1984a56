#pragma once

#include "device/recording/PlayingDevice.h"
#include "device/recording/Recording.h"
#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/contact/ContactScenes.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

/// What is tried with each device: a program leads, and then its frames hang while all its other
/// threads run on. What tells is the far side of the device.
namespace midair::holds
{

constexpr double kHold_s = 0.3;
constexpr double kLate_s = 0.05; ///< the promise: silent within this time after the hold

/// What is played, and so which thread goes on sending by itself.
enum class Mode
{
    HELD,
    EVENED, ///< a held field that is being walked to an even one
    CYCLE,
    SUBSETS,
    OUTLINE,
    MODULATION,
    CONTACT,
    IN_TURN, ///< a sequence that a device with a clock of its own would keep
    RECORDING
};

inline const char* nameOf(Mode mode)
{
    constexpr const char* kNames[] = {"held",
                                      "evened",
                                      "cycle",
                                      "subsets",
                                      "outline",
                                      "modulation",
                                      "contact",
                                      "in_turn",
                                      "recording"};
    return kNames[static_cast<int>(mode)];
}

inline std::vector<Mode> allModes()
{
    return {Mode::HELD,
            Mode::EVENED,
            Mode::CYCLE,
            Mode::SUBSETS,
            Mode::OUTLINE,
            Mode::MODULATION,
            Mode::CONTACT,
            Mode::IN_TURN,
            Mode::RECORDING};
}

/// The first transducers of the octagon: all of a scene in its middle is in their reach.
inline haptics::TransducerArray arrayOf(int transducers)
{
    haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    array.positions = array.positions.leftCols(transducers).eval();
    array.normals = array.normals.leftCols(transducers).eval();
    array.board.assign(static_cast<std::size_t>(transducers), 0);
    return array;
}

using Open = std::function<std::unique_ptr<device::ArrayDevice>(const device::DeviceLayout&)>;

inline bridge::HologramOptions optionsOf(Mode mode, const Open& open, int transducers)
{
    bridge::HologramOptions options;
    options.array = arrayOf(transducers);
    options.deviceFactory = [open](const std::string&, const device::DeviceLayout& layout)
    { return open(layout); };
    if (mode != Mode::EVENED) options.even = 0;
    if (mode == Mode::CYCLE) options.cycle = 4;
    if (mode == Mode::SUBSETS) options.subsets = 3;
    if (mode == Mode::MODULATION) options.modulation.amplitudeRate_Hz = 10.0;
    if (mode == Mode::CONTACT) options.contacts.shares.render = bridge::Render::CONTACT;
    if (mode == Mode::IN_TURN) options.subsets = 2;
    return options;
}

/// All frames show the same.
inline bridge::SceneSnapshot frameOf(Mode mode)
{
    static const auto kSmall = bridge::test::sheet(10);
    static const auto kLarge = bridge::test::sheet();
    bridge::SceneSnapshot snapshot;
    snapshot.time_s = base::steadySeconds();
    snapshot.objects = {bridge::test::object(mode == Mode::CONTACT ? kLarge : kSmall)};
    snapshot.objects[0].path = "Scene/Sheet";
    if (mode == Mode::CONTACT) snapshot.hands = bridge::test::ball({0.0, 0.0, 6.5e-3});
    if (mode == Mode::OUTLINE) snapshot.objects[0].properties.sampling = haptics::Sampling::EDGES;
    return snapshot;
}

/// A loud field every 5 ms for a minute, as a recording.
inline std::string recordedShow(const std::string& file, int transducers)
{
    device::recording::Writer writer(transducers);
    std::ofstream out(file, std::ios::binary);
    const auto put = [&](const std::vector<std::uint8_t>& bytes)
    {
        out.write(reinterpret_cast<const char*>(bytes.data()),
                  static_cast<std::streamsize>(bytes.size()));
    };
    put(writer.header(0));
    device::DriveSignal field = device::silentSignal(transducers);
    std::fill(field.duty.begin(), field.duty.end(), 255);
    constexpr std::uint64_t kStep_ns = 5'000'000;
    for (std::uint64_t k = 0; k < 12'000; ++k)
    {
        field.phase.assign(field.phase.size(), static_cast<std::uint8_t>(k % 2 * 128));
        put(writer.field(k * kStep_ns, field));
    }
    put(writer.mark(12'000 * kStep_ns, device::recording::Kind::END));
    return file;
}

/// A program that leads by frames: beat() is one of them, and its only sign of life.
struct Led
{
    std::function<void()> beat;
    std::shared_ptr<void> keep;
    std::function<bool()> isThere = [] { return true; }; ///< it plays what the mode is about
};

inline Led lead(Mode mode, const Open& open, int transducers, const std::string& file)
{
    if (mode == Mode::RECORDING)
    {
        device::DeviceLayout layout{transducers, {}, {}};
        auto playing = std::make_shared<device::PlayingDevice>(
            device::recording::Show(recordedShow(file, transducers), transducers),
            device::PlayingDevice::Options(),
            open(layout));
        return {[playing] { playing->keepAlive(); }, playing};
    }
    auto thread = std::make_shared<bridge::HologramThread>(optionsOf(mode, open, transducers));
    Led led{[thread, mode]
            {
                auto snapshot = frameOf(mode);
                thread->submit(snapshot);
                thread->keepAlive();
            },
            thread};
    if (mode == Mode::EVENED) led.isThere = [thread] { return thread->counters().walked > 5; };
    return led;
}

/// Leads until \a sounds has said so for a while, stops, and looks at what sounds afterwards. What
/// \a open opens has to have the hold. Returns what is wrong; empty: nothing.
inline std::string trial(Mode mode,
                         const Open& open,
                         int transducers,
                         const std::string& file,
                         const std::function<bool()>& sounds)
{
    const auto pause = [] { letPass(5e-4); };
    const auto now = [] { return base::steadySeconds(); };
    const Led led = lead(mode, open, transducers, file);
    // Until it has sounded in ten frames: cycles and outlines come after the first field.
    double sign_s = 0.0;
    int heard = 0;
    for (const double end_s = now() + 60.0; heard < 10 && now() < end_s;)
    {
        led.beat();
        sign_s = now();
        bool any = false;
        while (now() - sign_s < 0.05)
        {
            any = sounds() || any;
            pause();
        }
        heard += any && (heard < 9 || led.isThere()) ? 1 : 0;
    }
    if (heard < 10) return "never sounds";
    led.beat();
    sign_s = now();
    double last_s = 0.0; // when it was heard last
    double gap_s = 0.0;  // the longest that nobody listened
    for (double look_s = sign_s; look_s < sign_s + kHold_s + 0.5;)
    {
        if (sounds()) last_s = now();
        pause();
        gap_s = std::max(gap_s, now() - look_s);
        look_s = now();
    }
    // Where nobody listened for that long, nobody knows.
    if (last_s + gap_s < sign_s + 0.5 * kHold_s)
        return fmt::format("is silent {:.0f} ms after the sign, before the hold",
                           1e3 * (last_s - sign_s));
    if (last_s > sign_s + kHold_s + kLate_s + gap_s)
        return fmt::format("sounds {:.0f} ms after the last sign of life (heard every {:.0f} ms)",
                           1e3 * (last_s - sign_s),
                           1e3 * gap_s);
    bool isBack = false;
    for (const double end_s = now() + 60.0; !isBack && now() < end_s;)
    {
        led.beat();
        for (const double until_s = now() + 0.02; now() < until_s; pause())
            isBack = sounds() || isBack;
    }
    return isBack ? "" : "doesn't sound again when it is led again";
}

} // namespace midair::holds
