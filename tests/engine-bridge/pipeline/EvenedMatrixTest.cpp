// A held field is evened out while nobody asks for it. What is promised of a field holds for each
// on the way: on each device, under each limit, and whatever comes in between.
#include "device/limits/GuardedDevice.h"
#include "device/opening/MultiDevice.h"
#include "device/recording/Recording.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/propagation/Exposure.h"
#include "tests/engine-bridge/pipeline/AtRest.h"
#include "tests/engine-bridge/pipeline/DoubleField.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

using Field = std::vector<std::complex<float>>;

/// Of all fields that a device was given, in turn.
using Bytes = std::vector<Field>;

Field decoded(const device::DriveSignal& signal)
{
    Field field(signal.duty.size());
    device::decode(signal, field);
    return field;
}

/// Keeps what it is given.
class KeepingDevice : public FakeDevice
{
public:
    KeepingDevice(std::shared_ptr<FakeLog> log, int transducers, std::shared_ptr<Bytes> bytes) :
        FakeDevice(std::move(log), transducers),
        _bytes(std::move(bytes))
    {
    }
    bool send(const device::DriveSignal& signal) override
    {
        const bool isSent = FakeDevice::send(signal);
        if (isSent) _bytes->push_back(decoded(signal));
        return isSent;
    }

private:
    std::shared_ptr<Bytes> _bytes;
};

Bytes recordedIn(const std::string& file)
{
    std::ifstream in(file, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    device::recording::Reader reader(bytes, file);
    Bytes fields;
    device::recording::Entry entry;
    while (reader.next(entry) == device::recording::Stop::MORE)
        if (entry.kind == device::recording::Kind::FIELD) fields.push_back(decoded(entry.signal));
    return fields;
}

bool isAlike(const Field& bytes, const Eigen::VectorXcf& played)
{
    if (static_cast<Eigen::Index>(bytes.size()) != played.size()) return false;
    return Eigen::Map<const Eigen::VectorXcf>(bytes.data(), played.size()).isApprox(played, 1e-5f);
}

enum class Device
{
    ONE,
    TWO, ///< the second one a recorder
    RECORDER
};

enum class Limit
{
    NONE,
    EARS, ///< from the first field on
    EARS_LATER,
    PRESSURE,
    PRESSURE_LATER,
    AMPLITUDE
};

/// Two places at the open end of the prism.
Eigen::Matrix3Xd ears(double nearer = 1.0)
{
    Eigen::Matrix3Xd places(3, 2);
    places << 0.0, 0.05, 0.5 * nearer, 0.6 * nearer, 0.0, 0.03;
    return places;
}

double level_dB(const Eigen::Matrix3Xd& places, const HologramResult& result, const Field& bytes)
{
    const double most_Pa = loudestInDouble(places, *result.array, result.medium, bytes) *
                           earFactor(*result.array, 10.1); // the octagon's own P0 is its focus's
    return haptics::soundLevel_dB(0.5 * most_Pa * most_Pa);
}

/// A scene at rest, and the bytes that its device was given.
struct Trial
{
    explicit Trial(Device device = Device::ONE,
                   const std::function<void(HologramOptions&)>& change = {})
    {
        scene = std::make_unique<AtRest>(
            [&](HologramOptions& options)
            {
                if (change) change(options);
                options.deviceFactory = factory(device);
                given = options;
            });
    }
    ~Trial()
    {
        std::error_code ignored;
        std::filesystem::remove(file, ignored);
    }
    Trial(const Trial&) = delete;
    Trial& operator=(const Trial&) = delete;

    decltype(HologramOptions::deviceFactory) factory(Device device)
    {
        const auto keeping = [this](int transducers)
        {
            return std::make_unique<device::GuardedDevice>(
                std::make_unique<KeepingDevice>(log, transducers, bytes),
                device::SafetyLimits(),
                transducers);
        };
        return [this, device, keeping](
                   const std::string&,
                   const device::DeviceLayout& layout) -> std::unique_ptr<device::ArrayDevice>
        {
            if (device == Device::ONE) return keeping(layout.transducers);
            auto recorder = device::openDevice("record:" + file, layout);
            if (device == Device::RECORDER) return recorder;
            std::vector<device::MultiDevice::Part> parts(2);
            parts[0] = {keeping(layout.transducers), 0, layout.transducers};
            parts[1] = {std::move(recorder), 0, layout.transducers};
            return std::make_unique<device::MultiDevice>(std::move(parts), layout.transducers);
        };
    }

    std::shared_ptr<const HologramResult> show(const SceneSnapshot& snapshot)
    {
        return scene->show(snapshot);
    }
    /// Rests until \a count more fields have been walked. Returns their results.
    AtRest::Results walk(std::uint64_t count)
    {
        AtRest::Results results;
        const std::uint64_t until = scene->pipeline->counters().walked + count;
        for (int k = 0; k < 2000 && scene->pipeline->counters().walked < until; ++k)
            for (auto& result : scene->rest(0.005))
                results.push_back(std::move(result));
        return results;
    }
    void reconfigure(const std::function<void(HologramOptions&)>& change)
    {
        HologramOptions options = given;
        change(options);
        scene->pipeline->reconfigure(options);
    }

    std::shared_ptr<FakeLog> log = std::make_shared<FakeLog>();
    std::shared_ptr<Bytes> bytes = std::make_shared<Bytes>();
    std::string file = std::filesystem::temp_directory_path() /
                       fmt::format("midair-evened-{}-{:x}", ::getpid(), std::uintptr_t(this));
    HologramOptions given;
    std::unique_ptr<AtRest> scene; ///< ends first
};

void limit(Limit which, const HologramResult& free, double level_dB, HologramOptions& options)
{
    options.earPoints = ears();
    const double most_Pa = free.achieved_Pa.maxCoeff();
    if (which == Limit::EARS) options.earLimit = level_dB - 10.0;
    if (which == Limit::EARS_LATER) options.earLimit = level_dB + 0.05;
    if (which == Limit::PRESSURE) options.maxPressure = 0.3 * most_Pa;
    if (which == Limit::PRESSURE_LATER) options.maxPressure = 1.02 * most_Pa;
    if (which == Limit::AMPLITUDE) options.maxAmplitude = 0.5;
}

void expectKept(const HologramResult& result, const Field& bytes, const HologramOptions& options)
{
    if (options.earLimit > 0.0)
    {
        EXPECT_LE(level_dB(ears(), result, bytes), options.earLimit + 1e-3);
    }
    if (options.maxPressure > 0.0)
    {
        EXPECT_LE(loudestInDouble(result.points.positions, *result.array, result.medium, bytes),
                  1.0001 * options.maxPressure);
    }
    for (const std::complex<float> one : bytes)
        ASSERT_LE(std::abs(one), options.maxAmplitude + 1e-5);
}

class EvenedMatrix : public testing::TestWithParam<std::tuple<Device, Limit>>
{
};

} // namespace

TEST_P(EvenedMatrix, EachFieldOnTheWayKeepsTheLimitAtTheDevice)
{
    const auto [device, which] = GetParam();
    Trial free(Device::ONE, [](HologramOptions& options) { options.earPoints = ears(); });
    const auto first = free.show(squareSnapshot());
    const double loudest_dB = first->exposure.level_dB;
    Bytes bytes;
    AtRest::Results results;
    HologramOptions options;
    std::string file;
    {
        Trial trial(device,
                    [&, kind = which](HologramOptions& all)
                    { limit(kind, *first, loudest_dB, all); });
        results.push_back(trial.show(squareSnapshot()));
        for (auto& result : trial.walk(60))
            results.push_back(std::move(result));
        options = trial.given;
        bytes = *trial.bytes;
        trial.scene.reset(); // closes the recording
        if (device != Device::ONE)
        {
            const Bytes recorded = recordedIn(trial.file);
            EXPECT_TRUE(device == Device::RECORDER || recorded == bytes);
            bytes = recorded;
        }
    }
    ASSERT_GE(results.size(), 60u);
    EXPECT_TRUE(results.back()->sequence.evened);
    // The device was given those fields, in that order, and nothing else.
    ASSERT_EQ(bytes.size(), results.size());
    for (std::size_t k = 0; k < bytes.size(); ++k)
    {
        EXPECT_TRUE(isAlike(bytes[k], results[k]->played())) << k;
        expectKept(*results[k], bytes[k], options);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Devices,
    EvenedMatrix,
    testing::Combine(testing::Values(Device::ONE, Device::TWO, Device::RECORDER),
                     testing::Values(Limit::NONE,
                                     Limit::EARS,
                                     Limit::EARS_LATER,
                                     Limit::PRESSURE,
                                     Limit::PRESSURE_LATER,
                                     Limit::AMPLITUDE)));

TEST(EvenedOnTheWay, AStopEndsIt)
{
    Trial trial;
    base::StopSource stop;
    trial.scene->pipeline->setStop(stop.token());
    trial.show(squareSnapshot());
    ASSERT_FALSE(trial.walk(5).empty());
    const std::size_t sent = trial.bytes->size();
    stop.request();
    for (int k = 0; k < 200; ++k)
    {
        EXPECT_EQ(trial.scene->pipeline->attend(), nullptr);
        trial.scene->clock.pass(0.005);
    }
    EXPECT_EQ(trial.bytes->size(), sent);
}

TEST(EvenedOnTheWay, AStricterCapSilencesUntilAFieldKeepsIt)
{
    Trial trial;
    const double level_Pa = trial.show(squareSnapshot())->achieved_Pa.maxCoeff();
    ASSERT_FALSE(trial.walk(5).empty());
    const std::size_t sent = trial.bytes->size();
    const int silences = trial.log->silences;
    trial.reconfigure([&](HologramOptions& options) { options.maxPressure = 0.5 * level_Pa; });
    EXPECT_GT(trial.log->silences, silences);
    trial.scene->rest(2.0);
    EXPECT_EQ(trial.bytes->size(), sent) << "nothing of the old options is played";
    const auto capped = trial.show(squareSnapshot());
    EXPECT_FALSE(capped->sequence.evened);
    trial.scene->rest(2.0);
    for (std::size_t k = sent; k < trial.bytes->size(); ++k)
        EXPECT_LE(loudestInDouble(
                      capped->points.positions, *capped->array, capped->medium, (*trial.bytes)[k]),
                  0.5001 * level_Pa);
    EXPECT_GT(trial.bytes->size(), sent);
    // Without the cap it is evened out again.
    trial.reconfigure([](HologramOptions&) {});
    trial.show(squareSnapshot());
    EXPECT_FALSE(trial.walk(5).empty());
    EXPECT_TRUE(trial.scene->newest->sequence.evened);
}

TEST(EvenedOnTheWay, EarsThatComeNearerAreKept)
{
    Trial free(Device::ONE, [](HologramOptions& options) { options.earPoints = ears(); });
    const double limit_dB = free.show(squareSnapshot())->exposure.level_dB + 0.05;
    Trial trial(Device::ONE, [&](HologramOptions& options) { options.earLimit = limit_dB; });
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.ears = ears();
    trial.show(snapshot);
    ASSERT_FALSE(trial.walk(5).empty());
    snapshot.ears = ears(0.6);
    std::size_t sent = trial.bytes->size();
    const auto near = trial.show(snapshot);
    ASSERT_GT(trial.bytes->size(), sent) << "a field for the new place";
    trial.scene->rest(2.0);
    for (; sent < trial.bytes->size(); ++sent)
        EXPECT_LE(level_dB(ears(0.6), *near, (*trial.bytes)[sent]), limit_dB + 1e-3);
}

TEST(EvenedOnTheWay, ALostDeviceGetsTheFieldItWasAtAndThenTheRest)
{
    Trial trial;
    trial.show(squareSnapshot());
    ASSERT_FALSE(trial.walk(5).empty());
    trial.log->refuseSends = true;
    trial.scene->rest(0.3);
    EXPECT_FALSE(trial.scene->newest->playing);
    const std::uint64_t walked = trial.scene->pipeline->counters().walked;
    trial.scene->rest(1.0);
    EXPECT_EQ(trial.scene->pipeline->counters().walked, walked) << "nothing plays";
    trial.log->refuseSends = false;
    const std::size_t sent = trial.bytes->size();
    trial.show(squareSnapshot());
    ASSERT_FALSE(trial.walk(5).empty());
    EXPECT_TRUE(trial.scene->newest->playing);
    EXPECT_TRUE(trial.scene->newest->sequence.evened);
    ASSERT_GT(trial.bytes->size(), sent + 4);
    EXPECT_TRUE(isAlike(trial.bytes->back(), trial.scene->newest->played()));
}

TEST(EvenedOnTheWay, WhatIsOverIsSilent)
{
    Trial trial;
    trial.show(squareSnapshot());
    ASSERT_FALSE(trial.walk(5).empty());
    const int silences = trial.log->silences;
    trial.show(SceneSnapshot());
    EXPECT_GT(trial.log->silences, silences);
    const std::size_t sent = trial.bytes->size();
    EXPECT_TRUE(trial.scene->rest(2.0).empty());
    EXPECT_EQ(trial.bytes->size(), sent);
}

TEST(EvenedOnTheWay, OtherAirAndOtherSettingsBeginAnew)
{
    for (const bool isAir : {true, false})
    {
        Trial trial;
        trial.show(squareSnapshot());
        ASSERT_FALSE(trial.walk(5).empty());
        trial.reconfigure(
            [&](HologramOptions& options)
            {
                if (isAir)
                    options.medium.temperature_C += 10.0;
                else
                    options.even = 0;
            });
        const auto next = trial.show(squareSnapshot());
        EXPECT_FALSE(next->sequence.evened);
        EXPECT_LT(next->report().rms, 2e-3) << "it is solved for the air that it is played in";
        const auto walked = trial.scene->rest(3.0);
        EXPECT_EQ(walked.empty(), !isAir);
    }
}
