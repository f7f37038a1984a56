#include "haptics/scattering/SceneScattering.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/scattering/RigidBody.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

void requireOutside(const ClosedBody& body, const Eigen::Matrix3Xd& places, const char* what)
{
    for (Eigen::Index i = 0; i < places.cols(); ++i)
        if (body.isInside(places.col(i)))
            throw base::InputError(
                fmt::format("{} {} at ({:.4f}, {:.4f}, {:.4f}) m is inside the body",
                            what,
                            i,
                            places(0, i),
                            places(1, i),
                            places(2, i)));
}

} // namespace

ScatteringFigures scatteringOf(const ClosedBody& body,
                               const std::vector<Eigen::Matrix3Xd>& points,
                               const std::vector<Eigen::VectorXcf>& fields,
                               const TransducerArray& array,
                               const Medium& medium,
                               int threads,
                               const base::StopToken& stop)
{
    requireOutside(body, array.positions, "transducer");
    for (const Eigen::Matrix3Xd& of : points)
        requireOutside(body, of, "point");
    const RigidBody rigid(body, medium.wavelength(array.frequency_Hz), threads, stop);
    ScatteringFigures figures;
    figures.elements = rigid.body().size();
    double off2 = 0.0, free2 = 0.0, with2 = 0.0, count = 0.0;
    for (std::size_t k = 0; k < fields.size(); ++k)
    {
        const IncidentField incident =
            incidentField(rigid.places(), rigid.normals(), array, medium, fields[k], threads, stop);
        Eigen::VectorXcd onBody;
        const GmresReport report = rigid.solve(incident, onBody, stop);
        figures.iterations = std::max(figures.iterations, report.iterations);
        figures.residual = std::max(figures.residual, report.residual);
        const Eigen::VectorXcd alone =
            pressureAt(points[k], array, medium, fields[k], threads, stop)
                .cast<std::complex<double>>();
        figures.withBody_Pa.emplace_back(alone + rigid.scattered(points[k], onBody, threads));
        for (Eigen::Index l = 0; l < alone.size(); ++l)
        {
            const double was = std::abs(alone[l]), is = std::abs(figures.withBody_Pa.back()[l]);
            if (!(was > 0.0)) continue;
            off2 += (is / was - 1.0) * (is / was - 1.0);
            figures.worst = std::max(figures.worst, std::abs(is / was - 1.0));
            free2 += was * was;
            with2 += is * is;
            count += 1.0;
        }
    }
    if (count == 0.0) return figures;
    figures.rms = std::sqrt(off2 / count);
    figures.level = std::sqrt(with2 / free2);
    return figures;
}

} // namespace midair::haptics
