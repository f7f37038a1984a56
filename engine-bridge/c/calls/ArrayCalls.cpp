// midair_array_..(): arrays of the C interface.
#include "engine-bridge/c/inside/Scene.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/Range.h"

#include <cmath>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

constexpr std::size_t kMostTransducers = 65536; // limit of files, too
constexpr double kFarthest_m = 10.0;
constexpr double kMostFactor = 1000.0;

midair_array* added(haptics::TransducerArray array, std::string file = {})
{
    return arrays().add(std::make_shared<ArrayPair>(std::move(array), std::move(file)));
}

// Each comparison is written so that NaN fails it.
std::string wrong(const midair_transducer& one, int boardBefore)
{
    for (const double coordinate : one.position)
        if (!(std::abs(coordinate) <= kFarthest_m))
            return fmt::format("has the coordinate {:g} m; it must be within -10 .. 10",
                               coordinate);
    const double length = std::hypot(one.normal[0], one.normal[1], one.normal[2]);
    if (!(length > 1e-12) || !std::isfinite(length))
        return fmt::format("has the normal ({:g}, {:g}, {:g}); it must have a direction",
                           one.normal[0],
                           one.normal[1],
                           one.normal[2]);
    if (!(std::abs(one.phase_offset_rad) <= kMostFactor))
        return fmt::format("has the phase offset {:g}; it must be within -1000 .. 1000 rad",
                           one.phase_offset_rad);
    if (!(one.gain >= 0.0 && one.gain <= kMostFactor))
        return fmt::format("has the gain {:g}; it must be within 0 .. 1000", one.gain);
    if (one.board != boardBefore && one.board != boardBefore + 1)
        return fmt::format("is on board {}; boards count up from 0 without a gap", one.board);
    if (one.dead != 0 && one.dead != 1)
        return fmt::format("has dead {}; it must be 0 or 1", one.dead);
    return {};
}

void fill(const midair_transducer* given, std::size_t count, haptics::TransducerArray& array)
{
    const auto m = static_cast<Eigen::Index>(count);
    array.positions.resize(3, m);
    array.normals.resize(3, m);
    array.phaseOffset_rad.resize(m);
    array.gain.resize(m);
    std::vector<int> dead;
    for (Eigen::Index i = 0; i < m; ++i)
    {
        const midair_transducer& one = given[i];
        const std::string what = i == 0 && one.board != 0
                                     ? "is on a board other than 0, being the first"
                                     : wrong(one, i == 0 ? 0 : array.board.back());
        if (!what.empty()) fail(MIDAIR_INVALID, fmt::format("transducer {} {}", i, what));
        array.positions.col(i) = Eigen::Vector3d::Map(one.position);
        array.normals.col(i) = Eigen::Vector3d::Map(one.normal).normalized();
        array.phaseOffset_rad[i] = one.phase_offset_rad;
        array.gain[i] = one.gain;
        array.board.push_back(one.board);
        if (one.dead) dead.push_back(static_cast<int>(i));
    }
    // Without these factors arrays of identical transducers are solved faster.
    if (array.phaseOffset_rad.isZero(0.0)) array.phaseOffset_rad.resize(0);
    if ((array.gain.array() == 1.0).all()) array.gain.resize(0);
    array.setDead(dead);
}

} // namespace

midair_status midair_array_load(const char* name_or_file, midair_array** array)
{
    return called(
        [&]
        {
            given(array, "array");
            std::string file = textGiven(name_or_file, "name_or_file", 4096);
            haptics::TransducerArray read = haptics::TransducerArray::load(file);
            *array = added(std::move(read), std::move(file));
        });
}

midair_status midair_array_from_json(const char* json, midair_array** array)
{
    return called(
        [&]
        {
            constexpr std::size_t kMostBytes = std::size_t(64) << 20;
            given(array, "array");
            *array = added(
                haptics::TransducerArray::fromJson(textGiven(json, "json", kMostBytes), "json"));
        });
}

midair_status midair_array_make(const char* name,
                                const midair_transducer* transducers,
                                size_t count,
                                double frequency_Hz,
                                double source_Pa_m,
                                midair_array** array)
{
    return called(
        [&]
        {
            given(array, "array");
            given(transducers, "transducers");
            if (count < 1 || count > kMostTransducers)
                fail(MIDAIR_INVALID,
                     fmt::format("count is {}; there must be 1 .. {} transducers",
                                 count,
                                 kMostTransducers));
            haptics::TransducerArray made;
            made.name = textGiven(name, "name", 256);
            made.frequency_Hz = frequency_Hz;
            made.sourceAmplitude_Pa_m = source_Pa_m;
            std::string error;
            if (!base::RangeCheck()
                     .within("frequency_Hz", frequency_Hz, 1e-300, 1e7)
                     .within("source_Pa_m", source_Pa_m, 1e-30, 1e5)
                     .passed(&error))
                fail(MIDAIR_INVALID, error);
            fill(transducers, count, made);
            if (!made.isValid(&error)) fail(MIDAIR_INVALID, error);
            *array = added(std::move(made));
        });
}

midair_status midair_array_size(const midair_array* array, size_t* transducers)
{
    return called(
        [&]
        {
            const auto pair = arrays().find(array);
            given(transducers, "transducers") = static_cast<std::size_t>(pair->given.size());
        });
}

midair_status
midair_array_transducers(const midair_array* array, midair_transducer* transducers, size_t capacity)
{
    return called(
        [&]
        {
            const auto pair = arrays().find(array);
            const haptics::TransducerArray& all = pair->given;
            given(transducers, "transducers");
            if (capacity < static_cast<std::size_t>(all.size()))
                fail(MIDAIR_TOO_SMALL,
                     fmt::format("capacity is {}; there are {} transducers", capacity, all.size()));
            for (int i = 0; i < all.size(); ++i)
            {
                midair_transducer& one = transducers[i];
                Eigen::Vector3d::Map(one.position) = all.positions.col(i);
                Eigen::Vector3d::Map(one.normal) = all.normals.col(i);
                one.phase_offset_rad =
                    all.phaseOffset_rad.size() > 0 ? all.phaseOffset_rad[i] : 0.0;
                one.gain = all.gain.size() > 0 ? all.gain[i] : 1.0;
                one.board = all.board[static_cast<std::size_t>(i)];
                one.dead = 0;
            }
            for (const int i : all.dead)
            {
                transducers[i].dead = 1;
                transducers[i].gain = 1.0; // dead is a member of its own
            }
        });
}

midair_status midair_array_close(midair_array* array)
{
    return called([&] { arrays().take(array); });
}
