#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Range.h"
#include "plugin/extending/ArrayConversion.h"

#include <osgMidair/ArrayDescription>

#include <cmath>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using midair::haptics::TransducerArray;

constexpr std::size_t kMostTransducers = 65536; // the limit of files, too
constexpr double kFarthest_m = 10.0;
constexpr double kMostFactor = 1000.0;

static_assert(int(ArrayDescription::POINT) == int(midair::haptics::Directivity::POINT) &&
                  int(ArrayDescription::T4010A1_TABLE) ==
                      int(midair::haptics::Directivity::T4010A1_TABLE),
              "one order of directivities for both");

// NaN fails each comparison.
std::string wrong(const Transducer& one, int boardBefore)
{
    for (int k = 0; k < 3; ++k)
        if (!(std::abs(one.position[k]) <= kFarthest_m))
            return fmt::format("is at ({:g}, {:g}, {:g}) m; coordinates must be within -10 .. 10",
                               one.position.x(),
                               one.position.y(),
                               one.position.z());
    const double length = one.normal.length();
    if (!(length > 1e-12) || !std::isfinite(length))
        return fmt::format("has the normal ({:g}, {:g}, {:g}); it must have a direction",
                           one.normal.x(),
                           one.normal.y(),
                           one.normal.z());
    if (!(std::abs(one.phaseOffset_rad) <= kMostFactor))
        return fmt::format("has the phase offset {:g}; it must be within -1000 .. 1000 rad",
                           one.phaseOffset_rad);
    if (!(one.gain >= 0.0 && one.gain <= kMostFactor))
        return fmt::format("has the gain {:g}; it must be within 0 .. 1000", one.gain);
    if (one.board != boardBefore && one.board != boardBefore + 1)
        return fmt::format("is on board {}; boards count up from 0 without a gap", one.board);
    return {};
}

std::string wrongLevels(const ArrayDescription& array)
{
    if (array.phaseLevels != 0 && (array.phaseLevels < 2 || array.phaseLevels > 65536))
        return fmt::format("phaseLevels is {}; it must be 0 or 2 .. 65536", array.phaseLevels);
    float before = -1.0F;
    for (const float level : array.amplitudeLevels)
    {
        if (!(level > before && level >= 0.0F && level <= 1.0F))
            return fmt::format("the amplitude level {:g} must be above the one before it and "
                               "within 0 .. 1",
                               level);
        before = level;
    }
    if (!array.amplitudeLevels.empty() && before != 1.0F)
        return fmt::format("the last amplitude level is {:g}; it must be 1", before);
    return {};
}

std::string wrongTransducers(const ArrayDescription& array)
{
    const std::size_t m = array.transducers.size();
    if (m < 1 || m > kMostTransducers)
        return fmt::format("there are {} transducers; there must be 1 .. {}", m, kMostTransducers);
    int board = 0;
    for (std::size_t i = 0; i < m; ++i)
    {
        const std::string what = i == 0 && array.transducers[0].board != 0
                                     ? "is on a board other than 0, being the first"
                                     : wrong(array.transducers[i], board);
        if (!what.empty()) return fmt::format("transducer {} {}", i, what);
        board = array.transducers[i].board;
    }
    for (const unsigned int i : array.dead)
        if (i >= m) return fmt::format("transducer {} is dead, but there are {}, from 0", i, m);
    return {};
}

} // namespace

TransducerArray arrayOf(const ArrayDescription& description)
{
    std::string error;
    if (!description.isValid(error))
        throw midair::base::InputError("array \"" + description.name + "\": " + error);
    TransducerArray array;
    array.name = description.name;
    array.frequency_Hz = description.frequency_Hz;
    array.sourceAmplitude_Pa_m = description.sourceAmplitude_Pa_m;
    array.exposureAmplitude_Pa_m = description.exposureAmplitude_Pa_m;
    array.directivity = static_cast<midair::haptics::Directivity>(description.directivity);
    array.ringing_s = description.ringing_s;
    array.drive.phaseLevels = description.phaseLevels;
    array.drive.amplitudeLevels = description.amplitudeLevels;
    const auto m = static_cast<Eigen::Index>(description.transducers.size());
    array.positions.resize(3, m);
    array.normals.resize(3, m);
    array.phaseOffset_rad.resize(m);
    array.gain.resize(m);
    for (Eigen::Index i = 0; i < m; ++i)
    {
        const Transducer& one = description.transducers[static_cast<std::size_t>(i)];
        const osg::Vec3d normal = one.normal / one.normal.length();
        array.positions.col(i) << one.position.x(), one.position.y(), one.position.z();
        array.normals.col(i) << normal.x(), normal.y(), normal.z();
        array.phaseOffset_rad[i] = one.phaseOffset_rad;
        array.gain[i] = one.gain;
        array.board.push_back(one.board);
    }
    // Arrays with equal transducers are solved without these factors.
    if (array.phaseOffset_rad.isZero(0.0)) array.phaseOffset_rad.resize(0);
    if ((array.gain.array() == 1.0).all()) array.gain.resize(0);
    array.setDead({description.dead.begin(), description.dead.end()});
    return array;
}

ArrayDescription describe(const TransducerArray& array)
{
    ArrayDescription description;
    description.name = array.name;
    description.frequency_Hz = array.frequency_Hz;
    description.sourceAmplitude_Pa_m = array.sourceAmplitude_Pa_m;
    description.exposureAmplitude_Pa_m = array.exposureAmplitude_Pa_m;
    description.directivity = static_cast<ArrayDescription::Directivity>(array.directivity);
    description.ringing_s = array.ringing_s;
    description.phaseLevels = array.drive.phaseLevels;
    description.amplitudeLevels = array.drive.amplitudeLevels;
    description.dead.assign(array.dead.begin(), array.dead.end());
    description.transducers.resize(static_cast<std::size_t>(array.size()));
    for (int i = 0; i < array.size(); ++i)
    {
        Transducer& one = description.transducers[static_cast<std::size_t>(i)];
        one.position.set(array.positions(0, i), array.positions(1, i), array.positions(2, i));
        one.normal.set(array.normals(0, i), array.normals(1, i), array.normals(2, i));
        one.board = array.board[static_cast<std::size_t>(i)];
        if (array.phaseOffset_rad.size() > 0) one.phaseOffset_rad = array.phaseOffset_rad[i];
        if (array.gain.size() > 0) one.gain = array.gain[i];
    }
    for (const int i : array.dead) // the list marks them as dead; emptying it restores them
        description.transducers[static_cast<std::size_t>(i)].gain = 1.0;
    return description;
}

void ArrayDescription::addGrid(const osg::Vec3d& middle,
                               const osg::Vec3d& normal,
                               const osg::Vec3d& along,
                               unsigned int columns,
                               unsigned int rows,
                               double pitch_m)
{
    osg::Vec3d n = normal;
    n.normalize();
    osg::Vec3d u = along - n * (along * n);
    u.normalize();
    const osg::Vec3d v = n ^ u;
    const int board = transducers.empty() ? 0 : transducers.back().board + 1;
    for (unsigned int row = 0; row < rows; ++row)
        for (unsigned int column = 0; column < columns; ++column)
        {
            Transducer one;
            one.position = middle + u * (pitch_m * (column - 0.5 * (columns - 1.0))) +
                           v * (pitch_m * (row - 0.5 * (rows - 1.0)));
            one.normal = n;
            one.board = board;
            transducers.push_back(one);
        }
}

bool ArrayDescription::isValid(std::string& error) const
{
    if (!midair::base::RangeCheck()
             .within("frequency_Hz", frequency_Hz, 1e-300, 1e7)
             .within("sourceAmplitude_Pa_m", sourceAmplitude_Pa_m, 1e-30, 1e5)
             .check(exposureAmplitude_Pa_m == 0.0 ||
                        (exposureAmplitude_Pa_m >= 1e-30 && exposureAmplitude_Pa_m <= 1e5),
                    "exposureAmplitude_Pa_m",
                    exposureAmplitude_Pa_m,
                    "0 or 1e-30 .. 1e5")
             .within("ringing_s", ringing_s, 0.0, midair::haptics::kMostRinging_s)
             .passed(&error))
        return false;
    error = wrongLevels(*this);
    if (error.empty()) error = wrongTransducers(*this);
    return error.empty();
}

bool ArrayDescription::load(const std::string& nameOrPath,
                            ArrayDescription& description,
                            std::string& error)
{
    return succeeds([&] { description = describe(TransducerArray::load(nameOrPath)); }, error);
}

bool ArrayDescription::save(const std::string& path, std::string& error) const
{
    return succeeds([&] { arrayOf(*this).save(path); }, error);
}

} // namespace osgMidair
