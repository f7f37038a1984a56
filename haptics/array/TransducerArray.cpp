#include "haptics/array/TransducerArray.h"

#include "haptics/array/BoardGrid.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// Board of the paper's device: 192.0 x 151.4 mm, 18 x 14 places at 10.16 mm, three of them taken by
// connectors: (1, 1), (2, 1) and (16, 1), where its maker counts from 0 and gridPlaces() from 1.
constexpr double kBoardWidth_m = 0.1920;
constexpr double kBoardHeight_m = 0.1514;

Board paperBoard()
{
    Board board;
    board.places = gridPlaces(18, 14, 10.16e-3, {{2, 2}, {3, 2}, {17, 2}});
    return board;
}

// 256 levels of duty: base/DutyLaw.h.
DriveResolution paperDrive()
{
    DriveResolution drive;
    drive.phaseLevels = 256;
    drive.amplitudeLevels.resize(256);
    for (int L = 0; L < 256; ++L)
        drive.amplitudeLevels[static_cast<std::size_t>(L)] =
            static_cast<float>(base::dutyAmplitude(L));
    return drive;
}

// Measured by Inoue, Makino, Shinoda 2015: all 3984 transducers focused at the centre at drive
// level 32, that is a relative amplitude of sin(pi 32/510) = 0.196, give p_rms = 5.53 kPa there.
// The arrivals are in phase, so that
//     p_rms = P0 sin(pi 32/510) / sqrt(2) * sum_i D(theta_i) e^(-beta R_i) / R_i
// and the sum, over the geometry below in air of 20 C and 50 %, is 14,620 /m: the transducer's data
// sheet (121.5 dB SPL at 0.30 m: 10.1 Pa m) would give 20.4 kPa, so the pressure that the device
// reached in its cavity corresponds to
//     P0 = 10.1 * 5.53 / 20.4 = 2.73 Pa m.
// D is the paper's own, so P0 and D belong together.
constexpr double kPrismSourceAmplitude_Pa_m = 2.73;

/// Returns true if the list of dead transducers is as setDead() leaves it.
bool areDead(const TransducerArray& array)
{
    int before = -1;
    for (const int i : array.dead)
    {
        if (i <= before || i >= array.gain.size() || array.gain[i] != 0.0) return false;
        before = i;
    }
    return true;
}

} // namespace

TransducerArray TransducerArray::octagonalPrism()
{
    TransducerArray array;
    array.name = "octagon";
    array.sourceAmplitude_Pa_m = kPrismSourceAmplitude_Pa_m;
    array.exposureAmplitude_Pa_m = kT4010A1Source_Pa_m;
    array.directivity = Directivity::T4010A1_HARMONICS;
    array.drive = paperDrive();

    // The long edges of eight boards close a ring: apothem = edge (1 + sqrt 2)/2 = 231.8 mm.
    const double apothem_m = 0.5 * kBoardWidth_m * (1.0 + std::sqrt(2.0));
    for (int side = 0; side < 8; ++side)
    {
        const double angle = base::kTwoPi * side / 8.0;
        const Eigen::Vector3d outward(std::sin(angle), 0.0, std::cos(angle));
        for (const double y : {-0.5 * kBoardHeight_m, 0.5 * kBoardHeight_m})
        {
            Board board = paperBoard();
            board.position = apothem_m * outward + y * Eigen::Vector3d::UnitY();
            board.normal = -outward;
            board.columnsAlong = levelColumns(board.normal);
            appendBoard(board, array);
        }
    }
    return array;
}

TransducerArray TransducerArray::singleBoard()
{
    TransducerArray array;
    array.name = "board";
    array.drive = paperDrive();
    appendBoard(paperBoard(), array);
    return array;
}

double TransducerArray::heardAmplitude_Pa_m() const
{
    double known_Pa_m = exposureAmplitude_Pa_m;
    if (known_Pa_m == 0.0 && directivity != Directivity::POINT) known_Pa_m = kT4010A1Source_Pa_m;
    return std::max(sourceAmplitude_Pa_m, known_Pa_m);
}

void TransducerArray::setDead(const std::vector<int>& which)
{
    if (which.empty()) return;
    if (gain.size() == 0) gain.setOnes(size());
    for (const int i : which)
        gain[i] = 0.0;
    dead.insert(dead.end(), which.begin(), which.end());
    std::sort(dead.begin(), dead.end());
    dead.erase(std::unique(dead.begin(), dead.end()), dead.end());
}

bool TransducerArray::isValid(std::string* error) const
{
    const auto m = static_cast<std::size_t>(size());
    std::string text;
    if (m == 0)
        text = "the array has no transducers";
    else if (static_cast<std::size_t>(normals.cols()) != m || board.size() != m)
        text =
            fmt::format("{} positions, {} normals, {} board indices; there must be as many of each",
                        m,
                        normals.cols(),
                        board.size());
    else if (phaseOffset_rad.size() != 0 && static_cast<std::size_t>(phaseOffset_rad.size()) != m)
        text = fmt::format("{} phase offsets; there must be none or {}", phaseOffset_rad.size(), m);
    else if (gain.size() != 0 && static_cast<std::size_t>(gain.size()) != m)
        text = fmt::format("{} gains; there must be none or {}", gain.size(), m);
    else if (!positions.allFinite() || !phaseOffset_rad.allFinite() || !gain.allFinite())
        text = "a position, phase offset or gain is not finite";
    else if (!((normals.colwise().norm().array() - 1.0).abs() < 1e-6).all())
        text = "a normal is not of unit length";
    else if (!areDead(*this))
        text = "the dead transducers are not ascending numbers of transducers of gain 0";
    else
        return base::RangeCheck()
            .atLeast("gain", gain.size() != 0 ? gain.minCoeff() : 0.0, 0.0)
            .above("frequency_Hz", frequency_Hz, 0.0)
            .within(
                "sourceAmplitude_Pa_m", sourceAmplitude_Pa_m, kLeastSource_Pa_m, kMostSource_Pa_m)
            .check(exposureAmplitude_Pa_m == 0.0 || (exposureAmplitude_Pa_m >= kLeastSource_Pa_m &&
                                                     exposureAmplitude_Pa_m <= kMostSource_Pa_m),
                   "exposureAmplitude_Pa_m",
                   exposureAmplitude_Pa_m,
                   "0 (not known) or 1e-30 .. 1e30")
            .within("ringing", ringing_s, 0.0, kMostRinging_s, " s")
            .check(drive.phaseLevels == 0 || drive.phaseLevels >= 2,
                   "phaseLevels",
                   drive.phaseLevels,
                   "0 (continuous) or 2 and up")
            .passed(error);
    if (error != nullptr) *error = text;
    return false;
}

} // namespace midair::haptics
