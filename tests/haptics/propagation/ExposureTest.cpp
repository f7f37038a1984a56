#include "haptics/propagation/Exposure.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

TransducerArray pointSource()
{
    TransducerArray array;
    array.positions = Eigen::Vector3d::Zero();
    array.normals = Eigen::Vector3d::UnitZ();
    array.board = {0};
    return array;
}

Eigen::VectorXcf randomPhases(const Eigen::VectorXf& amplitudes, std::mt19937& random)
{
    std::uniform_real_distribution<float> turn(0.0f, static_cast<float>(base::kTwoPi));
    Eigen::VectorXcf q(amplitudes.size());
    for (Eigen::Index i = 0; i < q.size(); ++i)
        q[i] = std::polar(amplitudes[i], turn(random));
    return q;
}

} // namespace

TEST(Exposure, OneTransducerIsAsLoudAsItsDataSheetSays)
{
    const Eigen::Matrix3Xd place = Eigen::Vector3d(0.0, 0.0, 0.30);
    const Exposure ears(pointSource(), Medium(), place);
    const Eigen::VectorXcf full = Eigen::VectorXcf::Ones(1);
    const double absorbed_dB = 20.0 * std::log10(std::exp(1.0)) * Medium().attenuation(40e3) * 0.30;
    EXPECT_NEAR(absorbed_dB, 0.4, 0.05);
    constexpr double kOnAxis_dB = 121.5 + kHeadMargin_dB;
    EXPECT_NEAR(soundLevel_dB(ears.incoherent_Pa2(full)[0]), kOnAxis_dB - absorbed_dB, 0.05);
    EXPECT_NEAR(soundLevel_dB(ears.coherent_Pa2(full)[0]), kOnAxis_dB - absorbed_dB, 0.05);
    EXPECT_NEAR(soundLevel_dB(ears.heard_Pa2({full})[0]), kOnAxis_dB - absorbed_dB, 0.05);
    // Half the amplitude is 6 dB less, half of the time 3 dB.
    const Eigen::VectorXcf half = 0.5f * full;
    EXPECT_NEAR(soundLevel_dB(ears.incoherent_Pa2(half)[0]), kOnAxis_dB - absorbed_dB - 6.02, 0.05);
    const Eigen::VectorXcf silent = Eigen::VectorXcf::Zero(1);
    EXPECT_NEAR(
        soundLevel_dB(ears.heard_Pa2({full, silent})[0]), kOnAxis_dB - absorbed_dB - 3.01, 0.05);
    EXPECT_EQ(soundLevel_dB(ears.heard_Pa2({silent})[0]), 0.0);
}

// 2.73 Pa m in the ring and 10.1 alone are one piece of hardware: 11.4 dB.
TEST(Exposure, OneUnitIsAsLoudInTheRingAsAlone)
{
    const TransducerArray alone = TransducerArray::load("autd3");
    TransducerArray ofRing = alone;
    for (const char* name : {"octagon", "octagon-autd3"})
    {
        const TransducerArray ring = TransducerArray::load(name);
        EXPECT_EQ(ring.sourceAmplitude_Pa_m, 2.73) << name;
        EXPECT_EQ(ring.heardAmplitude_Pa_m(), alone.heardAmplitude_Pa_m()) << name;
        ofRing.sourceAmplitude_Pa_m = ring.sourceAmplitude_Pa_m;
        ofRing.exposureAmplitude_Pa_m = ring.exposureAmplitude_Pa_m;
        ofRing.directivity = ring.directivity;
        const Eigen::VectorXcf full = Eigen::VectorXcf::Ones(alone.size());
        for (const Eigen::Vector3d& place :
             {Eigen::Vector3d(0.0, 0.0, 0.5), Eigen::Vector3d(0.25, 0.0, 0.43)})
        {
            const double alone_dB = soundLevel_dB(
                static_cast<double>(Exposure(alone, Medium(), place).incoherent_Pa2(full)[0]));
            const double ring_dB = soundLevel_dB(
                static_cast<double>(Exposure(ofRing, Medium(), place).incoherent_Pa2(full)[0]));
            EXPECT_GT(ring_dB, alone_dB - 0.3) << name << " at " << place.transpose();
            EXPECT_LT(ring_dB, alone_dB + 1.5) << name << ", whose directivity is wider";
        }
    }
}

TEST(Exposure, OneNumberIsForEarsTooUnlessTheTransducerIsKnownBetter)
{
    const auto read = [](const char* source, const char* directivity, const std::string& more = "")
    {
        return TransducerArray::fromJson(
            std::string(R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": )") + source +
                R"(, "directivity": ")" + directivity + "\", " + more +
                R"("transducers": [{"position_m": [0, 0, 0], "normal": [0, 0, 1]}]})",
            "own.json");
    };
    EXPECT_EQ(read("2.73", "point").heardAmplitude_Pa_m(), 2.73);
    EXPECT_EQ(read("20", "point").heardAmplitude_Pa_m(), 20.0);
    for (const char* known : {"t4010a1-table", "t4010a1-harmonics"})
    {
        EXPECT_EQ(read("2.73", known).heardAmplitude_Pa_m(), 10.1) << known;
        EXPECT_EQ(read("20", known).heardAmplitude_Pa_m(), 20.0) << known;
        const std::string measured = R"("exposureAmplitude_Pa_m": 5, )";
        EXPECT_EQ(read("2.73", known, measured).heardAmplitude_Pa_m(), 5.0) << known;
        EXPECT_EQ(read("7", known, measured).heardAmplitude_Pa_m(), 7.0) << known;
    }
}

TEST(Exposure, OfTwoAmplitudesTheLargerCountsAtEars)
{
    TransducerArray array = pointSource();
    array.directivity = Directivity::POINT;
    const Eigen::Matrix3Xd place = Eigen::Vector3d(0.0, 0.0, 0.3);
    const auto level_dB = [&]
    {
        return soundLevel_dB(static_cast<double>(
            Exposure(array, Medium(), place).incoherent_Pa2(Eigen::VectorXcf::Ones(1))[0]));
    };
    array.sourceAmplitude_Pa_m = 2.0;
    const double one_dB = level_dB();
    array.exposureAmplitude_Pa_m = 1.0;
    EXPECT_EQ(level_dB(), one_dB);
    array.exposureAmplitude_Pa_m = 20.0;
    EXPECT_NEAR(level_dB(), one_dB + 20.0, 1e-4);
}

// What installations tell their operators stands in the table of what is known.
TEST(Exposure, TheLimitsThatProgramsNameAreThoseOfTheDocument)
{
    std::ifstream file(MIDAIR_ROOT "/samples/guides/SAFETY.md");
    std::ostringstream text;
    text << file.rdbuf();
    const auto row = [](const char* whose, double limit_dB) {
        return std::string("| ") + whose + " | **" + std::to_string(std::lround(limit_dB)) +
               "** | [";
    };
    EXPECT_NE(text.str().find(row("public", kPublicEarLimit_dB)), std::string::npos);
    EXPECT_NE(text.str().find(row("workers, 8 h", kWorkersEarLimit_dB)), std::string::npos);
    EXPECT_EQ(ExposureFigures().head_dB, kHeadMargin_dB);
}

// No limit from memory: each row of the table has a link to what its number was read in, or is of
// the same source as the row above.
TEST(Exposure, EachLimitOfTheDocumentNamesWhereItWasRead)
{
    std::ifstream file(MIDAIR_ROOT "/samples/guides/SAFETY.md");
    int rows = 0;
    bool isInside = false;
    for (std::string line; std::getline(file, line);)
    {
        const bool isHead = line.rfind("| who |", 0) == 0;
        isInside = isHead || (isInside && !line.empty());
        if (!isInside || isHead || line.rfind("| ", 0) != 0) continue;
        ++rows;
        const std::string last = line.substr(line.rfind(" | ") + 3);
        EXPECT_TRUE(last.find("](http") != std::string::npos || last == "the same |") << line;
        EXPECT_EQ(line.find("second hand"), std::string::npos) << line;
    }
    EXPECT_GE(rows, 5);
}

TEST(Exposure, LevelsAndMeanSquaresAreInverse)
{
    EXPECT_NEAR(soundLevel_dB(1.0), 93.98, 0.01);
    EXPECT_NEAR(soundLevel_dB(meanSquareOf_Pa2(110.0)), 110.0, 1e-9);
    EXPECT_EQ(soundLevel_dB(0.0), 0.0);
    EXPECT_TRUE(std::isnan(soundLevel_dB(std::nan(""))));
}

TEST(Exposure, TheIncoherentSumIsTheMeanOverPhasesAndSpeckleItsSpread)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    // Towards the open end of the prism, at its rim, and inside.
    Eigen::Matrix3Xd places(3, 3);
    places.col(0) << 0.0, 0.5, 0.0;
    places.col(1) << 0.3, 0.4, 0.1;
    places.col(2) << 0.01, 0.02, 0.0;
    Exposure ears(array, Medium(), places);
    std::mt19937 random(7);
    Eigen::VectorXf amplitudes(array.size());
    std::uniform_real_distribution<float> amplitude(0.0f, 1.0f);
    for (float& one : amplitudes)
        one = amplitude(random);
    const Eigen::VectorXf expected = ears.incoherent_Pa2(amplitudes.cast<std::complex<float>>());
    std::vector<std::vector<double>> ratios(3);
    for (int trial = 0; trial < 1000; ++trial)
    {
        const Eigen::MatrixXcf p = ears.spots_Pa(randomPhases(amplitudes, random));
        for (Eigen::Index l = 0; l < 3; ++l)
            for (Eigen::Index k = 0; k < Exposure::kSpots; ++k)
                ratios[static_cast<std::size_t>(l)].push_back(0.5 * std::norm(p(k, l)) /
                                                              expected[l]);
    }
    for (std::vector<double>& one : ratios)
    {
        double mean = 0.0;
        for (const double ratio : one)
            mean += ratio / static_cast<double>(one.size());
        EXPECT_NEAR(10.0 * std::log10(mean), 0.0, 0.1);
        std::sort(one.begin(), one.end());
        const double percentile = one[one.size() * 99 / 100];
        EXPECT_NEAR(10.0 * std::log10(percentile), 10.0 * std::log10(Exposure::kSpeckle), 0.5);
    }
}

// Against the model's slow form, at places that hear all of a board.
TEST(Exposure, PhasesAreThoseOfTheModel)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.phaseOffset_rad = Eigen::VectorXd::LinSpaced(array.size(), 0.0, 3.0);
    array.gain = Eigen::VectorXd::LinSpaced(array.size(), 0.5, 1.0);
    Eigen::Matrix3Xd places(3, 2);
    places.col(0) << 0.1, -0.2, 0.4;
    places.col(1) << 0.0, 0.05, 0.5;
    Exposure ears(array, Medium(), places);
    std::mt19937 random(3);
    const Eigen::VectorXcf q = randomPhases(Eigen::VectorXf::Ones(array.size()), random);
    const auto expected = [&]
    {
        return (std::pow(10.0, 0.05 * kHeadMargin_dB) *
                referencePropagationMatrix(ears.places(), array, Medium()) *
                q.cast<std::complex<double>>())
            .eval();
    };
    for (int moved = 0; moved < 2; ++moved)
    {
        const Eigen::VectorXcd p = expected();
        const Eigen::VectorXf square = ears.coherent_Pa2(q);
        const Eigen::MatrixXcf spots = ears.spots_Pa(q);
        for (Eigen::Index l = 0; l < 2; ++l)
        {
            EXPECT_NEAR(square[l] / (0.5 * std::norm(p[l])), 1.0, 1e-3);
            EXPECT_NEAR(
                std::abs(std::complex<double>(spots(0, l)) - p[l]) / std::abs(p[l]), 0.0, 1e-3);
        }
        ears.move(1, Eigen::Vector3d(0.2, 0.2, 0.3));
    }
}

// Tenth by tenth of a kelvin, and at once, to air that is known to be another.
TEST(Exposure, ListensInTheAirOfNow)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::Matrix3Xd places = placesAround(array, 4);
    std::mt19937 random(4);
    const Eigen::VectorXcf q = randomPhases(Eigen::VectorXf::Ones(array.size()), random);
    Medium medium;
    Exposure ears(array, medium, places);
    ears.spots_Pa(q);
    const auto expectAsNew = [&]
    {
        Exposure anew(array, medium, places);
        const float most = std::sqrt(anew.incoherent_Pa2(q).maxCoeff());
        const Eigen::MatrixXcf off = ears.spots_Pa(q) - anew.spots_Pa(q);
        EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-3f * most);
        EXPECT_TRUE(ears.coherent_Pa2(q).isApprox(anew.coherent_Pa2(q), 1e-3f));
        EXPECT_TRUE(ears.incoherent_Pa2(q).isApprox(anew.incoherent_Pa2(q), 1e-4f));
    };
    for (int step = 0; step < 20; ++step)
    {
        medium.temperature_C += 0.1;
        ears.setMedium(medium);
    }
    expectAsNew();
    medium.temperature_C -= 12.0;
    medium.relativeHumidity = 0.2;
    ears.setMedium(medium);
    expectAsNew();
}

TEST(Exposure, BoardsHideWhatIsBehindThem)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const FreeLines lines(array);
    Eigen::Index free = 0;
    for (Eigen::Index i = 0; i < array.size(); ++i)
    {
        EXPECT_TRUE(lines.isFree(i, Eigen::Vector3d::Zero()));
        EXPECT_FALSE(lines.isFree(i, 0.5 * array.normals.col(i).normalized() * -1.0))
            << "straight behind board " << array.board[static_cast<std::size_t>(i)];
        free += lines.isFree(i, Eigen::Vector3d(0.0, 0.5, 0.0)) ? 1 : 0;
    }
    EXPECT_EQ(free, array.size()) << "all are heard at the open end";
    const TransducerArray board = TransducerArray::singleBoard();
    EXPECT_TRUE(FreeLines(board).isFree(0, Eigen::Vector3d(0.3, 0.0, 0.1)));
    EXPECT_FALSE(FreeLines(board).isFree(0, Eigen::Vector3d(0.3, 0.0, -0.1)));
    // One transducer is no board: only its directivity counts.
    EXPECT_TRUE(FreeLines(pointSource()).isFree(0, Eigen::Vector3d(0.0, 0.0, -0.1)));
    const Eigen::Matrix3Xd behind = Eigen::Vector3d(0.0, 0.0, -0.3);
    EXPECT_EQ(
        Exposure(pointSource(), Medium(), behind).incoherent_Pa2(Eigen::VectorXcf::Ones(1))[0],
        0.0f);
}

TEST(Exposure, PlacesAreAroundTheArrayWhereItIsHeard)
{
    for (const char* name : {"octagon", "board", "openmpd", "sonicsurface", "ultraino64"})
    {
        const TransducerArray array = TransducerArray::load(name);
        const Eigen::Matrix3Xd places = placesAround(array, 30);
        ASSERT_GT(places.cols(), 10) << name;
        ASSERT_LE(places.cols(), 30) << name;
        const FreeLines lines(array);
        const double radius_m = places.col(0).norm();
        EXPECT_GE(radius_m, 0.5);
        for (Eigen::Index l = 0; l < places.cols(); ++l)
        {
            EXPECT_NEAR(places.col(l).norm(), radius_m, 1e-9) << name;
            bool isHeard = false;
            for (Eigen::Index i = 0; i < array.size() && !isHeard; ++i)
                isHeard = lines.isFree(i, places.col(l));
            EXPECT_TRUE(isHeard) << name << " " << places.col(l).transpose();
            for (Eigen::Index k = 0; k < l; ++k)
                EXPECT_GT((places.col(l) - places.col(k)).norm(), 0.05) << name;
        }
    }
    EXPECT_EQ(placesAround(TransducerArray(), 30).cols(), 0);
}

TEST(Exposure, ReflectorsAddTheirImagesWithPhasesOfTheirOwn)
{
    TransducerArray array = pointSource();
    Reflector wall;
    wall.position = {0.0, 0.0, 0.4};
    wall.accuracy_mm = 1.0;
    const Eigen::Matrix3Xd place = Eigen::Vector3d(0.1, 0.0, 0.25);
    const Eigen::VectorXcf full = Eigen::VectorXcf::Ones(1);
    const Exposure free(array, Medium(), place);
    const Exposure ofImage(array, Medium(), Eigen::Vector3d(0.1, 0.0, 0.55));
    array.reflectors = {wall};
    const Exposure ears(array, Medium(), place);
    const double expected = free.incoherent_Pa2(full)[0] + ofImage.incoherent_Pa2(full)[0];
    EXPECT_NEAR(ears.incoherent_Pa2(full)[0], expected, 1e-5 * expected);
    // A wall that takes sound away, on the way, isn't trusted to be there.
    array.reflectors.front().position[2] = 0.1;
    EXPECT_NEAR(Exposure(array, Medium(), place).incoherent_Pa2(full)[0],
                free.incoherent_Pa2(full)[0],
                1e-5 * expected);
}

TEST(Exposure, AScreenBehindThePointsIsAsLoudAgainAtTheEars)
{
    TransducerArray array = TransducerArray::singleBoard();
    const Eigen::VectorXf squares = Eigen::VectorXf::Ones(array.size());
    const auto loudest_dB = [&](const TransducerArray& of)
    {
        const Eigen::Matrix3Xd places = placesAround(array, 32);
        return soundLevel_dB(Exposure(of, Medium(), places).incoherentOf_Pa2(squares).maxCoeff());
    };
    const double free_dB = loudest_dB(array);
    TransducerArray before = array;
    Reflector screen;
    screen.position = {0.0, 0.0, 0.6};
    screen.accuracy_mm = 0.2;
    before.reflectors = {screen}; // just behind the places at 0.5 m: as loud again
    EXPECT_NEAR(loudest_dB(before) - free_dB, 3.0, 1.5);
    // Sound behind the board is heard only by way of a screen; its places count then.
    EXPECT_GE(placesAround(before, 1000).cols(), placesAround(array, 1000).cols());
    before.reflectors.front().position[2] = 0.25;
    EXPECT_GT(placesAround(before, 1000).cols(), placesAround(array, 1000).cols());
}
