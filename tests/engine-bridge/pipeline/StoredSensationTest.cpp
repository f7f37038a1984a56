// Sensations on devices whose line is too slow for them, but which store and time fields by
// themselves: what sounds, by models that were written from the firmware, against the sensation's
// samples.
#include "device/DeviceUri.h"
#include "device/autd3/Autd3Device.h"
#include "device/autd3/Autd3Options.h"
#include "device/autd3/emulator/EmulatedLink.h"
#include "device/boards/BoardDevice.h"
#include "device/boards/BoardKind.h"
#include "device/drive/DriveEncoder.h"
#include "device/limits/GuardedDevice.h"
#include "device/limits/Lead.h"
#include "device/simulation/VirtualBoard.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/Units.h"
#include "haptics/sensation/SensationFigures.h"
#include "haptics/sensation/SensationReader.h"
#include "tests/Eventually.h"
#include "tests/device/boards/BoardTime.h"
#include "tests/engine-bridge/contact/ContactScenes.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using Eigen::Vector3d;
using Activations = std::vector<std::complex<float>>;
using Trigger = SensationProperties::Trigger;

namespace
{

constexpr double kSceneFrame_s = 1.0 / 60.0;
constexpr double kPeriod_s = 25e-6; ///< of the ultrasound

/// The sum of spherical waves, without the kit's propagation.
double pressureAt(const haptics::TransducerArray& array, const Activations& q, const Vector3d& at)
{
    const double k = base::kTwoPi / haptics::Medium().wavelength(40e3);
    std::complex<double> sum = 0.0;
    for (int i = 0; i < array.size(); ++i)
    {
        const double way_m = (at - array.positions.col(i)).norm();
        const std::complex<float> one = q[static_cast<std::size_t>(i)];
        sum += std::complex<double>(one) * std::polar(1.0 / way_m, -k * way_m);
    }
    return std::abs(sum);
}

/// Where the pressure is highest within 40 mm in the plane through \a middle, to 0.25 mm.
Vector3d
focusOf(const haptics::TransducerArray& array, const Activations& q, const Vector3d& middle)
{
    Vector3d best = middle;
    double step_m = 4e-3;
    double reach_m = 40e-3;
    for (; step_m > 0.2e-3; reach_m = 1.5 * step_m, step_m *= 0.25)
    {
        const Vector3d around = best;
        double most = 0.0;
        for (double x = -reach_m; x <= reach_m; x += step_m)
            for (double y = -reach_m; y <= reach_m; y += step_m)
            {
                const Vector3d at = around + Vector3d(x, y, 0.0);
                const double now = pressureAt(array, q, at);
                if (now > most) most = now, best = at;
            }
    }
    return best;
}

bool sounds(const Activations& q)
{
    return std::any_of(q.begin(), q.end(), [](const auto& one) { return std::abs(one) > 1e-3F; });
}

/// A scene of one sensation, 120 mm above an array with its pipeline, in real time.
struct Played
{
    /// \a open: the device; may be called once.
    Played(
        const std::string& arrayName,
        const std::string& sensation,
        std::function<std::unique_ptr<device::ArrayDevice>(const haptics::TransducerArray&)> open,
        double hold_s = 0.0) :
        array(haptics::TransducerArray::load(arrayName))
    {
        HologramOptions options;
        options.array = array;
        options.deviceFactory = [this, open = std::move(open), hold_s](
                                    const std::string&, const device::DeviceLayout& layout)
        {
            device::SafetyLimits limits;
            limits.hold_s = hold_s;
            return std::make_unique<device::GuardedDevice>(open(array), limits, layout.transducers);
        };
        pipeline = std::make_unique<HologramPipeline>(options);
        pipeline->device().follow(lead);
        HapticObject object = bridge::test::object(std::make_shared<const haptics::TriangleMesh>());
        object.path = "Scene/Sensation";
        middle = array.positions.rowwise().mean();
        middle.z() += 0.12;
        object.pose.translation() = middle;
        object.properties.pressure = 0.5;
        object.properties.pressureInPa = false;
        object.properties.sensation.isMeant = true;
        object.properties.sensation.pattern =
            std::make_shared<const haptics::Sensation>(haptics::loadSensation(sensation));
        scene.objects.push_back(object);
    }

    void frame()
    {
        if (isLed) lead->keepAlive();
        scene.time_s = framed_s = base::steadySeconds();
        last = pipeline->process(scene);
    }
    void step()
    {
        letPass(std::clamp(pipeline->rest_s(), 1e-4, 2e-3));
        if (!isTurn()) sentBefore = pipeline->device().reading().fields.sent;
        if (const auto result = pipeline->attend()) last = result;
        if (base::steadySeconds() - framed_s >= kSceneFrame_s) frame();
    }
    void run(double duration_s)
    {
        for (const double until_s = base::steadySeconds() + duration_s;
             base::steadySeconds() < until_s;)
            step();
    }
    template<typename Condition>
    bool until(const Condition& condition)
    {
        for (const double end_s = base::steadySeconds() + 30.0; base::steadySeconds() < end_s;)
        {
            step();
            if (condition()) return true;
        }
        return false;
    }
    /// A result comes that says so.
    bool isFeltAs(haptics::PlayedAs how)
    {
        return until(
            [&] { return last && last->fingertip.force_N > 0.0 && last->fingertip.how == how; });
    }
    bool isTurn() const { return pipeline->device().drives().size() > 1; }
    /// The device has a turn, whole.
    bool isStored() const
    {
        const ArrayFields fields = pipeline->device().reading().fields;
        return isTurn() && fields.sent > sentBefore && fields.waiting == 0;
    }
    bool isLimited() const
    {
        return std::any_of(last->told.begin(),
                           last->told.end(),
                           [](const base::Message& one) {
                               return one.isActive &&
                                      one.code == base::MessageCode::SENSATION_LIMITED;
                           });
    }
    haptics::TransducerArray array;
    std::shared_ptr<device::Lead> lead = std::make_shared<device::Lead>();
    SceneSnapshot scene;
    std::unique_ptr<HologramPipeline> pipeline;
    std::shared_ptr<const HologramResult> last;
    Vector3d middle;
    double framed_s = 0.0;
    std::uint64_t sentBefore = 0; ///< fields that were sent one by one
    bool isLed = true;            ///< the program gives signs of life
};

/// The same on a serial board at the end of a wire.
struct OnBoard
{
    OnBoard(const std::string& kind,
            const std::string& arrayName,
            const std::string& sensation,
            double hold_s = 0.0) :
        wire(device::makeBoardCodec(kind)->bytesPerSecond()),
        played(
            arrayName,
            sensation,
            [this, kind](const haptics::TransducerArray& array)
            {
                return std::make_unique<device::BoardDevice>(
                    kind + ":",
                    device::makeBoardCodec(kind),
                    array.size(),
                    [this](const std::vector<std::uint8_t>&)
                    { return std::make_unique<WireSink>(wire); });
            },
            hold_s)
    {
        played.frame();
    }
    Wire wire;
    Played played;
};

/// What sounds, since when.
using Course = std::vector<std::pair<double, const Activations*>>;

/// An Arduino that plays what it was sent.
class Mega
{
public:
    explicit Mega(const Wire& wire) : _sent(wire.sent()) {}

    /// What it plays from \a from_s until \a until_s, period by period.
    Course course(double from_s, double until_s)
    {
        Course course;
        Sketch sketch;
        std::size_t next = 0;
        for (double time_s = _sent.front().at_s; time_s < until_s; time_s += kPeriod_s)
        {
            for (; next < _sent.size() && _sent[next].at_s <= time_s; ++next)
                sketch.give(_sent[next].byte);
            if (time_s >= from_s) course.emplace_back(time_s, &decoded(sketch.pattern()));
            sketch.turn();
        }
        return course;
    }

private:
    // By a board that gets it alone.
    const Activations& decoded(const std::uint8_t* pattern)
    {
        const std::vector<std::uint8_t> key(pattern, pattern + 100);
        const auto found = _decoded.find(key);
        if (found != _decoded.end()) return found->second;
        std::vector<std::uint8_t> bytes;
        for (const std::uint8_t byte : key)
        {
            bytes.push_back(static_cast<std::uint8_t>((byte & 0xF0) | 1));
            bytes.push_back(static_cast<std::uint8_t>(byte << 4 | 1));
        }
        bytes.push_back(0);
        const auto board = device::makeVirtualBoard("ultraino", 64);
        board->receive(bytes.data(), bytes.size());
        return _decoded[key] = board->playing();
    }

    std::vector<Sent> _sent;
    std::map<std::vector<std::uint8_t>, Activations> _decoded;
};

/// Pressure at \a at over time; the same activations are looked at once.
Envelope envelopeAt(const haptics::TransducerArray& array, const Vector3d& at, const Course& course)
{
    Envelope envelope;
    std::map<const Activations*, float> known;
    for (const auto& [since_s, q] : course)
    {
        const auto found = known.find(q);
        const float now = found != known.end()
                              ? found->second
                              : known[q] = static_cast<float>(pressureAt(array, *q, at));
        if (envelope.empty() || envelope.back().second != now) envelope.emplace_back(since_s, now);
    }
    return envelope;
}

/// The root of the mean power of all emitters.
float loudnessOf(const Activations& q)
{
    float sum = 0.0F;
    for (const std::complex<float>& one : q)
        sum += std::norm(one);
    return std::sqrt(sum / static_cast<float>(q.size()));
}

Envelope loudnessOf(const Course& course)
{
    Envelope envelope;
    const Activations* last = nullptr;
    for (const auto& [since_s, q] : course)
        if (std::exchange(last, q) != q) envelope.emplace_back(since_s, loudnessOf(*q));
    return envelope;
}

/// Leaves out what is hardly heard, which is nowhere.
Course loudOf(const Course& course)
{
    float most = 0.0F;
    for (const auto& [since_s, loudness] : loudnessOf(course))
        most = std::max(most, loudness);
    Course loud;
    for (const auto& one : course)
        if (loudnessOf(*one.second) > 0.4F * most) loud.push_back(one);
    return loud;
}

/// How near the focus is to the sensation's samples, and how it turns round the middle.
struct Path
{
    int fields = 0; ///< different ones
    double rms_m = 0.0;
    double worst_m = 0.0;
    std::vector<std::pair<double, double>> angles; ///< at times, s: rad

    /// 1 if it turns \a frequency_Hz times a second without a jump, 0 if it doesn't.
    double follows(double frequency_Hz) const
    {
        std::complex<double> sum = 0.0;
        for (const auto& [time_s, angle_rad] : angles)
            sum += std::polar(1.0, angle_rad - base::kTwoPi * frequency_Hz * time_s);
        return std::abs(sum) / static_cast<double>(angles.size());
    }
};

Path pathOf(const Played& played, const Course& course)
{
    /// A field's focus, and its distance from the samples.
    struct Focus
    {
        Vector3d place;
        double off_m = 1.0;
    };
    constexpr int kSamples = 720;
    const double turn_s = 1.0 / 70.0;
    haptics::SensationPlayer player(played.scene.objects[0].properties.sensation.pattern);
    std::vector<Vector3d> samples;
    for (int k = 0; k < kSamples; ++k)
        samples.emplace_back(1e-3 * player.sampleAt(1e3 * turn_s * k / kSamples).position_mm);
    Path path;
    std::map<const Activations*, Focus> foci;
    double sum_m2 = 0.0;
    for (const auto& [since_s, q] : course)
    {
        Focus& now = foci[q];
        if (now.off_m == 1.0)
        {
            now.place = focusOf(played.array, *q, played.middle) - played.middle;
            for (const Vector3d& sample : samples)
                now.off_m = std::min(now.off_m, (sample - now.place).norm());
        }
        path.angles.emplace_back(since_s - course.front().first,
                                 std::atan2(now.place.y(), now.place.x()));
        sum_m2 += now.off_m * now.off_m;
        path.worst_m = std::max(path.worst_m, now.off_m);
    }
    path.fields = static_cast<int>(foci.size());
    path.rms_m = std::sqrt(sum_m2 / static_cast<double>(course.size()));
    return path;
}

/// What a SonicSurface plays, byte by byte, and when its line had bytes all the time.
struct Surface
{
    explicit Surface(const Wire& wire)
    {
        const std::vector<Sent> sent = wire.sent();
        busy = longestBusy(sent, device::makeBoardCodec("sonicsurface")->bytesPerSecond());
        const auto board = device::makeVirtualBoard("sonicsurface", 256);
        for (const Sent& one : sent)
        {
            board->receive(&one.byte, 1);
            if (one.byte != 253 && one.byte != 150 && one.byte != 151) continue;
            all.push_back(std::make_unique<Activations>(board->playing()));
            course.emplace_back(one.at_s, all.back().get());
        }
    }
    std::pair<double, double> busy;
    std::vector<std::unique_ptr<Activations>> all;
    Course course;
};

double lastSound_s(const Course& course)
{
    double last_s = 0.0;
    for (std::size_t i = 0; i + 1 < course.size(); ++i)
        if (sounds(*course[i].second)) last_s = course[i + 1].first;
    return last_s;
}

/// Lets something end what a board repeats, and returns how long it sounded after that. It is
/// silent then.
template<typename End>
double soundsAfter(const std::string& kind, const End& end, double hold_s = 0.0)
{
    const bool isMega = kind == "ultraino";
    OnBoard board(kind,
                  isMega ? "ultraino64" : kind,
                  isMega ? "circle" : "point-am?radius=0mm&modulation=200",
                  hold_s);
    Played& played = board.played;
    EXPECT_TRUE(played.until([&] { return played.isStored(); }));
    played.run(0.3);
    EXPECT_TRUE(played.isStored()) << kind;
    const double asked_s = base::steadySeconds();
    end(played);
    const double end_s = base::steadySeconds();
    const Surface surface(board.wire);
    Mega mega(board.wire);
    const Course course = isMega ? mega.course(asked_s - 0.2, end_s) : surface.course;
    EXPECT_FALSE(sounds(*course.back().second)) << kind;
    EXPECT_GT(lastSound_s(course), asked_s - 0.2) << kind << " has played";
    const double after_s = lastSound_s(course) - asked_s;
    ::testing::Test::RecordProperty(kind + " sounds for", std::to_string(after_s) + " s");
    return after_s;
}

/// Units on an emulated cable that play a sensation.
struct Units
{
    explicit Units(const std::string& sensation) :
        played("autd3",
               sensation,
               [this](const haptics::TransducerArray& array)
               {
                   device::DeviceUri uri("autd3:");
                   const device::DeviceLayout layout{array.size(), array.board};
                   return std::make_unique<device::autd3::Autd3Device>(
                       layout,
                       device::autd3::takeAutd3Options(uri, layout),
                       false,
                       [this](const std::function<bool()>&)
                       { return std::make_unique<device::emulation::EmulatedLink>(units); });
               })
    {
        played.frame();
    }
    static device::emulation::ChainOptions chain()
    {
        device::emulation::ChainOptions chain = device::emulation::ChainOptions::realistic(1);
        chain.boot_ns = 0;
        chain.settle_ns = 50 * device::emulation::kMillisecond_ns;
        return chain;
    }
    /// What they play for a second, looked at as often as the machine allows.
    Course course()
    {
        Course course;
        const double from_s = base::steadySeconds() + 0.05;
        double stepped_s = 0.0;
        while (base::steadySeconds() < from_s + 1.0)
        {
            if (base::steadySeconds() > stepped_s + 5e-3)
            {
                played.step();
                stepped_s = base::steadySeconds();
            }
            letPass(2e-4);
            const double now_s = base::steadySeconds();
            const device::DriveSignal field =
                units->with([](auto& emulated, device::emulation::Time_ns now_ns)
                            { return emulated.field(now_ns); });
            if (now_s < from_s) continue;
            Activations& q = known[{field.phase, field.duty}];
            if (q.empty()) device::decode(field, q);
            course.emplace_back(now_s, &q);
        }
        return course;
    }

    std::shared_ptr<device::emulation::EmulatedUnits> units =
        std::make_shared<device::emulation::EmulatedUnits>(chain());
    std::map<std::pair<std::vector<std::uint8_t>, std::vector<std::uint8_t>>, Activations> known;
    Played played;
};

} // namespace

TEST(StoredSensation, UltrainoDrawsACircle)
{
    OnBoard board("ultraino", "ultraino64", "circle?radius=20mm");
    Played& played = board.played;
    ASSERT_TRUE(played.until([&] { return played.isStored(); }));
    EXPECT_EQ(played.pipeline->device().drives().size(), 11U);
    const double from_s = base::steadySeconds() + 0.05; // the last byte is on the line
    played.run(1.2);
    EXPECT_FALSE(played.isLimited()) << "nothing is left out";
    Mega mega(board.wire);
    const Course course = mega.course(from_s, from_s + 1.1);
    const Path path = pathOf(played, course);
    EXPECT_EQ(path.fields, 11);
    // Each repeat of the upload, which no clock keeps in step, costs up to a turn.
    EXPECT_GT(path.follows(40e3 / 572), 0.85);
    EXPECT_LT(path.follows(40e3 / 572 + 1.0), 0.4);
    EXPECT_LT(path.rms_m, 0.5e-3); // with ten steps of phase and 64 emitters
    EXPECT_LT(path.worst_m, 1e-3);
    RecordProperty("path", std::to_string(path.rms_m) + " " + std::to_string(path.worst_m));
}

TEST(StoredSensation, UltrainoModulatesAPoint)
{
    OnBoard board("ultraino", "ultraino64", "point-am?radius=0mm&modulation=200");
    Played& played = board.played;
    ASSERT_TRUE(played.until([&] { return played.isStored(); }));
    const double from_s = base::steadySeconds() + 0.05;
    played.run(1.2);
    EXPECT_FALSE(played.isLimited());
    Mega mega(board.wire);
    const Course course = mega.course(from_s, from_s + 1.1);
    const Spectrum spectrum(envelopeAt(played.array, played.middle, course), from_s, from_s + 1.1);
    EXPECT_NEAR(spectrum.strongest_Hz(), 200.0, 1.0);
    EXPECT_GT(spectrum.depth(200.0), 1.1); // 4/3 for (1 + cos)^2
}

// 70 and 143 turns and periods need hundreds of fields.
TEST(StoredSensation, UltrainoModulatesTheOutlineOfABrushThatItCannotDrawWithIt)
{
    OnBoard board("ultraino", "ultraino64", "point-am?radius=15mm&modulation=143");
    Played& played = board.played;
    ASSERT_TRUE(played.until([&] { return played.isStored(); }));
    const double from_s = base::steadySeconds() + 0.05;
    played.run(1.2);
    EXPECT_TRUE(played.isLimited()) << "the turns of its brush";
    Mega mega(board.wire);
    const Course course = mega.course(from_s, from_s + 1.1);
    const Spectrum spectrum(
        envelopeAt(played.array, played.middle + Vector3d(0.015, 0.0, 0.0), course),
        from_s,
        from_s + 1.1);
    EXPECT_NEAR(spectrum.strongest_Hz(), 143.0, 1.0);
}

// As far as the line never ran dry: a busy machine may not wake a thread every 45 ms.
TEST(StoredSensation, SonicSurfaceModulatesAPointAndAnOutline)
{
    for (const double radius_mm : {0.0, 15.0})
    {
        OnBoard board("sonicsurface",
                      "sonicsurface",
                      "point-am?modulation=143&radius=" + std::to_string(radius_mm));
        Played& played = board.played;
        ASSERT_TRUE(played.until([&] { return played.isStored(); }));
        EXPECT_EQ(played.pipeline->device().drives().size(), 2U);
        double whole_s = 0.0;
        double strongest_Hz = 0.0;
        double depth = 0.0;
        for (int attempt = 0; attempt < 20 && whole_s < 0.5; ++attempt)
        {
            played.run(1.2);
            EXPECT_EQ(played.isLimited(), radius_mm > 0.0) << "the turns of its brush";
            const Surface surface(board.wire);
            whole_s = std::min(surface.busy.second - surface.busy.first - 0.1, 1.0);
            const Spectrum spectrum(envelopeAt(played.array,
                                               played.middle + Vector3d(1e-3 * radius_mm, 0.0, 0.0),
                                               surface.course),
                                    surface.busy.second - whole_s,
                                    surface.busy.second);
            strongest_Hz = spectrum.strongest_Hz();
            depth = spectrum.depth(143.0);
        }
        EXPECT_GE(whole_s, 0.5);
        EXPECT_NEAR(strongest_Hz, 143.0, 1.5);
        EXPECT_GT(depth, 1.0); // 4/pi for halves, less what writing the buffers takes
    }
}

TEST(StoredSensation, SonicSurfaceHasNoRoomForATurn)
{
    OnBoard board("sonicsurface", "sonicsurface", "circle?radius=20mm");
    Played& played = board.played;
    played.run(0.5);
    EXPECT_EQ(played.pipeline->device().drives().size(), 1U);
    EXPECT_TRUE(played.isLimited());
    EXPECT_TRUE(played.isFeltAs(haptics::PlayedAs::HELD)) << "an outline rests";
}

// What is played counts, not what was authored: fields one by one, turns, modulations.
TEST(StoredSensation, IsJudgedAsItIsPlayed)
{
    using haptics::PlayedAs;
    const auto played = [](const std::string& sensation)
    {
        auto simulated =
            std::make_unique<Played>("board",
                                     sensation,
                                     [](const haptics::TransducerArray& array) {
                                         return device::openDevice("sim:", {array.size(), {}});
                                     });
        simulated->frame();
        return simulated;
    };
    EXPECT_TRUE(played("circle?radius=20mm")->isFeltAs(PlayedAs::CIRCLING));
    EXPECT_TRUE(played("point-am?radius=0mm&modulation=143")->isFeltAs(PlayedAs::VIBRATING));
    OnBoard turning("ultraino", "ultraino64", "circle?radius=20mm");
    ASSERT_TRUE(turning.played.until([&] { return turning.played.isStored(); }));
    EXPECT_TRUE(turning.played.isFeltAs(PlayedAs::CIRCLING));
    OnBoard modulated("sonicsurface", "sonicsurface", "point-am?radius=15mm&modulation=143");
    ASSERT_TRUE(modulated.played.until([&] { return modulated.played.isStored(); }));
    EXPECT_TRUE(modulated.played.isFeltAs(PlayedAs::VIBRATING));
}

// A piece of an upload and three silent fields, 17 ms each.
TEST(StoredSensation, AMuteOvertakesIt)
{
    for (const std::string kind : {"ultraino", "sonicsurface"})
        EXPECT_LT(soundsAfter(kind,
                              [](Played& played)
                              {
                                  played.pipeline->device().setMuted(true);
                                  played.run(0.4);
                                  EXPECT_EQ(played.pipeline->device().state(), ArrayState::MUTED);
                              }),
                  0.15)
            << kind;
}

TEST(StoredSensation, AStopEndsIt)
{
    for (const std::string kind : {"ultraino", "sonicsurface"})
        EXPECT_LT(soundsAfter(kind,
                              [](Played& played)
                              {
                                  played.scene.objects[0].properties.sensation.trigger =
                                      Trigger::PROGRAM;
                                  played.frame();
                                  played.run(0.4);
                              }),
                  0.25)
            << kind;
}

TEST(StoredSensation, TheHoldEndsIt)
{
    for (const std::string kind : {"ultraino", "sonicsurface"})
    {
        const double after_s = soundsAfter(
            kind,
            [](Played& played)
            {
                played.isLed = false;
                EXPECT_TRUE(played.until([&] { return played.pipeline->device().isHoldOver(); }));
                played.run(0.3);
                EXPECT_NE(played.pipeline->device().state(), ArrayState::PLAYING);
            },
            0.25);
        EXPECT_LT(after_s, 0.25 + 0.15) << kind;
    }
}

TEST(StoredSensation, IsPlayedAgainAfterAMuteAndAHold)
{
    OnBoard board("ultraino", "ultraino64", "circle?radius=20mm", 0.25);
    Played& played = board.played;
    ASSERT_TRUE(played.until([&] { return played.isStored(); }));
    played.pipeline->device().setMuted(true);
    played.run(0.3);
    played.pipeline->device().setMuted(false);
    const auto soundsNow = [&]
    {
        const double now_s = base::steadySeconds();
        Mega mega(board.wire);
        return played.isStored() && pathOf(played, mega.course(now_s - 0.05, now_s)).fields == 11;
    };
    EXPECT_TRUE(played.until(soundsNow));
    played.isLed = false;
    EXPECT_TRUE(played.until([&] { return played.pipeline->device().isHoldOver(); }));
    played.run(0.2);
    played.isLed = true;
    EXPECT_TRUE(played.until(soundsNow));
}

TEST(StoredSensation, AParameterIsPlayedAtOnceAndStoredWhenItRests)
{
    OnBoard board("ultraino", "ultraino64", "circle?radius=20mm");
    Played& played = board.played;
    ASSERT_TRUE(played.until([&] { return played.isStored(); }));
    played.scene.objects[0].properties.sensation.parameters = {{"radius", 10.0}};
    played.frame();
    played.run(0.05);
    EXPECT_EQ(played.pipeline->device().drives().size(), 1U) << "its outline, meanwhile";
    EXPECT_TRUE(played.isLimited());
    ASSERT_TRUE(played.until([&] { return played.isStored(); }));
    played.run(0.3);
    const double now_s = base::steadySeconds();
    Mega mega(board.wire);
    const Course course = mega.course(now_s - 0.1, now_s);
    for (const auto& [since_s, q] : course)
        if (since_s == course.front().first || since_s == course.back().first)
        {
            const Vector3d from = focusOf(played.array, *q, played.middle) - played.middle;
            EXPECT_NEAR(from.norm(), 10e-3, 2e-3);
        }
}

TEST(StoredSensation, UltrainoDrawsAndModulatesWhatRepeatsTogether)
{
    OnBoard board("ultraino", "ultraino64", "point-am?radius=20mm&frequency=70&modulation=140");
    Played& played = board.played;
    ASSERT_TRUE(played.until([&] { return played.isStored(); }));
    EXPECT_LE(played.pipeline->device().drives().size(), 32U);
    const double from_s = base::steadySeconds() + 0.05;
    played.run(1.2);
    EXPECT_FALSE(played.isLimited());
    Mega mega(board.wire);
    const Course course = mega.course(from_s, from_s + 1.1);
    const Spectrum spectrum(loudnessOf(course), from_s, from_s + 1.1);
    EXPECT_NEAR(spectrum.strongest_Hz(), 140.0, 1.5);
    EXPECT_GT(pathOf(played, loudOf(course)).follows(40e3 / 572), 0.8);
}

TEST(StoredSensation, Autd3UnitsDrawACircleFasterThanTheirLine)
{
    Units units("circle?radius=20mm");
    Played& played = units.played;
    ASSERT_LT(played.pipeline->device().ability().fieldsPerSecond, 8 * 70.0);
    ASSERT_TRUE(played.until([&] { return played.isStored(); }));
    EXPECT_FALSE(played.isLimited());
    const Path path = pathOf(played, units.course());
    EXPECT_EQ(played.pipeline->device().drives().size(), 80U);
    EXPECT_GT(path.fields, 60) << "of those that were looked at";
    EXPECT_GT(path.follows(70.0), 0.98);
    EXPECT_LT(path.rms_m, 0.5e-3);
    EXPECT_LT(path.worst_m, 1e-3);
}

TEST(StoredSensation, Autd3UnitsDrawAndModulate)
{
    Units units("point-am?radius=20mm&frequency=70&modulation=143");
    Played& played = units.played;
    ASSERT_TRUE(played.until([&] { return played.isStored(); }));
    EXPECT_FALSE(played.isLimited());
    const Course course = units.course();
    const Spectrum spectrum(loudnessOf(course), course.front().first, course.back().first);
    EXPECT_NEAR(spectrum.strongest_Hz(), 143.0, 1.0);
    EXPECT_GT(pathOf(played, loudOf(course)).follows(70.0), 0.9);
}
