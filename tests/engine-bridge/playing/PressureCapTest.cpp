#include "engine-bridge/playing/PressureCap.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/base/InputError.h"
#include "tests/engine-bridge/pipeline/DoubleField.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

haptics::TransducerArray arrayOf(const std::string& board)
{
    return haptics::TransducerArray::load(board.empty()         ? "board"
                                          : board == "ultraino" ? "ultraino64"
                                                                : board);
}

std::unique_ptr<device::ArrayDevice> simulated(const std::string& board,
                                               const haptics::TransducerArray& array,
                                               const std::string& more = "")
{
    const std::string uri = "sim:" + (board.empty() ? "" : "?board=" + board) + more;
    return device::openDevice(uri, {array.size(), array.board});
}

std::function<Eigen::VectorXcf(const device::DriveSignal&)>
playOf(const device::ArrayDevice* device)
{
    return [device](const device::DriveSignal& signal)
    {
        std::vector<std::complex<float>> q;
        if (device)
            q = device->wouldPlay(signal);
        else
            device::decode(signal, q);
        return Eigen::VectorXcf(
            Eigen::Map<Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size())));
    };
}

// Points 100 to 140 mm in front of the array's middle.
Eigen::Matrix3Xd pointsBefore(const haptics::TransducerArray& array, int n, std::mt19937& random)
{
    std::uniform_real_distribution<double> across(-0.03, 0.03);
    std::uniform_real_distribution<double> off(0.1, 0.14);
    const Eigen::Vector3d middle = array.positions.rowwise().mean();
    const Eigen::Vector3d normal = array.normals.col(0);
    const Eigen::Vector3d u = normal.unitOrthogonal();
    const Eigen::Vector3d v = normal.cross(u);
    Eigen::Matrix3Xd points(3, n);
    for (int l = 0; l < n; ++l)
        points.col(l) = middle + off(random) * normal + across(random) * u + across(random) * v;
    return points;
}

// All in phase at the first point, with amplitudes up to 1.5, which is clipped.
device::DriveSignal focusAt(const Eigen::Vector3d& r,
                            const haptics::TransducerArray& array,
                            std::mt19937& random,
                            bool even)
{
    std::uniform_real_distribution<double> amplitude(0.0, 1.5);
    const double k = 2.0 * M_PI * array.frequency_Hz / haptics::Medium().soundSpeed();
    std::vector<std::complex<float>> q;
    for (int i = 0; i < array.size(); ++i)
    {
        const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0.0;
        const double R = (r - array.positions.col(i)).norm();
        q.emplace_back(std::polar(even ? 1.0 : amplitude(random), k * R - offset));
    }
    device::DriveSignal signal;
    device::encode(q.data(), array.size(), signal);
    return signal;
}

class Boards : public testing::TestWithParam<const char*>
{
};

} // namespace

// What each kind of board makes of the drive (rounded phases and widths, on or off), against the
// sum in double precision.
TEST_P(Boards, NoPointGetsMoreThanTheCap)
{
    const haptics::Medium medium;
    const haptics::TransducerArray array = arrayOf(GetParam());
    std::mt19937 random(3);
    int capped = 0;
    for (int round = 0; round < 12; ++round)
    {
        const bool even = round % 3 == 0;
        const auto device = simulated(GetParam(), array);
        const Eigen::Matrix3Xd points = pointsBefore(array, 6, random);
        device::DriveSignal signal = focusAt(points.col(0), array, random, even);
        const double asked_Pa = loudestInDouble(points, array, medium, device->wouldPlay(signal));
        const double cap_Pa = asked_Pa * (0.05 + 0.11 * round); // the last is no cap
        const device::DriveSignal wanted = signal;
        const CappedField field =
            PressureCap(cap_Pa, playOf(device.get())).hold({points, {&array}, medium}, signal);
        ASSERT_TRUE(device->send(signal));
        const double played_Pa = loudestInDouble(points, array, medium, device->played());
        EXPECT_LE(played_Pa, cap_Pa) << "round " << round;
        EXPECT_NEAR(played_Pa, field.achieved_Pa.maxCoeff(), 1e-4 * asked_Pa);
        EXPECT_LT(loudestInDouble(points, array, medium, field.played) - played_Pa, 1e-6 * cap_Pa);
        capped += field.factor < 1.0 ? 1 : 0;
        if (cap_Pa > 1.001 * asked_Pa)
        {
            EXPECT_EQ(field.factor, 1.0);
            EXPECT_EQ(signal.duty, wanted.duty) << "what keeps to the cap is left alone";
        }
        else
        {
            EXPECT_LT(field.factor, 1.0);
        }
        // Levels alone change; where a cap binds, what is off has no phase, as an encoder writes
        // it.
        for (std::size_t j = 0; j < wanted.phase.size(); ++j)
        {
            const bool isWithoutPhase = field.factor < 1.0 && signal.duty[j] == 0;
            ASSERT_EQ(signal.phase[j], isWithoutPhase ? 0 : wanted.phase[j]) << j;
        }
        // In fine levels little is given away.
        if (std::string(GetParam()).empty())
        {
            EXPECT_GT(played_Pa, 0.97 * std::min(cap_Pa, asked_Pa));
        }
        if (field.factor == 0.0)
        {
            EXPECT_EQ(played_Pa, 0.0);
        }
    }
    EXPECT_GE(capped, 8);
}

INSTANTIATE_TEST_SUITE_P(Devices,
                         Boards,
                         testing::Values("", "sonicsurface", "ultraino", "openmpd"),
                         [](const auto& info)
                         { return *info.param ? std::string(info.param) : std::string("fine"); });

TEST(PressureCap, OfABoardThatIsOnOrOffFewerTransducersPlayWhereFullDriveIsTooMuch)
{
    const haptics::Medium medium;
    const haptics::TransducerArray array = arrayOf("sonicsurface");
    const auto device = simulated("sonicsurface", array);
    std::mt19937 random(1);
    const Eigen::Matrix3Xd points = pointsBefore(array, 1, random);
    device::DriveSignal signal = focusAt(points.col(0), array, random, true);
    const double full_Pa = loudestInDouble(points, array, medium, device->wouldPlay(signal));
    const device::DriveSignal wanted = signal;
    double before_Pa = 0.0;
    for (const double share : {0.02, 0.1, 0.3, 0.6, 0.9})
    {
        SCOPED_TRACE(share);
        signal = wanted;
        const CappedField field = PressureCap(share * full_Pa, playOf(device.get()))
                                      .hold({points, {&array}, medium}, signal);
        const double played_Pa = loudestInDouble(points, array, medium, device->wouldPlay(signal));
        EXPECT_LE(played_Pa, share * full_Pa);
        EXPECT_GT(played_Pa, (share > 0.1 ? 0.95 : 0.6) * share * full_Pa);
        EXPECT_NEAR(field.factor, played_Pa / full_Pa, 0.1 * share + 0.01);
        EXPECT_GT(played_Pa, before_Pa);
        before_Pa = played_Pa;
    }
    // One alone is too much.
    signal = wanted;
    const CappedField silent =
        PressureCap(1.0, playOf(device.get())).hold({points, {&array}, medium}, signal);
    EXPECT_EQ(silent.factor, 0.0);
    EXPECT_EQ(signal.duty, std::vector<std::uint8_t>(256, 0));
}

TEST(PressureCap, HoldsForEachBeliefAboutTheArray)
{
    const haptics::Medium medium;
    const haptics::TransducerArray array = arrayOf("");
    haptics::TransducerArray shadowed = array;
    shadowed.gain = Eigen::VectorXd::Constant(array.size(), 0.25);
    std::mt19937 random(2);
    const Eigen::Matrix3Xd points = pointsBefore(array, 3, random);
    device::DriveSignal signal = focusAt(points.col(0), array, random, true);
    const CappedField field =
        PressureCap(500.0, playOf(nullptr)).hold({points, {&shadowed, &array}, medium}, signal);
    EXPECT_LE(loudestInDouble(points, array, medium, field.played), 500.0);
    device::DriveSignal louder = signal;
    for (std::uint8_t& duty : louder.duty)
        duty = static_cast<std::uint8_t>(duty > 0 ? duty + 1 : 0);
    EXPECT_GT(loudestInDouble(points, array, medium, playOf(nullptr)(louder)), 500.0)
        << "no louder level keeps to it";
    EXPECT_NEAR(
        field.achieved_Pa.maxCoeff(), loudestInDouble(points, shadowed, medium, field.played), 0.1);
}

namespace
{

// Phases and amplitudes at random, so that no point stands out and roundings can add up either way.
device::DriveSignal speckle(int m, std::mt19937& random)
{
    std::uniform_int_distribution<int> level(0, 255);
    device::DriveSignal signal;
    for (int i = 0; i < m; ++i)
    {
        signal.phase.push_back(static_cast<std::uint8_t>(level(random)));
        signal.duty.push_back(static_cast<std::uint8_t>(level(random)));
    }
    return signal;
}

// The most that any of many gains, as a ramp or a budget takes, makes of it.
double loudestFaded(const Eigen::Matrix3Xd& points,
                    const haptics::TransducerArray& array,
                    const device::ArrayDevice& device,
                    const device::DriveSignal& signal)
{
    double most_Pa = 0.0;
    for (double gain = 1.0; gain > 0.0; gain -= gain > 0.98 ? 0.0005 : 0.05)
    {
        device::DriveSignal faded;
        device::scaleDuties(signal, gain, faded);
        most_Pa = std::max(
            most_Pa, loudestInDouble(points, array, haptics::Medium(), device.wouldPlay(faded)));
    }
    return most_Pa;
}

} // namespace

// Amplitudes that differ are rounded each by itself when a ramp lowers them: that alone can make a
// point louder.
TEST(PressureCap, HoldsWhileTheDeviceFades)
{
    const haptics::Medium medium;
    const haptics::TransducerArray array = arrayOf("openmpd");
    const auto device = simulated("openmpd", array, "&ramp=20ms");
    ASSERT_TRUE(device->ability().fades);
    device::DriveAbility steady = device->ability();
    steady.fades = false;
    std::mt19937 random(5);
    int wouldBeOver = 0;
    for (int round = 0; round < 12; ++round)
    {
        const Eigen::Matrix3Xd points = pointsBefore(array, 2, random);
        const device::DriveSignal wanted = speckle(array.size(), random);
        const double cap_Pa =
            1.0001 * loudestInDouble(points, array, medium, device->wouldPlay(wanted));
        device::DriveSignal signal = wanted;
        PressureCap(cap_Pa, playOf(device.get()), steady).hold({points, {&array}, medium}, signal);
        wouldBeOver += loudestFaded(points, array, *device, signal) > cap_Pa ? 1 : 0;
        for (const bool modulated : {false, true})
        {
            signal = wanted;
            PressureCap(cap_Pa, playOf(device.get()), modulated ? steady : device->ability())
                .hold({points, {&array}, medium, modulated}, signal);
            const double faded_Pa = loudestFaded(points, array, *device, signal);
            EXPECT_LE(faded_Pa, cap_Pa) << "round " << round;
        }
    }
    EXPECT_GT(wouldBeOver, 0) << "or this shows nothing";
}

TEST(PressureCap, GivesNothingAwayToFadingWhereAllPlayAtOneAmplitude)
{
    const haptics::Medium medium;
    const haptics::TransducerArray array = arrayOf("");
    const auto device = simulated("", array, "?ramp=20ms");
    std::mt19937 random(6);
    const Eigen::Matrix3Xd points = pointsBefore(array, 2, random);
    device::DriveSignal signal = focusAt(points.col(0), array, random, true);
    signal.duty[7] = 0; // off
    const double asked_Pa = loudestInDouble(points, array, medium, device->wouldPlay(signal));
    PressureCap cap(1.0001 * asked_Pa, playOf(device.get()), device->ability());
    EXPECT_EQ(cap.hold({points, {&array}, medium}, signal).factor, 1.0);
    EXPECT_LE(loudestFaded(points, array, *device, signal), 1.0001 * asked_Pa);
}

// Where two halves work against each other one of them is louder alone: when the other is
// unplugged, or fades by itself.
TEST(PressureCap, HoldsForEachPartOfTheArrayAlone)
{
    const haptics::Medium medium;
    const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    const auto device =
        device::openDevice("sim:?boards=0-7,sim:?boards=8-15", {array.size(), array.board});
    const device::DriveAbility ability = device->ability();
    ASSERT_EQ(ability.part.size(), static_cast<std::size_t>(array.size()));
    std::mt19937 random(7);
    const Eigen::Matrix3Xd points = Eigen::Vector3d(0.01, 0.0, -0.02);
    device::DriveSignal signal = focusAt(points.col(0), array, random, true);
    for (std::size_t i = 0; i < ability.part.size(); ++i)
        if (ability.part[i] == 1) signal.phase[i] ^= 128;
    const auto loudestOfPart = [&](int part)
    {
        auto q = device->wouldPlay(signal);
        for (std::size_t i = 0; i < q.size(); ++i)
            if (ability.part[i] != part) q[i] = 0.0f;
        return loudestInDouble(points, array, medium, q);
    };
    const double alone_Pa = std::max(loudestOfPart(0), loudestOfPart(1));
    ASSERT_GT(alone_Pa, 1.5 * loudestInDouble(points, array, medium, device->wouldPlay(signal)));
    const double cap_Pa = 0.8 * alone_Pa;
    const CappedField field =
        PressureCap(cap_Pa, playOf(device.get()), ability).hold({points, {&array}, medium}, signal);
    EXPECT_LT(field.factor, 0.81);
    EXPECT_GT(field.factor, 0.75);
    EXPECT_LE(std::max(loudestOfPart(0), loudestOfPart(1)), cap_Pa);
    EXPECT_NEAR(field.achieved_Pa[0],
                loudestInDouble(points, array, medium, device->wouldPlay(signal)),
                1e-4 * alone_Pa);
}

TEST(PressureCap, AnArrayAndItsRecorderAreOne)
{
    const haptics::TransducerArray array = arrayOf("");
    EXPECT_TRUE(
        device::openDevice("sim:,null:", {array.size(), array.board})->ability().part.empty());
}

TEST(PressureCap, LowersFieldsInTurnByOneFactor)
{
    const haptics::Medium medium;
    const haptics::TransducerArray array = arrayOf("");
    std::mt19937 random(8);
    const Eigen::Matrix3Xd points = pointsBefore(array, 4, random);
    std::vector<Eigen::VectorXcf> fields;
    std::vector<double> before_Pa;
    for (int k = 0; k < 3; ++k)
    {
        const Eigen::VectorXcf q =
            playOf(nullptr)(focusAt(points.col(k), array, random, true)) * (1.0f - 0.25f * k);
        before_Pa.push_back(loudestInDouble(points, array, medium, q));
        fields.push_back(q);
    }
    PressureCap cap(0.5 * before_Pa[0], playOf(nullptr));
    const double factor = cap.holdAll({points, {&array}, medium}, fields);
    EXPECT_NEAR(factor, 0.5, 0.01);
    for (std::size_t k = 0; k < fields.size(); ++k)
    {
        const double now_Pa = loudestInDouble(points, array, medium, fields[k]);
        EXPECT_LE(now_Pa, cap.max_Pa());
        EXPECT_NEAR(now_Pa / before_Pa[k], 0.5, 0.02) << "field " << k;
    }
    fields[1][5] = std::nanf("");
    EXPECT_THROW(cap.holdAll({points, {&array}, medium}, fields), base::InputError);
}

// A step from a level that is too loud may lead below the lowest, which keeps to the cap.
TEST(PressureCap, NeverPassesALowestLevelThatKeepsToTheCap)
{
    const haptics::Medium medium;
    const haptics::TransducerArray array = arrayOf("");
    std::mt19937 random(9);
    const Eigen::Matrix3Xd points = pointsBefore(array, 3, random);
    const Eigen::VectorXcf full = playOf(nullptr)(focusAt(points.col(0), array, random, true));
    const auto coarse = [](const device::DriveSignal& signal)
    {
        Eigen::VectorXcf q = playOf(nullptr)(signal);
        for (std::complex<float>& one : q)
            if (const float a = std::abs(one); a > 0.0f)
                one *= (a > 0.999f ? 1.0f : a >= 0.4999f ? 0.5f : 0.0f) / a;
        return q;
    };
    const double full_Pa = loudestInDouble(points, array, medium, full);
    for (const double share : {0.5002, 0.52, 0.9})
    {
        std::vector<Eigen::VectorXcf> fields = {full, full};
        PressureCap cap(share * full_Pa, coarse);
        EXPECT_GT(cap.holdAll({points, {&array}, medium}, fields), 0.0) << share;
        device::DriveSignal signal;
        ASSERT_TRUE(device::encode(fields[1].data(), array.size(), signal));
        const double now_Pa = loudestInDouble(points, array, medium, coarse(signal));
        EXPECT_NEAR(now_Pa / full_Pa, 0.5, 0.01) << share;
        EXPECT_LE(now_Pa, cap.max_Pa());
    }
    // Below that level fewer transducers play, as many in each field.
    std::vector<Eigen::VectorXcf> fields = {full, full};
    EXPECT_NEAR(
        PressureCap(0.4 * full_Pa, coarse).holdAll({points, {&array}, medium}, fields), 0.4, 0.02);
    device::DriveSignal signal;
    ASSERT_TRUE(device::encode(fields[1].data(), array.size(), signal));
    const double now_Pa = loudestInDouble(points, array, medium, coarse(signal));
    EXPECT_NEAR(now_Pa / full_Pa, 0.4, 0.01);
    EXPECT_LE(now_Pa, 0.4 * full_Pa);
    EXPECT_EQ(fields[0], fields[1]);
    // Fields of several amplitudes would lose their ratio that way.
    fields = {full, 0.6f * full};
    EXPECT_EQ(PressureCap(0.4 * full_Pa, coarse).holdAll({points, {&array}, medium}, fields), 0.0);
    EXPECT_TRUE(isSilent(fields));
}

TEST(PressureCap, IsOverZero)
{
    for (const double wrong : {0.0, -1.0, 2e6, std::nan("")})
        EXPECT_THROW(PressureCap(wrong, playOf(nullptr)), base::InputError);
}

// hold() gives the drives that it has asked about, and they are what the field's activations are as
// bytes: whoever encodes these sends the same.
TEST(PressureCap, HandsOverTheVeryBytesThatItHasProven)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const haptics::Medium medium;
    int lowered = 0, thinned = 0;
    for (const std::string board : {"", "sonicsurface", "ultraino"})
    {
        const haptics::TransducerArray array = arrayOf(board);
        const auto device = simulated(board, array);
        std::vector<device::DriveSignal> asked;
        const auto play = [&](const device::DriveSignal& signal)
        {
            asked.push_back(signal);
            return playOf(device.get())(signal);
        };
        for (int trial = 0; trial < 40; ++trial)
        {
            const Eigen::Matrix3Xd points = pointsBefore(array, 3, random);
            haptics::FieldSequence sequence;
            for (int k = 0; k < 1 + trial % 3; ++k)
                sequence.fields.push_back(
                    playOf(nullptr)(focusAt(points.col(k), array, random, trial % 2 == 0)));
            const double cap_Pa = std::pow(10.0, 1.0 + 2.5 * unit(random));
            asked.clear();
            CappedDrives capped;
            const double factor = PressureCap(cap_Pa, play, device->ability())
                                      .hold({points, {&array}, medium}, sequence, &capped);
            ASSERT_EQ(capped.drives.size(), sequence.fields.size());
            lowered += factor < 1.0 && factor > 0.0 ? 1 : 0;
            for (std::size_t k = 0; k < capped.drives.size(); ++k)
            {
                const device::DriveSignal& drive = capped.drives[k];
                const bool isSilence = factor <= 0.0;
                const bool isProven =
                    std::any_of(asked.begin(),
                                asked.end(),
                                [&](const device::DriveSignal& one)
                                { return one.phase == drive.phase && one.duty == drive.duty; });
                EXPECT_TRUE(isSilence || isProven) << board << " " << trial;
                device::DriveSignal encoded;
                device::encode(sequence.fields[k].data(), array.size(), encoded);
                EXPECT_EQ(drive.duty, encoded.duty) << board << " " << trial << " " << factor;
                if (!isSilence)
                {
                    EXPECT_EQ(drive.phase, encoded.phase) << board << " " << trial << " " << factor;
                }
                const auto off = std::count(drive.duty.begin(), drive.duty.end(), 0);
                thinned += factor < 1.0 && off > 0 && off < array.size() ? 1 : 0;
            }
        }
    }
    EXPECT_GT(lowered, 20);
    EXPECT_GT(thinned, 10);
}
