// Fields on emulated AUTD3 units: how many a second, how late, and whether any of them is torn.

#include "device/autd3/Autd3Device.h"
#include "device/autd3/emulator/EmulatedLink.h"
#include "device/autd3/emulator/UdpUnits.h"
#include "device/drive/DriveSignal.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/benchmarks/Timing.h"
#include "tests/benchmarks/autd3/BareDatagrams.h"
#include "tests/benchmarks/autd3/VirtualFields.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace midair;
using namespace midair::device;
using namespace midair::device::autd3;
using emulation::EmulatedChain;
using emulation::EmulatedLink;
using emulation::EmulatedUnits;
using emulation::Time_ns;

namespace
{

constexpr const char* kSequence = "sequence";

/// What is common to all parts.
struct Settings
{
    int units = 16;
    double duration_s = 3;
    double loss = 0.01;
};

/// One part of the benchmark.
struct Case
{
    const char* name;
    bool timed = true;
    bool isEven = false; ///< fields of one intensity
    double lead_s = 3e-3;
    double loss = 0;
    bool isRealistic = false; ///< a cable of 100 Mbit/s, and units' processors that take time
    double fields_Hz = 0;     ///< 0: as fast as they are taken
};

void write(int to, const void* bytes, std::size_t size)
{
    if (::write(to, bytes, size) != static_cast<ssize_t>(size)) std::_Exit(1);
}

/// Units behind UDP ports, in a process of their own, so that their time isn't the device's.
class Units
{
public:
    explicit Units(const emulation::ChainOptions& options)
    {
        int ends[2];
        if (::pipe(ends) != 0) std::_Exit(1);
        _process = ::fork();
        if (_process == 0) emulate(options, ends[1]);
        ::close(ends[1]);
        _pipe = ends[0];
        if (::read(_pipe, &_port, sizeof _port) != sizeof _port) std::_Exit(1);
    }
    ~Units()
    {
        ::kill(_process, SIGKILL);
        ::waitpid(_process, nullptr, 0);
        ::close(_pipe);
    }
    Units(const Units&) = delete;
    Units& operator=(const Units&) = delete;

    int port() const { return _port; }

private:
    [[noreturn]] static void emulate(const emulation::ChainOptions& options, int to)
    {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        emulation::UdpUnits units(options, 0);
        const int port = units.port();
        write(to, &port, sizeof port);
        units.run(std::numeric_limits<Time_ns>::max());
        std::_Exit(0);
    }

    pid_t _process = -1;
    int _pipe = -1;
    int _port = 0;
};

emulation::ChainOptions chainOf(const Settings& settings, const Case& what)
{
    emulation::ChainOptions chain = emulation::ChainOptions::realistic(settings.units);
    chain.boot_ns = 0;
    chain.settle_ns = 50 * emulation::kMillisecond_ns;
    chain.faults.drop = what.loss;
    // At once, units are apart by what the host and the network are.
    if (!what.timed) chain.tolerance_ns = emulation::kMillisecond_ns;
    if (!what.isRealistic) chain.wirePerByte_ns = chain.perFrame_ns = chain.perWord_ns = 0;
    return chain;
}

Autd3Options optionsOf(const Settings& settings, const Case& what)
{
    Autd3Options options;
    options.units = settings.units;
    for (int k = 0; k < settings.units; ++k)
        options.order.push_back(k);
    options.silent.resize(static_cast<std::size_t>(settings.units));
    options.silencer = {1, 1};
    options.timed = what.timed;
    options.lead_s = what.lead_s;
    return options;
}

/// Units in this program, which know the fields that they are to play, and the device on them.
struct Stage
{
    Stage(const Settings& settings, const Case& what)
    {
        emulation::ChainOptions chain = chainOf(settings, what);
        chain.faults = {};
        units = std::make_shared<EmulatedUnits>(chain);
        device = std::make_unique<Autd3Device>(
            DeviceLayout{settings.units * kTransducersPerUnit, {}},
            optionsOf(settings, what),
            false,
            [this](const std::function<bool()>&) { return std::make_unique<EmulatedLink>(units); });
        chain.faults.drop = what.loss;
        units->with(
            [&](EmulatedChain& c, Time_ns)
            {
                c.setFaults(chain.faults);
                return 0;
            });
    }

    std::shared_ptr<EmulatedUnits> units;
    std::unique_ptr<Autd3Device> device;
};

DriveSignal fieldOf(int transducers, unsigned number, bool isEven)
{
    DriveSignal signal = silentSignal(transducers);
    for (std::size_t i = 0; i < signal.phase.size(); ++i)
    {
        signal.phase[i] = static_cast<std::uint8_t>(7 * i + 11 * number + number / 256);
        signal.duty[i] =
            isEven ? std::uint8_t{255} : static_cast<std::uint8_t>(1 + (i + number) % 255);
    }
    return signal;
}

void pause(double time_s)
{
    std::this_thread::sleep_for(std::chrono::duration<double>(time_s));
}

void playFields(const Settings& settings, const Case& what)
{
    Stage stage(settings, what);
    std::vector<double> latencies_ms;
    const double begin_s = base::steadySeconds();
    double lastHandedOver_s = 0;
    for (unsigned n = 1; base::steadySeconds() - begin_s < settings.duration_s; ++n)
    {
        const DriveSignal signal = fieldOf(settings.units * kTransducersPerUnit, n, what.isEven);
        stage.units->with(
            [&](EmulatedChain& chain, Time_ns)
            {
                chain.watch().expect(n, signal);
                return 0;
            });
        stage.device->send(signal);
        if (what.fields_Hz > 0) pause(begin_s + n / what.fields_Hz - base::steadySeconds());
        // One waits, so that the thread never does.
        while (what.fields_Hz == 0 && stage.device->report().pending > 1)
            pause(50e-6);
        const DeviceReport report = stage.device->report();
        if (report.lastHandedOver_s > lastHandedOver_s)
            latencies_ms.push_back(report.latency_s * 1e3);
        lastHandedOver_s = report.lastHandedOver_s;
    }
    const double took_s = base::steadySeconds() - begin_s;
    const DeviceReport report = stage.device->report();
    pause(0.1);
    const Autd3Device::Figures figures = stage.device->figures();
    const emulation::ChainReport seen = stage.units->with([](EmulatedChain& chain, Time_ns now_ns)
                                                          { return chain.report(now_ns); });
    std::printf("%-32s %5.0f %5llu %7.1f %4llu %4llu %7.1f %7.2f %7.2f %7.1f %7llu\n",
                what.name,
                static_cast<double>(report.played) / took_s,
                static_cast<unsigned long long>(seen.fields.torn),
                static_cast<double>(seen.fields.longestTear_ns) * 1e-6,
                static_cast<unsigned long long>(report.lost),
                static_cast<unsigned long long>(seen.writesIntoBanks + seen.writesIntoSlots +
                                                seen.fields.unknown),
                static_cast<double>(seen.fields.worstSkew_ns) * 1e-3,
                base::percentile(latencies_ms, 0.5),
                base::percentile(latencies_ms, 0.99),
                figures.lead_s * 1e3,
                static_cast<unsigned long long>(figures.takenBack));
    std::fflush(stdout);
}

void playSequence(const Settings& settings, double heartbeat_s, double failsafe_s, bool isNamed)
{
    const Case what = {kSequence};
    const Units units(chainOf(settings, what));
    Autd3Options options = optionsOf(settings, what);
    options.heartbeat_s = heartbeat_s;
    options.failsafe_s = failsafe_s;
    options.isHeartbeatNamed = isNamed;
    options.group = "[::1]:" + std::to_string(units.port());
    Autd3Device device({settings.units * kTransducersPerUnit, {}}, options);
    DriveSequence sequence;
    sequence.rate_Hz = 1000;
    for (unsigned n = 0; n < 100; ++n)
        sequence.signals.push_back(fieldOf(settings.units * kTransducersPerUnit, n, false));
    device.sendSequence(sequence);
    while (device.report().pending > 0)
        pause(1e-3);
    pause(0.5);
    const double before_s = device.figures().cpu_s;
    const double begin_s = base::steadySeconds();
    pause(settings.duration_s);
    const double used_s = device.figures().cpu_s - before_s;
    const double share = used_s / (base::steadySeconds() - begin_s);
    const double bare = bareDatagrams(settings.units, options.restBeat_s(), settings.duration_s);
    std::printf("  heartbeat %4.0f ms, fail-safe %4.0f ms: %.3f %% of a core; as many datagrams by "
                "themselves: %.3f %%\n",
                options.restBeat_s() * 1e3,
                failsafe_s * 1e3,
                100 * share,
                100 * bare);
}

} // namespace

int main(int argc, char** argv)
{
    Settings settings;
    CLI::App app("Measures fields on AUTD3 units emulated in this program, and a sequence on "
                 "emulated units over UDP");
    app.add_option("--units", settings.units, "number of units")->check(CLI::Range(1, kMostUnits));
    app.add_option("--duration", settings.duration_s, "duration of each part, s")
        ->check(CLI::Range(0.5, 86400.0));
    app.add_option("--loss", settings.loss, "share of datagrams lost, where some are")
        ->check(CLI::Range(0.0, 0.2));
    std::string only;
    app.add_option("--only", only, "the one part of this name");
    bool isVirtual = false;
    app.add_flag("--virtual",
                 isVirtual,
                 "in virtual time: as fast as the processor plays it, without its pauses");
    CLI11_PARSE(app, argc, argv);
    std::printf("%d units, %d transducers, %g s each\n",
                settings.units,
                settings.units * kTransducersPerUnit,
                settings.duration_s);
    if (isVirtual)
    {
        playVirtualFields(settings.units, settings.duration_s, settings.loss);
        return 0;
    }
    std::printf("fields/s played; torn: units play different fields for over 50 us, at once 1 ms, "
                "the longest; lost;\nbad: writes into a bank that plays or waits to, and what "
                "nobody sent; skew of what "
                "is whole; from send() until the switch is\nsent, ms; the lead at the end; "
                "switches that were put off\n");
    std::printf("%-32s %5s %5s %7s %4s %4s %7s %7s %7s %7s %7s\n",
                "",
                "/s",
                "torn",
                "ms",
                "lost",
                "bad",
                "skew/us",
                "p50",
                "p99",
                "lead/ms",
                "put off");
    const Case cases[] = {
        {"timed, lead 1 ms", true, false, 1e-3},
        {"timed, lead 1 ms, phases only", true, true, 1e-3},
        {"timed, lead 3 ms", true, false, 3e-3},
        {"timed, lead 3 ms, with loss", true, false, 3e-3, settings.loss},
        {"timed, lead 1 ms, with loss", true, false, 1e-3, settings.loss},
        {"timed, 100 fields/s", true, false, 3e-3, 0, false, 100},
        {"timed, 100 Mbit/s, lead 3 ms", true, false, 3e-3, 0, true},
        {"at once", false, false, 3e-3},
        {"at once, with loss", false, false, 3e-3, settings.loss},
        {"at once, 100 Mbit/s", false, false, 3e-3, 0, true},
    };
    for (const Case& one : cases)
        if (only.empty() || only == one.name) playFields(settings, one);
    if (!only.empty() && only != kSequence) return 0;
    std::printf("a sequence on board, 100 fields at 1 kHz, of units that another process emulates, "
                "over UDP: what\nthe device's thread uses of the processor\n");
    playSequence(settings, 10e-3, 0.1, true);
    playSequence(settings, 10e-3, 0.1, false);
    playSequence(settings, 10e-3, 0.3, false);
    playSequence(settings, 10e-3, 1, false);
    playSequence(settings, 1, 5, true);
    return 0;
}
