#include "samples/tools/solve/SolveScatterer.h"

#include "haptics/base/InputError.h"
#include "haptics/scattering/RigidBody.h"
#include "haptics/surface/ObjReader.h"
#include "samples/tools/solve/SolveFiles.h"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace midair::samples
{

namespace
{

/// The fields that have points, and these.
struct Played
{
    explicit Played(const haptics::FieldSequence& sequence)
    {
        for (std::size_t k = 0; k < sequence.fields.size(); ++k)
        {
            const haptics::ControlPoints& part =
                sequence.parts[std::min(k, sequence.parts.size() - 1)];
            if (part.size() == 0 || sequence.fields[k].isZero(0.0f)) continue;
            points.push_back(part.positions);
            fields.push_back(sequence.fields[k]);
        }
    }

    std::vector<Eigen::Matrix3Xd> points;
    std::vector<Eigen::VectorXcf> fields;
};

} // namespace

haptics::ScatteringFigures
scatteredBy(const std::string& file, const Solution& solution, int threads)
{
    const haptics::TransducerArray& array = solution.scene.array;
    const haptics::Medium& medium = solution.scene.medium;
    try
    {
        const haptics::ClosedBody body = haptics::RigidBody::divided(
            haptics::readObj(file), medium.wavelength(array.frequency_Hz));
        std::fprintf(stderr,
                     "midair-solve: \"%s\" has %ld triangles and takes %.0f MB\n",
                     file.c_str(),
                     static_cast<long>(body.size()),
                     1e-6 * haptics::RigidBody::bytesFor(body.size()));
        const Played played(solution.sequence);
        return haptics::scatteringOf(body, played.points, played.fields, array, medium, threads);
    }
    catch (const base::InputError& error)
    {
        throw base::InputError("--scatterer " + file + ": " + error.what());
    }
}

void writeScattering(const std::string& path,
                     const haptics::ScatteringFigures& figures,
                     const Solution& solution)
{
    TextFile file(path);
    file.line("field,x_m,y_m,z_m,with_re_Pa,with_im_Pa");
    const Played played(solution.sequence);
    for (std::size_t k = 0; k < figures.withBody_Pa.size(); ++k)
        for (Eigen::Index l = 0; l < figures.withBody_Pa[k].size(); ++l)
            file.line("{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}",
                      k + 1,
                      played.points[k](0, l),
                      played.points[k](1, l),
                      played.points[k](2, l),
                      figures.withBody_Pa[k][l].real(),
                      figures.withBody_Pa[k][l].imag());
    file.finish();
}

void printScattering(const haptics::ScatteringFigures& figures)
{
    std::printf("scatterer   the points change by %.2f %% rms, at most %.2f %%; level %.1f %% (%ld "
                "triangles, %d iterations)\n",
                100.0 * figures.rms,
                100.0 * figures.worst,
                100.0 * figures.level,
                static_cast<long>(figures.elements),
                figures.iterations);
    if (figures.residual > haptics::RigidBody::kResidual)
        std::printf("note        the body's equations are solved to %.2g only\n", figures.residual);
}

} // namespace midair::samples
