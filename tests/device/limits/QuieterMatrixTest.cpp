// Boards on a line and AUTD3 units whose way fails at the quieter field, or the silence.
#include "device/DeviceUri.h"
#include "device/autd3/emulator/EmulatedLink.h"
#include "device/boards/BoardDevice.h"
#include "device/boards/BoardKind.h"
#include "device/limits/GuardedDevice.h"
#include "device/opening/MultiDevice.h"
#include "device/simulation/VirtualBoard.h"
#include "tests/device/autd3/Rehearsal.h"
#include "tests/device/boards/BoardEmulator.h"
#include "tests/device/limits/QuieterTrial.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::device;
using quieter::Failure;
using quieter::FarSide;
using quieter::Way;

namespace
{

/// A serial line with a board at its end, and the computer's buffer before it, as a USB serial
/// adapter has one: what hangs takes bytes until that is full.
class Line
{
public:
    Line(const std::string& board, int transducers) :
        _board(makeVirtualBoard(board, transducers)),
        _sent(makeVirtualBoard(board, transducers))
    {
    }

    bool write(const std::vector<std::uint8_t>& bytes)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _sent->receive(bytes.data(), bytes.size());
        if (quieter::loudnessOf(_sent->playing()) == 0.0) ++_silences;
        if (_fails && _how == Failure::REFUSES) return false;
        if (_fails && _how == Failure::DROPS)
        {
            _fails = false;
            return true;
        }
        _waiting.insert(_waiting.end(), bytes.begin(), bytes.end());
        if (!_fails) carry();
        return _waiting.size() < kBuffer;
    }
    std::size_t unsent()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _waiting.size();
    }
    void discard()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _waiting.clear();
    }
    void fail(Failure how)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _how = how;
        _fails = true;
    }
    void recover()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _fails = false;
        carry();
    }
    double loudness()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return quieter::loudnessOf(_board->playing());
    }
    int silences()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _silences;
    }

private:
    static constexpr std::size_t kBuffer = 65536;

    void carry()
    {
        _board->receive(_waiting.data(), _waiting.size());
        _waiting.clear();
    }

    std::mutex _mutex;
    const std::unique_ptr<VirtualBoard> _board;
    const std::unique_ptr<VirtualBoard> _sent; ///< as if all came at once
    std::vector<std::uint8_t> _waiting;
    Failure _how = Failure::DROPS;
    bool _fails = false;
    int _silences = 0;
};

class LineSink : public ByteSink
{
public:
    explicit LineSink(std::shared_ptr<Line> line) : _line(std::move(line)) {}
    bool write(const std::vector<std::uint8_t>& bytes) override
    {
        if (_line->write(bytes)) return true;
        _error = "takes no more bytes";
        return false;
    }
    void discard() override { _line->discard(); }
    std::size_t unsent() const override { return _line->unsent(); }

private:
    const std::shared_ptr<Line> _line;
};

// What is lost on a line nobody knows; it is sent again five times a second.
FarSide onALine(const std::string& board, Failure how, bool isListed)
{
    const int transducers = board == "ultraino" ? 64 : 256;
    const auto line = std::make_shared<Line>(board, transducers);
    FarSide far;
    far.transducers = transducers;
    far.device = std::make_unique<GuardedDevice>(
        std::make_unique<BoardDevice>(board + ":",
                                      makeBoardCodec(board),
                                      transducers,
                                      [line](const std::vector<std::uint8_t>&)
                                      { return std::make_unique<LineSink>(line); }),
        SafetyLimits(),
        transducers);
    const double rate = far.device->ability().fieldsPerSecond;
    far.patience_s = std::max(quieter::kConfirm_s, rate > 0 ? 2.5 / rate : 0.0);
    if (isListed)
    {
        std::vector<MultiDevice::Part> parts;
        parts.push_back({openDevice("null:", {transducers, {}}), 0, transducers});
        parts.push_back({std::move(far.device), 0, transducers});
        far.device = std::make_unique<MultiDevice>(std::move(parts), transducers);
    }
    far.loudness = [line] { return line->loudness(); };
    far.silences = [line] { return line->silences(); };
    far.fail = [line, how] { line->fail(how); };
    far.recover = [line] { line->recover(); };
    far.isTold = how != Failure::DROPS;
    if (how == Failure::DROPS) far.quiet_s = 0.5;
    return far;
}

/// The way to emulated units, at which the masks are counted that leave nothing.
class MaskWatch : public autd3::DatagramLink
{
public:
    MaskWatch(std::shared_ptr<emulation::EmulatedUnits> units,
              std::shared_ptr<std::atomic<int>> masks) :
        _link(std::move(units)),
        _masks(std::move(masks))
    {
    }
    std::string name() const override { return _link.name(); }
    double now_s() const override { return _link.now_s(); }
    bool send(const autd3::Endpoint& to, const std::vector<std::uint8_t>& bytes) override
    {
        static const std::vector<std::uint8_t> kSilence =
            autd3::frame(0, 0, autd3::Command::silenceAll());
        const std::size_t head = autd3::message(autd3::Kind::FRAME, 0).size();
        if (bytes.size() == kSilence.size() && bytes[1] == kSilence[1] &&
            std::equal(bytes.begin() + static_cast<std::ptrdiff_t>(head) + 1,
                       bytes.end(),
                       kSilence.begin() + static_cast<std::ptrdiff_t>(head) + 1))
            ++*_masks;
        return _link.send(to, bytes);
    }
    bool sendToGroup(const std::vector<std::uint8_t>& bytes) override
    {
        return _link.sendToGroup(bytes);
    }
    bool receive(double until_s, autd3::Endpoint& from, std::vector<std::uint8_t>& bytes) override
    {
        return _link.receive(until_s, from, bytes);
    }
    void rest(double until_s) override { _link.rest(until_s); }
    void wake() override { _link.wake(); }

private:
    emulation::EmulatedLink _link;
    const std::shared_ptr<std::atomic<int>> _masks;
};

// Units that are told nothing fall silent by their fail-safe, whatever is on the way.
FarSide units(Failure how, bool isListed)
{
    using Chain = emulation::EmulatedChain;
    using emulation::ChainFaults;
    constexpr double kFailsafe_s = 0.25;
    Rehearsal rehearsal(1);
    rehearsal.options.failsafe_s = kFailsafe_s;
    const auto chain = std::make_shared<emulation::EmulatedUnits>(rehearsal.chain);
    const auto masks = std::make_shared<std::atomic<int>>(0);
    FarSide far;
    far.transducers = rehearsal.transducers();
    far.device = std::make_unique<GuardedDevice>(
        std::make_unique<autd3::Autd3Device>(DeviceLayout{far.transducers, {}},
                                             rehearsal.options,
                                             false,
                                             [chain, masks](const std::function<bool()>&)
                                             { return std::make_unique<MaskWatch>(chain, masks); }),
        SafetyLimits(),
        far.transducers);
    if (isListed)
    {
        std::vector<MultiDevice::Part> parts;
        parts.push_back({openDevice("null:", {far.transducers, {}}), 0, far.transducers});
        parts.push_back({std::move(far.device), 0, far.transducers});
        far.device = std::make_unique<MultiDevice>(std::move(parts), far.transducers);
    }
    const auto happen = [chain](const ChainFaults& faults)
    {
        chain->with(
            [&](Chain& c, emulation::Time_ns)
            {
                c.setFaults(faults);
                return 0;
            });
    };
    far.loudness = [chain]
    {
        return quieter::loudnessOf(
            chain->with([](Chain& c, emulation::Time_ns now_ns) { return c.field(now_ns); }));
    };
    far.silences = [masks] { return masks->load(); };
    far.fail = [happen, how]
    {
        ChainFaults faults;
        if (how == Failure::DROPS) faults.drop = 1;
        if (how == Failure::REFUSES) faults.error = 1;
        if (how == Failure::HANGS) faults.latency_ns = 3'600'000'000'000;
        happen(faults);
    };
    far.recover = [happen] { happen({}); };
    far.quiet_s = kFailsafe_s + 0.1;
    return far;
}

class Quieter : public testing::TestWithParam<std::tuple<const char*, bool, Failure, Way>>
{
};

TEST_P(Quieter, ThatIsNotConfirmedIsSilence)
{
    const auto [device, isListed, how, way] = GetParam();
    const std::string name = device;
    FarSide far = name == "autd3" ? units(how, isListed) : onALine(name, how, isListed);
    const auto silences = far.silences;
    EXPECT_EQ(quieter::trial(way, std::move(far)), "");
    EXPECT_GT(silences(), 0) << "it is silenced as it is closed, at the latest";
}

INSTANTIATE_TEST_SUITE_P(
    Matrix,
    Quieter,
    testing::Combine(testing::Values("sonicsurface", "ultraino", "openmpd", "autd3"),
                     testing::Bool(),
                     testing::ValuesIn(quieter::allFailures()),
                     testing::ValuesIn(quieter::allWays())),
    [](const auto& info)
    {
        return fmt::format("{}{}_{}_{}",
                           std::get<0>(info.param),
                           std::get<1>(info.param) ? "_in_a_list" : "",
                           quieter::nameOf(std::get<2>(info.param)),
                           quieter::nameOf(std::get<3>(info.param)));
    });

} // namespace
