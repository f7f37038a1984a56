#include "haptics/array/PatFile.h"

#include "haptics/array/Medium.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair::haptics;

namespace
{

/// A file as OpenMPD writes it, of a board that isn't there: column by column from the upper left,
/// pins and adjustments mixed.
struct Pat
{
    std::vector<std::string> lines;
    std::vector<int> pin;
    std::vector<int> delay_deg;
    std::vector<Eigen::Vector3d> place;

    Pat()
    {
        std::string places;
        std::string pins;
        std::string phases;
        std::string amplitudes;
        for (int t = 0; t < 256; ++t)
        {
            const int row = t / 16;
            place.emplace_back((row - 7.5) * 0.0105, (7.5 - t % 16) * 0.0105, 0.0);
            pin.push_back((t * 37 + 11) % 256);
            delay_deg.push_back((t * 53) % 361 - 180);
            char text[80];
            std::snprintf(
                text, sizeof text, "(%f, %f, %f),", place[t].x(), place[t].y(), place[t].z());
            places += text;
            pins += std::to_string(pin[t]) + ",";
            phases += std::to_string(delay_deg[t]) + ",";
            amplitudes += t == 5 ? "0.800000," : "1.000000,";
        }
        lines = {"FT000001", "256", "128", places, pins, phases, amplitudes};
    }

    std::string text(const char* end = "\n") const
    {
        std::string all;
        for (const std::string& line : lines)
            all += line + end;
        return all;
    }
};

std::string errorOf(const Pat& pat)
{
    try
    {
        readPat(pat.text(), "board.pat");
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return "no error";
}

} // namespace

TEST(PatFile, IsPutIntoPinOrder)
{
    const Pat pat;
    for (const char* end : {"\n", "\r\n"})
    {
        const PatBoard board = readPat(pat.text(end), "board.pat");
        EXPECT_EQ(board.serial, "FT000001");
        EXPECT_TRUE(board.array.isValid());
        ASSERT_EQ(board.array.size(), 256);
        EXPECT_EQ(board.array.directivity, Directivity::T4010A1_TABLE);
        EXPECT_EQ(board.array.drive.phaseLevels, 128);
        ASSERT_EQ(board.array.drive.amplitudeLevels.size(), 65U);
        EXPECT_EQ(board.array.drive.amplitudeLevels.back(), 1.0f);
        EXPECT_TRUE(board.array.positions.col(11).isApprox(Eigen::Vector3d(-0.07875, 0.07875, 0)));
        EXPECT_TRUE(board.array.positions.col(48).isApprox(Eigen::Vector3d(-0.07875, 0.06825, 0)));
        EXPECT_NEAR(board.array.gain[(5 * 37 + 11) % 256], 1.25, 1e-12);
    }
}

// Apart from everything that reads: OpenMPD's driver takes the adjustment, in degrees, off the
// delay that it wants of a transducer and sends the rest to its pin; a transducer that then is in
// phase with the others is later by itself by the adjustment.
TEST(PatFile, GivesAFocusWhoseOffsetsAreMadeUpFor)
{
    const Pat pat;
    const std::string path =
        testing::TempDir() + "midair-pat-" + std::to_string(::getpid()) + ".json";
    readPat(pat.text(), "board.pat").array.save(path);
    const TransducerArray array = TransducerArray::load(path);
    std::remove(path.c_str());
    ASSERT_EQ(array.size(), 256);
    ASSERT_EQ(array.phaseOffset_rad.size(), 256);
    const double k = 2.0 * midair::base::kPi * array.frequency_Hz / Medium{}.soundSpeed();
    const Eigen::Vector3d focus(0.02, 0.03, 0.12);
    for (int t = 0; t < 256; ++t)
    {
        // Ours: what pin p is driven with so that it arrives with phase 0.
        const int p = pat.pin[static_cast<std::size_t>(t)];
        const double driven =
            k * (focus - array.positions.col(p)).norm() - array.phaseOffset_rad[p];
        // Theirs: a delay in radians, which is our phase with the sign changed.
        const double wanted = -k * (focus - pat.place[static_cast<std::size_t>(t)]).norm();
        const double sent =
            wanted - pat.delay_deg[static_cast<std::size_t>(t)] * midair::base::kPi / 180.0;
        EXPECT_NEAR(std::abs(std::polar(1.0, driven) - std::polar(1.0, -sent)), 0.0, 1e-6) << t;
    }
}

TEST(PatFile, NamesTheLineThatIsWrong)
{
    const auto with = [](std::size_t line, const std::string& text)
    {
        Pat pat;
        pat.lines[line - 1] = text;
        return errorOf(pat);
    };
    const Pat good;
    EXPECT_EQ(errorOf(good), "no error");
    EXPECT_EQ(with(1, ""),
              "board.pat, line 1: is \"\"; it must be the serial number of the board's FT232H");
    EXPECT_EQ(with(2, "255"),
              "board.pat, line 2: is \"255\"; it must be the number of transducers, 256");
    EXPECT_EQ(with(3, "64"),
              "board.pat, line 3: is \"64\"; it must be the number of phase levels, 128");
    EXPECT_EQ(with(4, "(0, 0, 0),(1, 2),"),
              "board.pat, line 4: place 1 is (1, 2); it must be (x, y, z) in metres");
    EXPECT_EQ(
        with(4, "(0, 0, 0),(1, 2, nan),"),
        "board.pat, line 4: \"nan\" is among the places; they must be numbers from -10 to 10");
    EXPECT_EQ(with(4, "(0, 0, 0),(1, 2, 3"), "board.pat, line 4: place 1 doesn't end");
    EXPECT_EQ(with(4, "(0, 0, 0)"),
              "board.pat, line 4: has 1 places (x, y, z) in metres; there must be 256");
    EXPECT_EQ(with(5, "48" + good.lines[4].substr(2)),
              "board.pat, line 5: pin 48 is there twice; each from 0 to 255 must be there once");
    EXPECT_EQ(with(5, "1.5" + good.lines[4].substr(2)),
              "board.pat, line 5: pin 1.5 isn't a whole number; each from 0 to 255 must be there "
              "once");
    EXPECT_EQ(with(5, "1,2,256"),
              "board.pat, line 5: \"256\" is among the pins; they must be numbers from 0 to 255");
    EXPECT_EQ(with(6, "1,2"), "board.pat, line 6: has 2 phase adjustments; there must be 256");
    EXPECT_EQ(
        with(6, "1,2,400"),
        "board.pat, line 6: \"400\" is among the phase adjustments; they must be numbers from "
        "-360 to 360");
    EXPECT_EQ(with(7, "1,0"),
              "board.pat, line 7: \"0\" is among the amplitude adjustments; they must be numbers "
              "from 0.01 to 100");
    Pat pat;
    pat.lines.emplace_back("more");
    EXPECT_EQ(errorOf(pat).find("board.pat, line 8: "), 0U) << errorOf(pat);
    pat.lines.resize(5);
    EXPECT_EQ(errorOf(pat).find("board.pat, line 6: "), 0U) << errorOf(pat);
    EXPECT_NE(errorOf(pat).find("256 phase adjustments"), std::string::npos) << errorOf(pat);
}

// Whatever a file holds: an array that is valid, or a message.
TEST(PatFile, HoldsAnArrayOrIsRefused)
{
    const std::string good = Pat().text();
    std::mt19937 random(1);
    int refused = 0;
    for (int k = 0; k < 500; ++k)
    {
        std::string text = good;
        for (unsigned i = random() % 4; i-- > 0;)
            text[random() % text.size()] = "0,().-\n e9"[random() % 10];
        text.resize(random() % 3 == 0 ? random() % text.size() : text.size());
        try
        {
            EXPECT_TRUE(readPat(text, "board.pat").array.isValid()) << k;
        }
        catch (const midair::base::InputError& error)
        {
            EXPECT_EQ(std::string(error.what()).find("board.pat, line "), 0U) << error.what();
            ++refused;
        }
    }
    EXPECT_GT(refused, 100);
    EXPECT_LT(refused, 500);
}
