// Runs the built midair-bake as a user would.

#include "device/drive/DriveEncoder.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/samples/tools/bake/BakedScene.h"

#include <algorithm>
#include <cmath>

namespace
{

using midair::device::recording::Entry;
using midair::device::recording::Kind;

/// |p| at the scene's two points as they are in frame \a k, by the slow sum in double.
Eigen::VectorXd pressures(const Entry& entry, int k)
{
    using namespace midair::haptics;
    Eigen::Matrix3Xd places(3, 2);
    const double time_s = k / 10.0;
    const double phase = std::fmod(time_s, 2.0);
    const double x = -0.01 + 0.02 * (phase < 1.0 ? phase : 2.0 - phase);
    places.col(0) << x, 0.0, 0.15;
    places.col(1) << x, 0.03, 0.15;
    std::vector<std::complex<float>> q;
    midair::device::decode(entry.signal, q);
    const Eigen::Map<const Eigen::VectorXcf> drive(q.data(), static_cast<Eigen::Index>(q.size()));
    const Eigen::MatrixXcd G =
        referencePropagationMatrix(places, TransducerArray::singleBoard(), Medium());
    return (G * drive.cast<std::complex<double>>()).cwiseAbs();
}

double loudest(const std::vector<Entry>& entries)
{
    double most = 0.0;
    for (const Entry& entry : entries)
        for (const std::uint8_t level : entry.signal.duty)
            most = std::max(most, static_cast<double>(midair::base::dutyAmplitude(level)));
    return most;
}

} // namespace

TEST_F(Baking, APlaceIsPressedInItsFrame)
{
    const Outcome outcome = bake(frames("--out a.midair"));
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    const std::vector<Entry> all = entries("a.midair");
    ASSERT_EQ(all.size(), 20u);
    for (int k = 0; k < 20; ++k)
    {
        const Entry& entry = all[static_cast<std::size_t>(k)];
        EXPECT_EQ(entry.time_ns, static_cast<std::uint64_t>(k) * 100000000u);
        const Eigen::VectorXd there_Pa = pressures(entry, k);
        // Equal targets; the array's levels leave less than 1 %.
        EXPECT_NEAR(there_Pa(0) / there_Pa(1), 1.0, 0.01) << k;
        EXPECT_GT(there_Pa(0), 500.0) << k;
        // A frame later it isn't there any more.
        if (k == 19) break;
        EXPECT_NE(entry.signal.phase, all[static_cast<std::size_t>(k) + 1].signal.phase) << k;
    }
    EXPECT_FALSE(std::filesystem::exists(at("a.midair.part")));
    EXPECT_FALSE(std::filesystem::exists(at("a.midair.unfinished")));
}

TEST_F(Baking, AnyNumberOfShardsGivesTheSameBytes)
{
    ASSERT_EQ(bake(frames("--out one.midair")).code, 0);
    const std::string one = read("one.midair");
    for (const int shards : {2, 3})
    {
        std::string parts;
        for (int i = 1; i <= shards; ++i)
        {
            const std::string name = std::to_string(i) + "of" + std::to_string(shards);
            const Outcome outcome =
                bake(frames("--threads " + std::to_string(i) + " --shard " + std::to_string(i) +
                            "/" + std::to_string(shards) + " --out " + name));
            EXPECT_EQ(outcome.code, 0) << outcome.output;
            parts = name + " " + parts; // in any order
        }
        const Outcome outcome = bake("--out merged.midair --merge " + parts);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        EXPECT_TRUE(read("merged.midair") == one) << shards << " shards";
    }
}

TEST_F(Baking, ChunksFollowEachOtherWithoutAJumpThatCouldBeSpared)
{
    ASSERT_EQ(bake(frames("--out a.midair")).code, 0);
    const std::vector<Entry> all = entries("a.midair");
    for (std::size_t k = 1; k < all.size(); ++k)
    {
        if (k % 4 != 0) continue; // the first of a chunk
        const auto change = [&](int turn)
        {
            double sum = 0.0;
            for (std::size_t i = 0; i < all[k].signal.phase.size(); ++i)
                sum += std::cos(2.0 * M_PI / 256.0 *
                                (all[k].signal.phase[i] + turn - all[k - 1].signal.phase[i]));
            return -sum;
        };
        for (int turn = 1; turn < 256; ++turn)
            EXPECT_LE(change(0), change(turn) + 1e-9) << k << ", " << turn;
    }
}

TEST_F(Baking, WhatIsHalfWrittenIsDoneAgain)
{
    ASSERT_EQ(bake(frames("--out one.midair")).code, 0);
    const Outcome whole = bake(frames("--shard 1/2 --out whole.part"));
    ASSERT_EQ(whole.code, 0) << whole.output;
    const std::string part = read("whole.part");
    ASSERT_EQ(bake(frames("--shard 2/2 --out other.part")).code, 0);
    // In the magic, in the header, at a border, in the last piece, in the last CRC.
    for (const std::size_t size :
         {std::size_t(3), std::size_t(40), part.size() / 2, part.size() - 300, part.size() - 1})
    {
        write("cut.part", part.substr(0, size));
        const Outcome again = bake(frames("--shard 1/2 --out cut.part"));
        EXPECT_EQ(again.code, 0) << size << ": " << again.output;
        ASSERT_EQ(bake("--merge cut.part other.part --out cut.midair").code, 0);
        EXPECT_TRUE(read("cut.midair") == read("one.midair")) << size;
    }
    // What is whole isn't solved again.
    const Outcome again = bake(frames("--shard 1/2 --out whole.part"));
    EXPECT_NE(again.output.find(" 3 of 3 chunks"), std::string::npos) << again.output;
    EXPECT_TRUE(read("whole.part") == part);
}

TEST_F(Baking, AKilledProcessLosesNothingThatWasDone)
{
    const std::string many = "scene.osgt --frames 0:160 --fps 100 --chunk 4 ";
    ASSERT_EQ(bake(many + "--out one.midair").code, 0);
    const Outcome killed =
        shell("cd " + folder + " && { " MIDAIR_BIN "/midair-bake " + many +
              "--out two.midair --quiet & pid=$!; while [ $(stat -c %s two.midair.part 2>/dev/null "
              "|| echo 0) -lt 6000 ]; do kill -0 $pid || exit 9; done; kill -9 $pid; wait $pid; }");
    ASSERT_EQ(killed.code, 137) << killed.output;
    ASSERT_FALSE(std::filesystem::exists(at("two.midair")));
    const Outcome again = bake(many + "--out two.midair");
    EXPECT_EQ(again.code, 0) << again.output;
    EXPECT_NE(again.output.find("chunks; continuing"), std::string::npos) << again.output;
    EXPECT_TRUE(read("one.midair") == read("two.midair"));
}

TEST_F(Baking, ADamagedPieceIsSeenAndDoneAgain)
{
    ASSERT_EQ(bake(frames("--out one.midair")).code, 0);
    ASSERT_EQ(bake(frames("--shard 1/2 --out a.part")).code, 0);
    ASSERT_EQ(bake(frames("--shard 2/2 --out b.part")).code, 0);
    std::string bytes = read("a.part");
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    write("a.part", bytes);
    const Outcome refused = bake("--merge a.part b.part --out two.midair");
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.output.find("\"a.part\": 1 of its pieces is damaged"), std::string::npos)
        << refused.output;
    ASSERT_EQ(bake(frames("--shard 1/2 --out a.part")).code, 0);
    ASSERT_EQ(bake("--merge a.part b.part --out two.midair").code, 0);
    EXPECT_TRUE(read("one.midair") == read("two.midair"));
}

TEST_F(Baking, CapsHoldAsWhenTheSceneIsPlayed)
{
    ASSERT_EQ(bake(frames("--out free.midair")).code, 0);
    EXPECT_GT(loudest(entries("free.midair")), 0.9);
    ASSERT_EQ(bake(frames("--out env.midair"), "OSG_MIDAIR_MAX_AMPLITUDE=0.4").code, 0);
    EXPECT_LE(loudest(entries("env.midair")), 0.4);
    EXPECT_GT(loudest(entries("env.midair")), 0.38);
    write("scene.osgt", scene("Device \"sim:?max-amplitude=0.3\" "));
    ASSERT_EQ(bake(frames("--out uri.midair")).code, 0);
    EXPECT_LE(loudest(entries("uri.midair")), 0.3);
    write("scene.osgt", scene("MaxPressure 300 "));
    ASSERT_EQ(bake(frames("--out pascal.midair")).code, 0);
    const std::vector<Entry> all = entries("pascal.midair");
    for (int k = 0; k < 20; ++k)
        EXPECT_LE(pressures(all[static_cast<std::size_t>(k)], k).maxCoeff(), 300.0 * 1.001) << k;
    // Limits that go by time are the player's, and that is told.
    write("scene.osgt", scene("Device \"sim:?ramp=2s\" "));
    const Outcome told = bake(frames("--out ramp.midair"));
    EXPECT_NE(told.output.find("ramp of the device \"sim:?ramp=2s\" acts at playback"),
              std::string::npos)
        << told.output;
}

TEST_F(Baking, FieldsInTurnFollowEachOtherAtTheirRate)
{
    write("scene.osgt", scene("Subsets 2 FieldRate 50 "));
    ASSERT_EQ(bake(frames("--out one.midair")).code, 0);
    const std::vector<Entry> all = entries("one.midair");
    ASSERT_EQ(all.size(), 20u * 5u); // 50 Hz at 10 frames a second
    for (std::size_t k = 0; k < all.size(); ++k)
        EXPECT_EQ(all[k].time_ns, k * 20000000u);
    // In step across frames: each of them is for one of the two points in turn.
    for (int k = 0; k < 20; ++k)
    {
        const Eigen::VectorXd a_Pa = pressures(all[static_cast<std::size_t>(5 * k)], k);
        const Eigen::VectorXd b_Pa = pressures(all[static_cast<std::size_t>(5 * k + 1)], k);
        EXPECT_LT(std::min(a_Pa(0), a_Pa(1)), 0.5 * std::max(a_Pa(0), a_Pa(1))) << k;
        EXPECT_NE(a_Pa(0) > a_Pa(1), b_Pa(0) > b_Pa(1)) << k;
    }
}

// The hands of a recording are known beforehand, and so is what they touch.
TEST_F(Baking, WhatRecordedHandsTouchIsPlayedFieldByField)
{
    const std::string samples = MIDAIR_ROOT "/samples/";
    std::filesystem::copy_file(samples + "models/star.obj", at("star.obj"));
    std::filesystem::copy_file(samples + "hands/star.csv", at("star.csv"));
    write("touched.osgt",
          "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"
          "osgMidair::HapticScene { UniqueID 1 Children 1 {\n"
          "  osgMidair::HapticSurface { UniqueID 2 Children 1 {\n"
          "    osg::ProxyNode { UniqueID 3 FileNames 1 { \"star.obj\" } } } }\n"
          "} FormatVersion 1 Array \"octagon\" Hands \"recorded:star.csv\" Render CONTACT }\n");
    const std::string work = "touched.osgt --frames 0:90 --fps 60 --chunk 45 --out ";
    const Outcome outcome = bake(work + "a.midair");
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    const std::vector<Entry> all = entries("a.midair");
    int dense = 0; // of a thousand fields a second
    int sounding = 0;
    for (std::size_t i = 1; i < all.size(); ++i)
    {
        EXPECT_GT(all[i].time_ns, all[i - 1].time_ns);
        if (all[i].time_ns - all[i - 1].time_ns < 1'100'000) ++dense;
        if (all[i].kind == Kind::FIELD) ++sounding;
    }
    EXPECT_GT(dense, 200) << all.size();
    EXPECT_GT(sounding, 200) << all.size();
    ASSERT_EQ(bake(work + "1.part --shard 1/2").code, 0);
    ASSERT_EQ(bake(work + "2.part --shard 2/2").code, 0);
    ASSERT_EQ(bake("--out b.midair --merge 1.part 2.part").code, 0);
    EXPECT_TRUE(read("a.midair") == read("b.midair")) << "whoever solves it";
}

// Sensations have a course of their own; what needs unknown hands is refused.
TEST_F(Baking, SensationsArePlayedFieldByField)
{
    const auto sceneOf = [](const std::string& properties)
    {
        return "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"
               "osgMidair::HapticScene { UniqueID 1 Children 1 {\n"
               "  osgMidair::HapticSensation { UniqueID 2 Name \"drawn\" Sensation "
               "\"circle?radius=10mm\" " +
               properties + " }\n} FormatVersion 1 Array \"octagon\" }\n";
    };
    write("drawn.osgt", sceneOf("Pressure 1000 PressureUnit PASCAL"));
    ASSERT_EQ(bake("drawn.osgt --frames 0:30 --fps 60 --out a.midair").code, 0);
    const std::vector<Entry> all = entries("a.midair");
    const auto sounds = [](const Entry& one) { return one.kind == Kind::FIELD; };
    EXPECT_NEAR(static_cast<double>(std::count_if(all.begin(), all.end(), sounds)), 500.0, 30.0);
    ASSERT_EQ(bake("drawn.osgt --frames 0:30 --fps 60 --out b.midair").code, 0);
    EXPECT_TRUE(read("a.midair") == read("b.midair"));

    write("touched.osgt", sceneOf("Attach \"hand:palm\""));
    const Outcome refused = bake("touched.osgt --frames 0:30 --fps 60 --out c.midair");
    EXPECT_NE(refused.code, 0);
    EXPECT_NE(refused.output.find("its sensation needs hands"), std::string::npos)
        << refused.output;
}
