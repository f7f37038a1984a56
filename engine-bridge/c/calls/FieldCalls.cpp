// midair_field_..(): solved and played fields.
#include "engine-bridge/c/inside/Field.h"
#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/base/text/Words.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/solvers/SolveReport.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

constexpr std::size_t kMostPlaces = 100'000'000;

const Eigen::VectorXcf& fieldAt(const Field& field, std::size_t index)
{
    if (index >= field.sequence.fields.size())
        fail(MIDAIR_UNKNOWN,
             fmt::format("index is {}; there are {} fields", index, field.sequence.fields.size()));
    return field.sequence.fields[index];
}

void requireTransducers(const Field& field, std::size_t transducers)
{
    if (transducers != field.info.transducers)
        fail(transducers < field.info.transducers ? MIDAIR_TOO_SMALL : MIDAIR_INVALID,
             fmt::format(
                 "transducers is {}; the field has {}", transducers, field.info.transducers));
}

/// The caller's places, 3 x n.
Eigen::Matrix3Xd placesOf(const double* places, std::size_t count)
{
    given(places, "places");
    if (count < 1 || count > kMostPlaces)
        fail(MIDAIR_INVALID, fmt::format("count is {}; it must be 1 .. {}", count, kMostPlaces));
    requireFinite(places, 3 * count, "places", 3);
    return Eigen::Map<const Eigen::Matrix3Xd>(places, 3, static_cast<Eigen::Index>(count));
}

void copyPoint(const Field& field, Eigen::Index l, midair_point& point)
{
    const haptics::ControlPoints& all = field.points;
    Eigen::Vector3d::Map(point.position) = all.positions.col(l);
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    if (all.normals.cols() > l) normal = all.normals.col(l);
    Eigen::Vector3d::Map(point.normal) = normal;
    point.wanted_Pa = field.wanted_Pa[l];
    point.achieved_Pa = field.achieved_Pa[l];
    point.object = 0;
    if (!all.object.empty())
    {
        const auto object = static_cast<std::size_t>(all.object[static_cast<std::size_t>(l)]);
        if (object < field.objects.size()) point.object = field.objects[object];
    }
    point.field = 0;
    point.reserved = 0;
}

std::string didYouMeanFigure(const Field& field, const std::string& name)
{
    std::vector<std::string> names;
    for (const auto& [known, value] : field.figures())
        names.push_back(known);
    const std::string meant = base::didYouMean(name, names);
    return meant.empty() ? fmt::format("; known are {}", fmt::join(names, ", ")) : meant;
}

} // namespace

midair_status midair_field_about(const midair_field* field, midair_field_info* info)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            given(info, "info") = of->info;
        });
}

midair_status midair_field_activations(const midair_field* field,
                                       size_t index,
                                       float* activations,
                                       size_t transducers)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            const Eigen::VectorXcf& q = fieldAt(*of, index);
            given(activations, "activations");
            requireTransducers(*of, transducers);
            std::copy_n(q.data(), q.size(), reinterpret_cast<std::complex<float>*>(activations));
        });
}

midair_status midair_field_view(const midair_field* field, size_t index, const float** activations)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            const Eigen::VectorXcf& q = fieldAt(*of, index);
            given(activations, "activations") = reinterpret_cast<const float*>(q.data());
        });
}

midair_status midair_field_write_drive(const midair_field* field, size_t index, const char* file)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            fieldAt(*of, index);
            const std::string path = textGiven(file, "file", 4096);
            std::ofstream out(path);
            if (!out) fail(MIDAIR_REFUSED, "cannot write " + path);
            haptics::TransducerArray array = *of->array;
            array.drive = of->drive;
            bridge::writeDrive(out, array, of->signals[index]);
            out.close();
            if (!out) fail(MIDAIR_REFUSED, "could not write " + path + " to its end");
        });
}

midair_status midair_field_levels(const midair_field* field,
                                  size_t index,
                                  int32_t* phases,
                                  int32_t* amplitudes,
                                  size_t transducers)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            fieldAt(*of, index);
            given(phases, "phases");
            given(amplitudes, "amplitudes");
            requireTransducers(*of, transducers);
            const bridge::LevelDrive levels = bridge::levelsOf(of->drive, of->signals[index]);
            std::copy(levels.phase.begin(), levels.phase.end(), phases);
            std::copy(levels.amplitude.begin(), levels.amplitude.end(), amplitudes);
        });
}

midair_status midair_field_points(const midair_field* field, midair_point* points, size_t capacity)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            given(points, "points");
            if (capacity < of->info.points)
                fail(MIDAIR_TOO_SMALL,
                     fmt::format("capacity is {}; there are {} points", capacity, of->info.points));
            for (Eigen::Index l = 0; l < of->points.size(); ++l)
                copyPoint(*of, l, points[l]);
            std::size_t done = 0;
            for (std::size_t k = 0; k < of->sequence.parts.size(); ++k)
                for (int l = 0; l < of->sequence.parts[k].size() && done < of->info.points; ++l)
                    points[done++].field = static_cast<std::uint32_t>(k);
        });
}

midair_status midair_field_figure(const midair_field* field, const char* name, double* value)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            const std::string wanted = textGiven(name, "name", 256);
            given(value, "value");
            if (wanted == kFingertipForce)
            {
                *value = of->fingertip().force_N;
                return;
            }
            // The exposure takes a while, so it is computed only on demand.
            const bool isOfField =
                wanted.rfind("exposure.", 0) != 0 &&
                findFigure(haptics::figuresOf(of->sequence.report), wanted, *value);
            if (!isOfField && !findFigure(of->figures(), wanted, *value))
                fail(MIDAIR_UNKNOWN,
                     "there is no figure \"" + wanted + "\"" + didYouMeanFigure(*of, wanted));
        });
}

midair_status
midair_field_figure_at(const midair_field* field, size_t index, const char** name, double* value)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            const auto& all = of->figures();
            if (index >= all.size())
                fail(MIDAIR_UNKNOWN, fmt::format("index is {}; there are {}", index, all.size()));
            if (name) *name = all[index].first.c_str();
            if (value) *value = all[index].second;
        });
}

midair_status midair_field_text(
    const midair_field* field, const char* name, char* text, size_t size, size_t* needed)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            const haptics::SolveReport& report = of->sequence.report;
            const std::string wanted = textGiven(name, "name", 256);
            if (wanted == "solver") return writeText(report.solver, text, size, needed);
            if (wanted == "stop")
                return writeText(haptics::stopReasonName(report.stop), text, size, needed);
            if (wanted == "message") return writeText(report.message, text, size, needed);
            if (wanted == "feeling")
                return writeText(of->fingertip().feeling(), text, size, needed);
            fail(MIDAIR_UNKNOWN,
                 "there is no text \"" + wanted +
                     "\"; there are solver, stop, message and feeling");
        });
}

midair_status midair_field_pressures(
    const midair_field* field, size_t index, const double* places, size_t count, float* pressures)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            const Eigen::VectorXcf& q = fieldAt(*of, index);
            given(pressures, "pressures");
            const Eigen::VectorXcf p =
                haptics::pressureAt(placesOf(places, count), *of->array, of->medium, q);
            std::copy_n(p.data(), p.size(), reinterpret_cast<std::complex<float>*>(pressures));
        });
}

midair_status
midair_field_felt(const midair_field* field, const double* places, size_t count, float* pressures)
{
    return called(
        [&]
        {
            const auto of = fields().find(field);
            given(pressures, "pressures");
            const Eigen::VectorXd square = haptics::meanSquarePressure(
                placesOf(places, count), *of->array, of->medium, of->sequence.fields);
            for (Eigen::Index l = 0; l < square.size(); ++l)
                pressures[l] = static_cast<float>(std::sqrt(square[l]));
        });
}

midair_status midair_field_close(midair_field* field)
{
    return called([&] { fields().take(field); });
}
